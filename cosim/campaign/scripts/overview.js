"use strict";  // of all runs: probabilities, histograms, envelopes
const overview = {turns: 0};
const key_of = (colours) => made("ul", {class: "key"}, ...VARIANTS.map(({name}, i) => made("li", {},
  swatch({colour: colours.colours[i % colours.colours.length], dash: LINES[i % LINES.length]}), made("span", {}, name))));

function draw_overview() {
  const colours = scheme(), figures = [];
  opened.listeners = [];
  if (PAGE.overview.probability.length) figures.push(...probability(colours));
  if (PAGE.overview.histograms.length) figures.push(...histograms(colours));
  if (PAGE.overview.envelopes) figures.push(...envelopes(colours));
  if (PAGE.overview.sweep) figures.push(...sweep(colours));
  opened.listeners.forEach((listener) => opened.place !== null && listener());
  return put("overview", figures).then(() => { document.documentElement.dataset.overview = String(++overview.turns); });
}

function zoomable(plot, back, dimensions = "both") {
  const zoom = new models.BoxZoomTool({dimensions});
  plot.add_tools(zoom, new models.PanTool({dimensions}), new models.WheelZoomTool({dimensions}));
  plot.toolbar.active_drag = zoom;
  plot.on_event("doubletap", back);
}

function telling(plot, box, lines) {
  plot.on_event("mousemove", (event) => tell(box, event, lines(event)));
  plot.on_event("mouseleave", () => tell(box, null, null));
}

const percent = (share) => `${(100 * share).toFixed(2)} %`;
function probability(colours) {
  const {Range1d, ColumnDataSource} = models, found = PAGE.overview.probability;
  const box = made("div", {class: "plot"});
  box.style.height = `${70 + 34 * found.length}px`;
  const plot = frame(colours, {x: {range: new Range1d({start: 0, end: 100}), label: "success, % (line: 95 % interval)"},
    y: {range: new Range1d({start: found.length - 0.4, end: -0.6}), ticks: VARIANTS.map(({name}, i) => [i, name.length > 16 ? `${name.slice(0, 15)}…` : name])},
    options: {min_border_left: 120}});
  found.forEach(({p, interval: [low, high]}, i) => {
    const colour = colours.colours[i % colours.colours.length];
    const source = new ColumnDataSource({data: {y: [i, i], x: [100 * low, 100 * high], p: [100 * (p ?? NaN), NaN]}});
    glyph(plot, "Line", source, {x: "@x", y: "@y", line_width: 5, line_color: colour, line_alpha: 0.7});
    glyph(plot, "Scatter", source, {x: "@p", y: "@y", marker: {value: "diamond"}, size: 13, fill_color: colour, line_color: colours.ink});
  });
  zoomable(plot, () => plot.x_range.setv({start: 0, end: 100}), "width");
  telling(plot, box, ({y}) => {
    const i = Math.round(y), one = found[i];
    return one ? [VARIANTS[i].name, one.p === null ? "no judged run" : `${percent(one.p)}: ${one.successes} of ${one.judged} judged runs`,
                  `95 % interval ${percent(one.interval[0])} to ${percent(one.interval[1])}`] : null;
  });
  one("probability").replaceChildren(box);
  return [[box, plot]];
}

function histograms(colours) {
  const {Range1d, ColumnDataSource, Span} = models;
  const made_ones = PAGE.overview.histograms.map(({name, unit, log, edges, counts, endless}) => {
    const most = Math.max(1, ...counts.flat()), box = made("div", {class: "plot"});
    const full = [{start: edges[0], end: edges[edges.length - 1]}, {start: 0, end: most * 1.05}];
    const plot = frame(colours, {x: {range: new Range1d(full[0]), log, label: named({name, unit}) + (endless ? `; not shown: ${endless} infinite` : "")},
                                 y: {range: new Range1d(full[1]), label: "runs"}});
    counts.forEach((found, i) => {
      const colour = colours.colours[i % colours.colours.length];
      const source = new ColumnDataSource({data: {left: edges.slice(0, -1), right: edges.slice(1), top: found}});
      glyph(plot, "Quad", source, {left: "@left", right: "@right", top: "@top", bottom: 0, fill_color: colour, fill_alpha: 0.18, line_color: null});
      const steps = new ColumnDataSource({data: {x: edges.flatMap((edge) => [edge, edge]), y: [0, ...found.flatMap((count) => [count, count]), 0]}});
      glyph(plot, "Line", steps, {x: "@x", y: "@y", line_color: colour, line_width: 1.6, line_dash: LINES[i % LINES.length]});
    });
    const m = PAGE.metrics.findIndex((figure) => figure.name === name);
    const span = new Span({location: edges[0], dimension: "height", line_color: colours.ink, line_width: 2, line_dash: [4, 3], visible: false, level: "overlay"});
    plot.add_layout(span);
    opened.listeners.push(() => {
      const value = metric(opened.v, m, opened.place);
      span.setv({visible: Number.isFinite(value), location: Number.isFinite(value) ? value : edges[0]});
    });
    zoomable(plot, () => { plot.x_range.setv(full[0]); plot.y_range.setv(full[1]); });
    telling(plot, box, ({x}) => {
      const bin = edges.findLastIndex((edge) => edge <= x);
      return bin >= 0 && bin < edges.length - 1 ? [`${named({name, unit})}: ${digits(edges[bin], 4)} to ${digits(edges[bin + 1], 4)}`,
        ...VARIANTS.map((variant, i) => `${variant.name}: ${counts[i][bin]} runs`)] : null;
    });
    return {box, plot, figure: made("figure", {"aria-label": `Histogram of ${name}`}, made("h3", {}, named({name, unit})), box)};
  });
  one("histograms").replaceChildren(key_of(colours), made("div", {class: "grid"}, ...made_ones.map(({figure}) => figure)));
  return made_ones.map(({box, plot}) => [box, plot]);
}

