"use strict";  // the curves of flights: panels that share the time, and what is chosen of them
const DEGREES = 180 / Math.PI, MAXIMUM_NAMES = 2000, LARGEST = 4e307, LONG_KEY = 12;
let DATA = null, span = [0, 1];  // flights; from when to when (s)
const decoded = new Map();
function course(run, name) {  // times and values of a curve, in the unit that is shown
  const packed = DATA.runs[run].curves[name];
  if (!packed) return null;
  const key = `${run}/${state.angles}/${name}`;
  if (!decoded.has(key)) {
    const factor = shownUnit(DATA.signals[name].unit)[1], start = DATA.runs[run].start, scale = packed.scale ?? 1;
    decoded.set(key, packed.values ? {x: packed.times, y: packed.values.map((v) => factor * v)}
      : {x: Float64Array.from(numbers(packed.t), (t) => start + t),
         y: Float64Array.from(numbers(packed.y), (v) => factor * scale * (packed.base / scale + v))});
  }
  return decoded.get(key);
}

function shownUnit(unit) {  // angles and their rates; what is per radian, or of a power of them, stays as it is
  if (state.angles === "deg" && /^rad(?=$|[/ .*·])/.test(unit) && unit.lastIndexOf("rad") === 0)
    return [`deg${unit.slice(3)}`, DEGREES];
  return [unit, 1];
}

const alike = (a, b) => a.length === b.length && a.every((value, i) => Object.is(value, b[i]));

const state = {chosen: new Set(), angles: "deg", hidden: new Set(), printing: false,
               range: null, panels: [], document: null, waiting: false};

function indexAt(x, t) {  // the last point at or before t; -1 before the first
  let low = 0, high = x.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (x[middle] <= t + 1e-9) low = middle + 1; else high = middle;
  }
  return low - 1;
}

function valueAt({x, y}, t) {
  const i = indexAt(x, t);
  if (i < 0 || t > x[x.length - 1] + 1e-9) return NaN;
  if (i === x.length - 1) return y[i];
  return y[i] + (y[i + 1] - y[i]) * (t - x[i]) / (x[i + 1] - x[i] || 1);
}

function seconds(t) {  // as exact as the picture, however far from 0
  const decimals = Math.ceil(6 - Math.log10(span[1] - span[0] || 1));
  return String(Number(t.toFixed(Math.min(Math.max(decimals, 0), 20))));
}

function united(kind) {  // the marks of a kind, those of all flights in one: shades over each other would darken
  const found = [];
  const all = DATA.runs.flatMap((run) => run.marks.filter((mark) => mark.kind === kind));
  for (const mark of all.sort((a, b) => a.begin - b.begin)) {
    const last = found[found.length - 1];
    if (!last || mark.begin > (last.end === null ? last.begin : last.end)) found.push({...mark});
    else if (last.end !== null) last.end = Math.max(last.end, mark.end === null ? mark.begin : mark.end);
  }
  return found;
}

// Moments are lines. Windows shade a panel faintly, and each kind of them has its own strip at the bottom.
const STRIP = 5;  // px
function marksOf(plot) {
  const {BoxAnnotation, Span} = models;
  let strips = 0;
  DATA.kinds.forEach((kind, k) => {
    const colour = SHADES[k % SHADES.length], found = united(kind.name);
    const common = {visible: !state.hidden.has(kind.name), level: "underlay", tags: [kind.name]};
    const bottom = found.some((mark) => mark.end !== null) ? strips++ * (STRIP + 1) : 0;
    for (const {begin, end} of found)
      if (end === null)
        plot.add_layout(new Span({location: begin, dimension: "height", line_color: colour, line_width: 2,
                                  line_dash: LINES[k % LINES.length], ...common}));
      else for (const [alpha, place] of [[dark() ? 0.1 : 0.12, {}], [0.9, {bottom, top: bottom + STRIP, bottom_units: "screen",
                                                                         top_units: "screen"}]])
        plot.add_layout(new BoxAnnotation({left: begin, right: end, fill_color: colour, fill_alpha: alpha, line_color: null,
                                           ...place, ...common}));
  });
}

function panelPlot(panel, curves, colours) {
  const {Range1d, Line, Scatter, GlyphRenderer, ColumnDataSource, BoxZoomTool, PanTool, WheelZoomTool, SaveTool, Span} = models;
  const plot = frame(colours, {x: {range: state.range, label: "time (s)", exact: true},
                               y: {range: new Range1d({start: 0, end: 1}), label: panel.unitShown}});
  marksOf(plot);
  for (const {course, colour, dash, width} of curves) {
    const place = {x: {field: "x"}, y: {field: "y"}, line_color: colour};
    plot.add_renderers(new GlyphRenderer({
      data_source: new ColumnDataSource({data: course}),
      glyph: course.x.length > 1 ? new Line({...place, line_dash: dash, line_width: width})
        : new Scatter({...place, fill_color: colour, size: 8})}));
  }
  const cursor = new Span({location: span[0], dimension: "height", line_color: colours.ink, line_width: 1, line_dash: [3, 3],
                           visible: false, level: "overlay"});
  plot.add_layout(cursor);
  const zoom = new BoxZoomTool({dimensions: "width"}), pan = new PanTool({dimensions: "width"});
  plot.add_tools(zoom, pan, new WheelZoomTool({dimensions: "width"}), new SaveTool());
  plot.toolbar.active_drag = zoom;
  plot.on_event("mousemove", (event) => look(event.x));
  plot.on_event("mouseleave", () => look(null));
  plot.on_event("doubletap", whole);
  return {...panel, plot, curves, cursor};
}

