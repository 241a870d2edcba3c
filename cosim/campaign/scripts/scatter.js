"use strict";  // a figure of the runs of a variant against each draw; panels share its axis
const MOST_PANELS = 12, NEAR = 14;  // px
const look_at = {v: 0, m: 0, few: true, panels: [], y: null, log: false, runs: [], turns: 0, waiting: false};

const wide = (values) => {  // whether positive values want a logarithmic axis
  const found = Float64Array.from(values.filter(Number.isFinite)).sort();
  return found.length > 0 && found[0] > 0 && found[found.length - 1] > 50 * found[Math.floor(found.length / 10)];
};

function limits(values, log) {
  let low = Infinity, high = -Infinity;
  for (const value of values) { low = Math.min(low, value); high = Math.max(high, value); }
  if (low > high) return {start: log ? 1 : 0, end: log ? 10 : 1};
  if (log) return {start: low / (high / low) ** 0.04 / 1.02, end: high * (high / low) ** 0.04 * 1.02};
  const room = (high - low) * 0.04 || Math.abs(high) * 0.05 || 1;
  return {start: low - room, end: high + room};
}

async function scatter() {
  const colours = scheme(), {v, m} = look_at, variant = VARIANTS[v];
  const figure = PAGE.metrics[m], y = Array.from(FLOWN, (_, place) => figure ? metric(v, m, place) : succeeded(v, place) ? 1 : 0);
  look_at.log = Boolean(figure) && wide(y);
  look_at.runs = [...FLOWN.keys()].filter((place) => judged(v, place) && Number.isFinite(y[place]) && (!look_at.log || y[place] > 0));
  look_at.values = y;
  const {Range1d, ColumnDataSource, BoxZoomTool, PanTool, WheelZoomTool} = models;
  look_at.full = limits(look_at.runs.map((place) => y[place]), look_at.log);
  look_at.y = new Range1d(look_at.full);
  const draws = variant.strongest.slice(0, look_at.few ? 4 : MOST_PANELS);
  const parts = [true, false].map((good) => look_at.runs.filter((place) => succeeded(v, place) === good));
  const sources = parts.map((places) => new ColumnDataSource({data: {y: places.map((place) => y[place]),
    ...Object.fromEntries(draws.map((d) => [`x${d}`, places.map((place) => variant.draws[d].values[place])]))}}));
  look_at.panels = draws.map((d) => {
    const {words, values} = variant.draws[d];
    const full = words ? {start: -0.5, end: words.length - 0.5} : limits(look_at.runs.map((place) => values[place]), false);
    const x = new Range1d(full);
    const plot = frame(colours, {
      x: {range: x, ticks: words && words.slice(0, 30).map((word, i) => [i, word])},
      y: {range: look_at.y, log: look_at.log, label: figure ? named(figure) : "success"},
      options: {lod_threshold: 500, lod_factor: 8, lod_interval: 200, lod_timeout: 250}});
    glyph(plot, "Scatter", sources[0], {x: `@x${d}`, y: "@y", marker: {value: "circle"}, size: 4, line_color: null,
                                        fill_color: colours.colours[0], fill_alpha: 0.6});
    glyph(plot, "Scatter", sources[1], {x: `@x${d}`, y: "@y", marker: {value: "cross"}, line_color: colours.colours[1],
                                        ...(parts[1].length < 100 ? {size: 10, line_width: 2} : {size: 6, line_width: 1.2, line_alpha: 0.75})});
    const rings = ["accent", "ink"].map((colour, i) => {
      const source = new ColumnDataSource({data: {x: [], y: []}});
      glyph(plot, "Scatter", source, {x: "@x", y: "@y", marker: {value: "circle"}, size: i ? 12 : 16, fill_color: null,
                                      line_color: colours[colour], line_width: i ? 1.5 : 3});
      return source;
    });
    const zoom = new BoxZoomTool(), pan = new PanTool(), wheel = new WheelZoomTool();
    plot.add_tools(zoom, pan, wheel);
    plot.toolbar.active_drag = one("drag").value === "pan" ? pan : zoom;
    const box = made("div", {class: "plot tall"}), panel = {d, plot, box, x, full, rings, zoom, pan, wheel};
    plot.on_event("mousemove", (event) => point(panel, event));
    plot.on_event("mouseleave", () => point(panel, null));
    plot.on_event("tap", (event) => { const place = nearest(panel, event, 2); if (place !== null) open_run(v, place); });
    plot.on_event("doubletap", whole_cloud);
    x.on_change([x.properties.start, x.properties.end], listSoon);
    return panel;
  });
  look_at.y.on_change([look_at.y.properties.start, look_at.y.properties.end], listSoon);
  one("clouds").replaceChildren(...look_at.panels.map(({d, box}) => {
    const strength = variant.correlations[d];
    return made("figure", {"aria-label": `${figure ? figure.name : "success"} against ${PAGE.draws[d].label}`},
                made("h3", {}, PAGE.draws[d].label, strength === null ? "" : made("small", {},
                     ` rank correlation with failure ${strength.toFixed(2).replace("-", "−")}`)), box);
  }));
  const endless = FLOWN.length - look_at.runs.length;
  one("missing").textContent = endless ? `Not drawn: ${endless} runs without a finite value, or not judged.` : "";
  await put("clouds", look_at.panels.map(({box, plot}) => [box, plot]));
  ring(0, opened.v === v ? opened.place : null);
  document.documentElement.dataset.clouds = String(++look_at.turns);
  list();
}

function nearest({plot, x, d}, event, reach = 1) {  // the run next to the cursor, within some pixels
  const {values} = VARIANTS[look_at.v].draws[d], {y, log} = look_at;
  const along = log ? Math.log10 : (value) => value;
  const across = plot.inner_width / (x.end - x.start), up = plot.inner_height / (along(y.end) - along(y.start));
  const level = along(event.y);
  let best = null, least = (NEAR * reach) ** 2;
  for (const place of look_at.runs) {
    const distance = ((values[place] - event.x) * across) ** 2 + ((along(look_at.values[place]) - level) * up) ** 2;
    if (distance < least) [best, least] = [place, distance];
  }
  return best;
}

function point(panel, event) {
  const place = event && nearest(panel, event);
  tell(panel.box, event, place === null ? null : described(look_at.v, place, look_at.m, panel.d));
  if (place !== look_at.pointed) ring(1, place);
  look_at.pointed = place;
}

function ring(which, place) {  // one run, in all panels
  for (const {d, rings} of look_at.panels)
    rings[which].data = place === null || !Number.isFinite(look_at.values[place]) ? {x: [], y: []}
      : {x: [VARIANTS[look_at.v].draws[d].values[place]], y: [look_at.values[place]]};
}

function whole_cloud() {
  look_at.y.setv(look_at.full);
  for (const {x, full} of look_at.panels) x.setv(full);
}

function zoomed() {  // the ranges that are not as at first
  const differs = (range, full) => range.start > full.start + 1e-9 || range.end < full.end - 1e-9;
  return {y: look_at.y && differs(look_at.y, look_at.full),
          panels: look_at.panels.filter(({x, full}) => differs(x, full))};
}
