"use strict";  // the runs of a variant as a table: the worst first, or by a column
const ROWS = 12;
const listing = {page: 0, by: "worst", up: true, places: [], waiting: false};

function listed() {  // the runs that fit the filter and the zoom
  const {v, m} = look_at, variant = VARIANTS[v], which = one("which-runs").value, {y, panels} = zoomed();
  const within = (range, value) => value >= range.start && value <= range.end;
  const fits = (place) => which === "all" || (which === "failures" ? !succeeded(v, place) : which === "successes" ? succeeded(v, place)
    : which.startsWith("not ") ? !variant.criteria[Number(which.slice(4)) + 1][place] : status(v, place) === which.slice(7));
  const places = Array.from(variant.worst).filter((place) => fits(place)
    && (!y || within(look_at.y, look_at.values[place]))
    && panels.every(({d, x}) => within(x, variant.draws[d].values[place])));
  const {by, up} = listing;
  const key = {run: (place) => FLOWN[place], figure: (place) => metric(v, m, place), departed: (place) => variant.departed[place]}[by];
  if (key) places.sort((a, b) => {
    const [x, z] = [key(a), key(b)];
    return Number.isNaN(x) || Number.isNaN(z) ? Number.isNaN(x) - Number.isNaN(z) : x === z ? 0 : (x < z ? -1 : 1) * (up ? 1 : -1);
  });
  return {places, narrowed: Boolean(y) || panels.length > 0};
}

function list() {
  const {v, m} = look_at, {places, narrowed} = listed(), last = Math.max(0, Math.ceil(places.length / ROWS) - 1);
  listing.page = Math.min(listing.page, last);
  listing.places = places;
  const begin = listing.page * ROWS, shown = places.slice(begin, begin + ROWS);
  one("listed").textContent = `${places.length.toLocaleString("en")} of ${FLOWN.length.toLocaleString("en")} runs of ${VARIANTS[v].name}`
    + (narrowed ? ", those within the zoom" : "") + (shown.length ? `: ${begin + 1} to ${begin + shown.length}` : "");
  one("earlier").disabled = listing.page === 0;
  one("later").disabled = listing.page === last;
  const heads = [["run", "run"], [null, "ended"], ["departed", "departed at (s)"], ...(PAGE.metrics[m] ? [["figure", named(PAGE.metrics[m])]] : [])];
  const head = heads.map(([by, text]) => made("th", {"aria-sort": by && listing.by === by && (listing.up ? "ascending" : "descending")},
    by ? made("button", {type: "button", onclick: () => sort(by)}, text) : text));
  const rows = shown.map((place) => made("tr", {class: opened.v === v && opened.place === place && "open"},
    made("td", {}, made("button", {type: "button", onclick: () => open_run(v, place)}, String(FLOWN[place]))),
    made("td", {}, ended(v, place)), made("td", {}, digits(VARIANTS[v].departed[place], 5)),
    ...(PAGE.metrics[m] ? [made("td", {}, digits(metric(v, m, place), 5))] : [])));
  const focused = document.activeElement && one("list").contains(document.activeElement) ? document.activeElement.textContent : null;
  one("list").replaceChildren(made("table", {}, made("thead", {}, made("tr", {}, ...head)), made("tbody", {}, ...rows)));
  if (focused !== null) [...one("list").querySelectorAll("button")].find((button) => button.textContent === focused)?.focus();
}

function listSoon() {
  if (listing.waiting) return;
  listing.waiting = true;
  setTimeout(() => { listing.waiting = false; listing.page = 0; list(); }, 150);
}

function sort(by) {
  listing.up = listing.by === by ? !listing.up : by !== "figure";
  listing.by = by;
  listing.page = 0;
  list();
}
