"use strict";  // the run that is open: how it ended, its command, its draws and figures, its curves
const opened = {v: 0, place: null, listeners: []};
const GAP = 65535;
const values_of = (low, step, steps) => Float64Array.from(steps, (k) => k === GAP ? NaN : low + step * k);

const ERRORS = PAGE.curves.errors && PAGE.curves.errors.variants.map((packed) => {
  const runs = numbers(packed.runs, Uint32Array), counts = numbers(packed.counts, Uint16Array), begins = new Map();
  let begin = 0;
  runs.forEach((place, i) => { begins.set(place, [i, begin, counts[i]]); begin += counts[i]; });
  return {begins, curves: Object.fromEntries(Object.entries(packed.curves).map(([name, {low, step, values}]) =>
    [name, {low: numbers(low), step: numbers(step), values: numbers(values, Uint16Array)}]))};
});
const TIMES = PAGE.curves.errors && Float64Array.from(numbers(PAGE.curves.errors.times));
const SIGNALS = new Map(PAGE.curves.signals.map(({variant, place, curves}) => [`${variant}/${place}`, curves]));

function error_of(v, place, name) {  // what is drawn over time of a run
  const found = ERRORS && ERRORS[v].begins.get(place);
  if (!found) return null;
  const [i, begin, count] = found, {low, step, values} = ERRORS[v].curves[name];
  return {times: TIMES.subarray(0, count), values: values_of(low[i], step[i], values.subarray(begin, begin + count))};
}

function curves_of(v, place) {  // name -> times and values
  const found = {};
  for (const name of PAGE.curves.errors ? PAGE.curves.errors.names : []) {
    const curve = error_of(v, place, name);
    if (curve) found[name] = curve;
  }
  for (const [name, [low, step, steps, begin, tick, ticks]] of Object.entries(SIGNALS.get(`${v}/${place}`) || {}))
    found[name] = {times: values_of(begin, tick, numbers(ticks, Uint16Array)), values: values_of(low, step, numbers(steps, Uint16Array))};
  return found;
}

function draw_curves() {
  const {v, place} = opened, beside = one("beside").checked;
  const runs = VARIANTS.map((variant, i) => [i, variant]).filter(([i]) => i === v || (beside && judged(i, place)))
    .sort(([a], [b]) => (b === v) - (a === v)).map(([i, variant]) => {
      const {departed} = variant, early = Number.isFinite(departed[place]);
      return {name: variant.name, start: PAGE.curves.start, end: early ? departed[place] : PAGE.curves.stop, curves: curves_of(i, place),
              marks: early ? [{kind: "early end", text: `${variant.name}: ${message(i, place)}`, begin: departed[place], end: null}] : []};
    });
  const names = Object.keys(PAGE.curves.about).filter((name) => runs.some(({curves}) => curves[name]));
  one("none-kept").hidden = names.length > 0;
  one("view").hidden = !names.length;
  if (!names.length) return;
  const signals = Object.fromEntries(names.map((name) => [name, {unit: PAGE.curves.about[name].unit, description: PAGE.curves.about[name].said}]));
  const varies = (name) => runs.some(({curves}) => curves[name] && curves[name].values.some((value) => value !== curves[name].values[0]));
  show({signals, panels: PAGE.curves.panels, chosen: names.filter(varies),
        kinds: runs.some(({marks}) => marks.length) ? [{name: "early end", text: "early end"}] : [], runs});
}

function table_of(rows) {
  return made("table", {}, made("tbody", {}, ...rows.map(([name, value]) =>
    made("tr", {}, made("td", {}, name), made("td", {}, value)))));
}

function open_run(v, place, move = true) {
  Object.assign(opened, {v, place});
  const variant = VARIANTS[v], good = succeeded(v, place), why = message(v, place);
  one("which").textContent = `Run ${FLOWN[place]}, ${variant.name}`;
  one("ended").textContent = [ended(v, place), why].filter(Boolean).join(": ");
  one("ended").className = good ? "outcome" : "outcome bad";
  one("rank").textContent = `${(variant.rank[place] + 1).toLocaleString("en")} of ${FLOWN.length.toLocaleString("en")}, the worst first`;
  one("worse").disabled = variant.rank[place] === 0;
  one("better").disabled = variant.rank[place] === FLOWN.length - 1;
  one("others").replaceChildren(...VARIANTS.map((other, i) => i === v ? "" : made("button", {type: "button", onclick: () => open_run(i, place)},
    `${other.name}: ${ended(i, place)}`)));
  one("command").textContent = command(v, place);
  one("copied").textContent = "";
  one("drawn").replaceChildren(table_of(PAGE.draws.map(({label}, d) => [label, value_drawn(v, d, place)])));
  one("figures").replaceChildren(table_of([
    ...PAGE.criteria.map(({name, text}, i) => [`${name}: ${text}`, variant.criteria[i + 1][place] ? "met" : "not met"]),
    ...PAGE.metrics.map((figure, m) => [named(figure), digits(metric(v, m, place), 6)])]));
  one("number").value = FLOWN[place];
  one("opened").hidden = false;
  if (look_at.v !== v) { one("variant").value = v; look_at.v = v; scatter(); } else { ring(0, place); list(); }
  draw_curves();
  opened.listeners.forEach((listener) => listener());
  if (move && one("opened").getBoundingClientRect().top > innerHeight * 0.7) one("opened").scrollIntoView({block: "start"});
}

async function copy() {
  let done = true;
  try { await navigator.clipboard.writeText(one("command").textContent); } catch { done = false; }
  if (!done) getSelection().selectAllChildren(one("command"));
  one("copied").textContent = done ? "Copied." : "The command is selected: copy it with Ctrl+C.";
}

function open_number() {  // the run whose number was typed
  const place = FLOWN.indexOf(one("number").valueAsNumber);
  one("unknown").textContent = place >= 0 ? "" : `The page has no run ${one("number").value}.`;
  if (place >= 0) open_run(look_at.v, place);
}