function swatch(curve) {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  const path = document.createElementNS("http://www.w3.org/2000/svg", "line");
  for (const [name, value] of Object.entries({x1: 0, y1: 4, x2: 28, y2: 4, stroke: curve.colour, "stroke-width": 2.5,
                                              "stroke-dasharray": curve.dash.join(" ")})) path.setAttribute(name, value);
  svg.setAttribute("aria-hidden", "true");
  svg.append(path);
  return svg;
}

async function draw() {
  const style = scheme(), colours = style.colours;
  const several = DATA.runs.length > 1, turn = ++drawn;
  const panels = [], figures = [];
  for (const panel of DATA.panels) {
    const names = panel.curves.filter((name) => state.chosen.has(name));
    if (!names.length) continue;
    const curves = [];
    names.forEach((name, i) => DATA.runs.forEach((run, r) => {
      const found = course(r, name);
      if (!found) return;
      const same = curves.find((c) => c.name === name && alike(c.course.y, found.y) && alike(c.course.x, found.x));
      if (same) { same.runs.push(run.name); return; }  // not the same curve over itself
      const kind = several ? r : i, again = Math.floor(r / colours.length);  // how often all colours were used before
      curves.push({name, runs: [run.name], course: found, colour: colours[kind % colours.length],
                   dash: LINES[(several && names.length > 1 ? i + again * names.length : kind) % LINES.length],
                   width: several || i === 0 ? 1.8 : 1.6, output: made("output")});
    }));
    for (const curve of curves)
      curve.label = !several || curve.runs.length === DATA.runs.length ? curve.name : `${curve.runs.join(", ")}: ${curve.name}`;
    const units = [...new Set(names.map((name) => shownUnit(DATA.signals[name].unit)[0]))].filter((u) => u && u !== "1");
    const shown = panelPlot({title: panel.title, unitShown: units.join(", ")}, curves, style);
    const box = made("div", {class: "plot"});
    panels.push({...shown, box});
    const described = `${panel.title}: ${curves.map((c) => c.label).join(", ")}${units.length ? `, in ${units.join(", ")}` : ""}`;
    figures.push(made("figure", {"aria-label": described}, made("h3", {}, panel.title + (units.length ? ` (${units.join(", ")})` : "")),
                      made("ul", {class: "key", tabindex: curves.length > LONG_KEY && "0"},
                        ...curves.map((curve) => made("li", {title: DATA.signals[curve.name].description},
                        swatch(curve), made("span", {}, curve.label), curve.output))), box));
  }
  one("charts").replaceChildren(...figures);
  state.panels = panels;
  fit();
  if (state.document) state.document.clear();  // the range goes to the new one
  state.document = new Document();
  panels.forEach((panel) => state.document.add_root(panel.plot));
  await embed(state.document, panels.map((panel) => panel.box));
  document.documentElement.dataset.drawn = String(turn);
}
let drawn = 0;

function tellRange() {
  one("from").value = seconds(state.range.start);
  one("to").value = seconds(state.range.end);
}

function fitSoon() {  // once the tool that changes the time is done with all ranges
  tellRange();
  if (state.waiting) return;
  state.waiting = true;
  requestAnimationFrame(() => { state.waiting = false; fit(); });
}

function fit() {  // each panel's values fill it, within the time that is shown
  const {start, end} = state.range;
  for (const {plot, curves} of state.panels) {
    let low = Infinity, high = -Infinity;
    for (const {course: {x, y}} of curves) {
      const first = Math.max(indexAt(x, start), 0), last = Math.min(indexAt(x, end) + 1, x.length - 1);
      for (let i = first; i <= last; i++) if (Number.isFinite(y[i])) { low = Math.min(low, y[i]); high = Math.max(high, y[i]); }
    }
    if (low > high) [low, high] = [0, 1];
    [low, high] = [Math.max(low, -LARGEST), Math.min(high, LARGEST)];
    const room = (high - low) * 0.06 || Math.abs(high) * 0.05 || 1;
    plot.y_range.setv({start: low - room, end: high + room});
  }
}