function envelopes(colours) {
  const {Range1d, ColumnDataSource} = models, {start, stop, panels, variants} = PAGE.overview.envelopes;
  const time = new Range1d({start, end: stop}), figures = [], found = [];
  const back = () => time.setv({start, end: stop});
  const decoded_ones = variants.map(({times, bands, flying}) => ({times: Array.from(numbers(times)), flying: Array.from(numbers(flying)),
    bands: Object.fromEntries(Object.entries(bands).map(([name, rows]) => [name, rows.map((row) => Array.from(numbers(row)))]))}));
  for (const {name, label, bend} of panels) {
    const to = bend ? (value) => Math.asinh(value / bend) : (value) => value;  // straight about 0, logarithmic far off
    const values = decoded_ones.flatMap(({bands}) => bands[name] ? [...bands[name][0], ...bands[name][4]] : []);
    const y = limits(values.filter(Number.isFinite).map(to), false), range = new Range1d(y);
    const powers = [...Array(14).keys()].map((k) => bend * 10 ** k).filter((value) => to(value) <= Math.max(-y.start, y.end));
    if (to(bend) < 0.07 * (y.end - y.start)) powers.shift();  // next to 0
    const ticks = bend ? [...powers.map((value) => -value).reverse(), 0, ...powers].map((value) => [to(value), String(Number(value.toPrecision(3)))]) : undefined;
    VARIANTS.forEach((variant, v) => {
      const {times, bands} = decoded_ones[v], box = made("div", {class: "plot"}), rows = bands[name];
      if (!rows) return;
      const plot = frame(colours, {x: {range: time, label: "time (s)"}, y: {range, label, ticks}}), colour = colours.colours[v % colours.colours.length];
      const source = new ColumnDataSource({data: {x: times, ...Object.fromEntries(rows.map((row, i) => [`q${i}`, row.map(to)]))}});
      for (const [low, high, alpha] of [["@q0", "@q4", 0.18], ["@q1", "@q3", 0.38]])
        glyph(plot, "VArea", source, {x: "@x", y1: low, y2: high, fill_color: colour, fill_alpha: alpha});
      glyph(plot, "Line", source, {x: "@x", y: "@q2", line_color: colour, line_width: 2});
      const mine = new ColumnDataSource({data: {x: [], y: []}});
      glyph(plot, "Line", mine, {x: "@x", y: "@y", line_color: colours.ink, line_width: 1.6, line_dash: [5, 3]});
      opened.listeners.push(() => {
        const curve = opened.v === v && error_of(v, opened.place, name);
        mine.data = curve ? {x: Array.from(curve.times), y: Array.from(curve.values, to)} : {x: [], y: []};
      });
      zoomable(plot, () => { back(); range.setv(y); });
      telling(plot, box, ({x}) => {
        const i = indexAt(times, x);
        return i < 0 || x > times[times.length - 1] ? null : [`${variant.name} at ${digits(times[i], 4)} s`, `median ${digits(rows[2][i], 4)}`,
          `5 to 95 %: ${digits(rows[1][i], 4)} to ${digits(rows[3][i], 4)}`, `all: ${digits(rows[0][i], 4)} to ${digits(rows[4][i], 4)}`];
      });
      found.push([box, plot]);
      figures.push(made("figure", {"aria-label": `${label} of ${variant.name}: quantiles over time`}, made("h3", {}, `${variant.name}: ${label}`), box));
    });
  }
  const box = made("div", {class: "plot"}), plot = frame(colours, {x: {range: time, label: "time (s)"}, y: {range: new Range1d({start: -3, end: 103}), label: "still flying (%)"}});
  decoded_ones.forEach(({times, flying}, v) => {
    const early = times.length && times[times.length - 1] < stop * (1 - 1e-9);
    const data = {x: early ? [...times, times[times.length - 1], stop] : times, y: early ? [...flying, 0, 0] : flying};
    glyph(plot, "Line", new ColumnDataSource({data}), {x: "@x", y: "@y", line_width: 2, line_color: colours.colours[v % colours.colours.length], line_dash: LINES[v % LINES.length]});
  });
  zoomable(plot, back, "width");
  telling(plot, box, ({x}) => [`at ${digits(x, 4)} s still flying`, ...decoded_ones.map(({times, flying}, v) => {
    const i = indexAt(times, x);
    return `${VARIANTS[v].name}: ${i < 0 || x > times[times.length - 1] + 1e-9 ? 0 : digits(flying[i], 4)} %`;
  })]);
  found.push([box, plot]);
  figures.push(made("figure", {"aria-label": "Share of the runs that still fly, over time"}, made("h3", {}, "Still flying (%)"), key_of(colours), box));
  one("envelopes").replaceChildren(made("div", {class: "grid"}, ...figures));
  return found;
}
