"use strict";  // what the page knows of each run: its place is a row of the columns of its variant
const KINDS = {f8: Float64Array, f4: Float32Array, u2: Uint16Array};
const FLOWN = numbers(PAGE.numbers, Uint32Array);  // run numbers, ascending
const columns = new Map();
function column({kind, at}) {
  if (!columns.has(at)) columns.set(at, numbers(PAGE.columns[at], KINDS[kind]));
  return columns.get(at);
}

const VARIANTS = PAGE.variants.map((packed) => ({
  ...packed, worst: numbers(packed.worst, Uint32Array), status: numbers(packed.status, Uint8Array),
  message: numbers(packed.message, Uint32Array), departed: numbers(packed.departed),
  criteria: packed.criteria.map((text) => numbers(text, Uint8Array)), metrics: packed.metrics.map((text) => numbers(text)),
  draws: packed.draws.map((draw) => ({words: draw.words, values: column(draw)}))}));
for (const variant of VARIANTS) {
  variant.rank = new Uint32Array(FLOWN.length);
  variant.worst.forEach((place, rank) => { variant.rank[place] = rank; });
}

const status = (v, place) => PAGE.statuses[VARIANTS[v].status[place]];
const judged = (v, place) => PAGE.judged.includes(status(v, place));
const succeeded = (v, place) => VARIANTS[v].criteria[0][place] === 1;
const missed = (v, place) => PAGE.criteria.filter((_, i) => !VARIANTS[v].criteria[i + 1][place]).map(({name}) => name);
const metric = (v, m, place) => VARIANTS[v].metrics[m] ? VARIANTS[v].metrics[m][place] : NaN;
const named = ({name, unit}) => unit && unit !== "1" ? `${name} (${unit})` : name;

function message(v, place) {
  const packed = PAGE.messages[VARIANTS[v].message[place]];
  if (!packed) return "";
  const [template, ...found] = packed.split("|");
  return PAGE.templates[template].map((words, i) => words + (found[i] || "")).join("");
}

function ended(v, place) {  // in a few words
  const {departed} = VARIANTS[v], how = status(v, place);
  const at = Number.isFinite(departed[place]) ? ` at ${digits(departed[place], 5)} s` : "";
  if (succeeded(v, place)) return "success";
  return how === "finished" ? `finished, but not: ${missed(v, place).join(", ")}` : how + at;
}

function value_drawn(v, d, place, exact = false) {
  const {words, values} = VARIANTS[v].draws[d];
  return words ? words[values[place]] : exact ? written(values[place]) : digits(values[place], 6);
}

function written(x) {  // a number with all its digits, as Python writes it
  if (!Number.isFinite(x)) return Number.isNaN(x) ? "nan" : x > 0 ? "inf" : "-inf";
  const [figures, power] = x.toExponential().split("e"), p = Number(power);
  if (p < -4 || p >= 16) return `${figures}e${p < 0 ? "-" : "+"}${String(Math.abs(p)).padStart(2, "0")}`;
  return Object.is(x, -0) ? "-0.0" : Number.isInteger(x) ? `${x}.0` : String(x);
}

const quoted = (word) => /^[\w@%+=:,./-]+$/.test(word) ? word : `'${word.replaceAll("'", "'\"'\"'")}'`;
function command(v, place) {
  const value = (name) => name === "run" ? String(FLOWN[place]) : value_drawn(v, PAGE.draws.findIndex((d) => d.name === name), place, true);
  return VARIANTS[v].command.map((word) => quoted(typeof word === "string" ? word : word[0] + value(word[1]))).join(" ");
}

// What the cursor points at: lines of text beside it.
function tell(box, event, lines) {
  const hover = one("hover");
  hover.hidden = !lines;
  if (!lines) return;
  hover.replaceChildren(...lines.map((line) => made("div", {}, line)));
  const {left, top} = box.getBoundingClientRect(), room = document.documentElement.clientWidth - hover.offsetWidth - 8;
  hover.style.left = `${Math.max(4, Math.min(left + event.sx + 14, room))}px`;
  hover.style.top = `${top + event.sy + (top + event.sy > innerHeight * 0.6 ? -hover.offsetHeight - 10 : 14)}px`;
}

const MOST_TOLD = 8;  // draws; the run that is open shows all
function described(v, place, m, first) {
  const told = [first, ...VARIANTS[v].strongest.filter((d) => d !== first)].slice(0, MOST_TOLD);
  return [`run ${FLOWN[place]}, ${VARIANTS[v].name}: ${ended(v, place)}`,
          ...(PAGE.metrics[m] ? [`${named(PAGE.metrics[m])}: ${digits(metric(v, m, place), 5)}`] : []),
          ...told.map((d) => `${PAGE.draws[d].label}: ${value_drawn(v, d, place)}`),
          PAGE.draws.length > told.length ? `and ${PAGE.draws.length - told.length} more; click to open` : "click to open"];
}

const documents = new Map();
async function put(group, figures) {  // [element, plot] each, in place of those that the group has
  if (documents.has(group)) documents.get(group).clear();
  const made = new Document();
  documents.set(group, made);
  figures.forEach(([, plot]) => made.add_root(plot));
  await embed(made, figures.map(([box]) => box));
}

function glyph(plot, kind, source, options) {
  const fields = Object.fromEntries(Object.entries(options).map(([name, value]) =>
    [name, typeof value === "string" && value.startsWith("@") ? {field: value.slice(1)} : value]));
  plot.add_renderers(new models.GlyphRenderer({data_source: source, glyph: new models[kind](fields)}));
}