function look(t) {  // what the curves are at a time, beside their names
  const there = t !== null && t >= span[0] && t <= span[1];
  if (document.activeElement !== one("at")) one("at").value = there ? seconds(t) : "";
  for (const {curves, cursor} of state.panels) {
    cursor.setv({visible: there, location: there ? t : span[0]});
    for (const curve of curves) curve.output.textContent = there ? digits(valueAt(curve.course, t)) : "";
  }
  const texts = DATA.runs.flatMap((run) => run.marks.filter((m) => !state.hidden.has(m.kind) && there && (
    m.end === null ? Math.abs(t - m.begin) < (state.range.end - state.range.start) / 200 : m.begin <= t && t <= m.end))
    .map((m) => m.text));
  one("now").textContent = there ? `At ${seconds(t)} s: ${[...new Set(texts)].join("; ") || "nothing is marked"}.` : "";
}

function zoom() {
  const [from, to] = ["from", "to"].map((id) => one(id).valueAsNumber);
  if (from < to) state.range.setv({start: from, end: to});
}
function whole() { state.range.setv({start: span[0], end: span[1]}); }

function listNames() {
  const words = one("search").value.toLowerCase().split(/\s+/).filter(Boolean);
  const names = Object.keys(DATA.signals).filter((name) => {
    const text = `${name} ${DATA.signals[name].description} ${DATA.signals[name].unit}`.toLowerCase();
    return words.every((word) => text.includes(word));
  });
  one("names").replaceChildren(...names.slice(0, MAXIMUM_NAMES).map((name) => {
    const {unit, description} = DATA.signals[name];
    const box = made("input", {type: "checkbox", onchange: () => choose([name], box.checked)});
    box.checked = state.chosen.has(name);
    return made("li", {}, made("label", {title: description}, box, made("span", {}, name, " ",
                made("small", {}, `${unit && unit !== "1" ? `${unit} ` : ""}`))));
  }));
  one("count").textContent = `(${state.chosen.size} of ${Object.keys(DATA.signals).length})`;
  return names;
}

function choose(names, wanted) {
  for (const name of names) if (wanted) state.chosen.add(name); else state.chosen.delete(name);
  one("count").textContent = `(${state.chosen.size} of ${Object.keys(DATA.signals).length})`;
  return draw();
}

function listKinds() {
  one("kinds").replaceChildren(made("legend", {}, "Marks"));
  DATA.kinds.forEach((kind, k) => {
    const box = made("input", {type: "checkbox", checked: !state.hidden.has(kind.name), onchange: () => {
      if (box.checked) state.hidden.delete(kind.name); else state.hidden.add(kind.name);
      for (const {plot} of state.panels) for (const mark of [...plot.center, ...plot.renderers])
        if (mark.tags && mark.tags.includes(kind.name)) mark.visible = box.checked;
    }});
    const shade = made("span", {class: "swatch", "aria-hidden": "true"});
    shade.style.background = SHADES[k % SHADES.length];
    one("kinds").append(made("label", {}, box, shade, made("span", {}, kind.text)));
  });
}

function show(data) {  // these flights in place of those that were shown
  const first = DATA === null;
  DATA = data;
  span = [Math.min(...DATA.runs.map((run) => run.start)), Math.max(...DATA.runs.map((run) => run.end))];
  decoded.clear();
  state.chosen = new Set(DATA.chosen);
  one("view").hidden = false;
  state.range = new models.Range1d({start: span[0], end: span[1] > span[0] ? span[1] : span[0] + 1});
  tellRange();
  state.range.on_change([state.range.properties.start, state.range.properties.end], fitSoon);
  state.hidden.clear();
  for (const {name} of DATA.kinds)  // what happened to some flights only would shade all of them
    if (!DATA.runs.every((run) => run.marks.some((mark) => mark.kind === name))) state.hidden.add(name);
  listKinds();
  listNames();
  one("happened").hidden = !DATA.kinds.length;
  one("angles").parentElement.hidden = !Object.values(DATA.signals).some(({unit}) => shownUnit(unit)[1] !== 1);
  if (first) wire();
  return draw();
}

function wire() {
  one("controls").addEventListener("submit", (event) => event.preventDefault());
  for (const id of ["from", "to"]) one(id).addEventListener("change", zoom);
  one("whole").addEventListener("click", whole);
  one("at").addEventListener("input", () => look(one("at").value === "" ? null : one("at").valueAsNumber));
  one("angles").addEventListener("change", () => { state.angles = one("angles").value; draw(); });
  one("search").addEventListener("input", listNames);
  one("all").addEventListener("click", () => choose(listNames(), true).then(listNames));
  one("none").addEventListener("click", () => choose([...state.chosen], false).then(listNames));
  one("first").addEventListener("click", () => { state.chosen = new Set(DATA.chosen); draw(); listNames(); });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { if (!state.printing) draw(); });
  addEventListener("beforeprint", () => { state.printing = true; });  // drawing would not be done in time
  addEventListener("afterprint", () => { state.printing = false; });
}
