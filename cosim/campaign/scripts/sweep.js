"use strict";  // a grid: a map of a metric over two swept variables, or its lines over one
const CIVIDIS = [[0, 34, 78], [18, 53, 112], [59, 73, 108], [87, 93, 109], [112, 113, 115], [138, 134, 120], [165, 156, 116],
                 [195, 179, 105], [225, 204, 85], [254, 232, 56]];
const BELOW = "#56b4e9", ABOVE = "#d55e00", NOTHING = "#bbbbbb", MOST_MAPS = 24, MOST_TICKS = 9;

function shade(share) {  // of 0 to 1
  if (Number.isNaN(share)) return NOTHING;
  if (share < -1e-9 || share > 1 + 1e-9) return share < 0 ? BELOW : ABOVE;
  const at = Math.min(Math.max(share, 0), 1) * (CIVIDIS.length - 1), low = Math.min(Math.floor(at), CIVIDIS.length - 2);
  return `rgb(${CIVIDIS[low].map((value, i) => Math.round(value + (at - low) * (CIVIDIS[low + 1][i] - value))).join(",")})`;
}

const is_number = (level) => typeof level === "number";
const places_of = ({levels}) => levels.every(is_number) ? levels : levels.map((_, i) => i);
const level_text = (level) => is_number(level) ? digits(level, 6) : level;
function borders(points) {  // half way between neighbours
  if (points.length === 1) return [points[0] - 0.5, points[0] + 0.5];
  const middles = points.slice(1).map((point, i) => (point + points[i]) / 2);
  return [2 * points[0] - middles[0], ...middles, 2 * points[points.length - 1] - middles[middles.length - 1]];
}
function ticks_of(axis) {
  const every = Math.ceil(axis.levels.length / MOST_TICKS), at = places_of(axis);
  return axis.levels.map((level, i) => [at[i], level_text(level)]).filter((_, i) => i % every === 0).sort(([a], [b]) => a - b);
}

function sweep(colours) {
  const {axes, metrics} = PAGE.overview.sweep;
  const select = made("select", {id: "swept", onchange: () => { overview.metric = Number(select.value); draw_overview().then(() => one("swept").focus()); }},
                      ...metrics.map((figure, m) => option(m, named(figure), m === (overview.metric || 0))));
  const figure = metrics[overview.metric || 0];
  if (!figure) return [];
  const varying = axes.map((_, i) => i).sort((a, b) => (axes[a].levels.length === 1) - (axes[b].levels.length === 1));
  const maps = axes.filter(({levels}) => levels.length > 1).length > 1;
  const values = figure.values.map((text) => numbers(text)), success = PAGE.overview.sweep.success.map((text) => numbers(text, Int8Array));
  const strides = axes.map((_, i) => axes.slice(i + 1).reduce((product, {levels}) => product * levels.length, 1));
  const index = (levels) => levels.reduce((sum, level, i) => sum + level * strides[i], 0);
  const context = {axes, figure, values, success, index, varying, colours};
  const {plots, legend} = maps ? heat_maps(context) : lines_over(context);
  one("sweep").replaceChildren(made("div", {class: "line"}, made("label", {}, "Metric ", select), legend),
    made("div", {class: "grid"}, ...plots.map(({title, box}) => made("figure", {"aria-label": `${figure.name}, ${title}`}, made("h3", {}, title), box))));
  return plots.map(({box, plot}) => [box, plot]);
}

function cell_told(context, v, run, levels) {
  const {axes, figure, values, success} = context;
  return [`run ${run}, ${VARIANTS[v].name}: ${["no success", "success"][success[v][run]] || "not judged"}`,
          `${named(figure)}: ${digits(values[v][run], 6)}`,
          ...axes.map((axis, i) => `${named(axis)}: ${level_text(axis.levels[levels[i]])}`), "click to open"];
}

function clicking(plot, box, context, v, levels_at) {
  const told = (event) => { const levels = levels_at(event); return levels && cell_told(context, v, context.index(levels), levels); };
  telling(plot, box, told);
  plot.on_event("tap", (event) => {
    const levels = levels_at(event), place = levels ? FLOWN.indexOf(context.index(levels)) : -1;
    if (place >= 0) { open_run(v, place); one("opened").scrollIntoView({block: "start"}); }
  });
}

function heat_maps(context) {
  const {Range1d, ColumnDataSource} = models, {axes, figure, values, success, index, varying: [x, y, ...others], colours} = context;
  const finite = values.flatMap((found, v) => [...found].filter((value, run) => Number.isFinite(value) && success[v][run] === 1));
  const every = values.flatMap((found) => [...found].filter(Number.isFinite));
  const base = new Set(finite).size > 1 ? finite : every;
  const along = figure.log ? Math.log : (value) => value;
  const {low, high} = base.reduce((ends, value) => ({low: Math.min(ends.low, value), high: Math.max(ends.high, value)}), {low: Infinity, high: -Infinity});
  const share = (value) => !Number.isFinite(value) ? NaN : high > low ? (along(value) - along(low)) / (along(high) - along(low)) : 0.5;
  const [xs, ys] = [x, y].map((i) => places_of(axes[i]));
  const [by_x, by_y] = [xs, ys].map((points) => [...points.keys()].sort((a, b) => points[a] - points[b]));
  const [ends_x, ends_y] = [borders(by_x.map((i) => xs[i])), borders(by_y.map((j) => ys[j]))];
  const combinations = others.reduce((all, i) => all.flatMap((chosen) => axes[i].levels.map((_, k) => [...chosen, [i, k]])), [[]]);
  const [x_range, y_range] = [ends_x, ends_y].map((ends) => new Range1d({start: ends[0], end: ends[ends.length - 1]}));
  const plots = VARIANTS.flatMap((variant, v) => combinations.map((chosen) => ({variant, v, chosen}))).slice(0, MOST_MAPS).map(({variant, v, chosen}) => {
    const levels_of = (i, j) => { const levels = axes.map(() => 0); levels[x] = by_x[i]; levels[y] = by_y[j];
                                  for (const [axis, k] of chosen) levels[axis] = k; return levels; };
    const data = {left: [], right: [], bottom: [], top: [], colour: []}, crosses = {x: [], y: [], colour: []};
    by_x.forEach((_, i) => by_y.forEach((__, j) => {
      const run = index(levels_of(i, j)), at = share(values[v][run]);
      data.left.push(ends_x[i]); data.right.push(ends_x[i + 1]); data.bottom.push(ends_y[j]); data.top.push(ends_y[j + 1]);
      data.colour.push(shade(at));
      if (success[v][run] === 0) {
        crosses.x.push(xs[by_x[i]]); crosses.y.push(ys[by_y[j]]);
        crosses.colour.push(at <= 0.5 && at >= 0 ? "#ffffff" : "#000000");
      }
    }));
    const box = made("div", {class: "plot tall"});
    const plot = frame(colours, {x: {range: x_range, label: named(axes[x]), ticks: ticks_of(axes[x])}, y: {range: y_range, label: named(axes[y]), ticks: ticks_of(axes[y])}});
    glyph(plot, "Quad", new ColumnDataSource({data}), {left: "@left", right: "@right", bottom: "@bottom", top: "@top", fill_color: "@colour", line_color: null});
    glyph(plot, "Scatter", new ColumnDataSource({data: crosses}), {x: "@x", y: "@y", marker: {value: "x"}, size: 7, line_color: "@colour", line_width: 1.5});
    zoomable(plot, () => { x_range.setv({start: ends_x[0], end: ends_x[ends_x.length - 1]}); y_range.setv({start: ends_y[0], end: ends_y[ends_y.length - 1]}); });
    clicking(plot, box, context, v, (event) => {
      const [i, j] = [ends_x.findLastIndex((end) => end <= event.x), ends_y.findLastIndex((end) => end <= event.y)];
      return i >= 0 && j >= 0 && i < xs.length && j < ys.length ? levels_of(i, j) : null;
    });
    const title = [...(VARIANTS.length > 1 ? [variant.name] : []), ...chosen.filter(([i]) => axes[i].levels.length > 1)
      .map(([i, k]) => `${axes[i].name} = ${level_text(axes[i].levels[k])}`)].join(", ") || named(figure);
    return {title, box, plot};
  });
  const bar = made("span", {class: "scale", "aria-hidden": "true"});
  bar.style.background = `linear-gradient(to right, ${CIVIDIS.map((rgb) => `rgb(${rgb.join(",")})`).join(",")})`;
  return {plots, legend: made("span", {class: "line"}, digits(low, 4), bar, `${digits(high, 4)}${figure.log ? ", logarithmic" : ""}`)};
}

function lines_over(context) {
  const {Range1d, ColumnDataSource} = models, {axes, figure, values, success, index, varying: [across], colours} = context;
  const at = places_of(axes[across]), order = [...at.keys()].sort((a, b) => at[a] - at[b]);
  const levels_of = (i) => axes.map((_, axis) => axis === across ? i : 0);
  const x_full = limits(at, false), y_full = limits(values.flatMap((found) => [...found].filter(Number.isFinite)), figure.log);
  const box = made("div", {class: "plot tall"}), x_range = new Range1d(x_full), y_range = new Range1d(y_full);
  const plot = frame(colours, {x: {range: x_range, label: named(axes[across]), ticks: ticks_of(axes[across])}, y: {range: y_range, log: figure.log, label: named(figure)}});
  values.forEach((found, v) => {
    const colour = colours.colours[v % colours.colours.length], y = order.map((i) => found[index(levels_of(i))]);
    const source = new ColumnDataSource({data: {x: order.map((i) => at[i]), y}});
    glyph(plot, "Line", source, {x: "@x", y: "@y", line_color: colour, line_width: 1.8, line_dash: LINES[v % LINES.length]});
    glyph(plot, "Scatter", source, {x: "@x", y: "@y", marker: {value: "circle"}, size: 6, fill_color: colour, line_color: colour});
    const failed = order.filter((i) => success[v][index(levels_of(i))] === 0);
    glyph(plot, "Scatter", new ColumnDataSource({data: {x: failed.map((i) => at[i]), y: failed.map((i) => found[index(levels_of(i))])}}),
          {x: "@x", y: "@y", marker: {value: "x"}, size: 11, line_color: colours.ink, line_width: 2});
  });
  zoomable(plot, () => { x_range.setv(x_full); y_range.setv(y_full); });
  const nearest_level = ({x}) => order.reduce((best, i) => Math.abs(at[i] - x) < Math.abs(at[best] - x) ? i : best, order[0]);
  const nearest_variant = (event) => { const run = index(levels_of(nearest_level(event)));
    return values.reduce((best, found, v) => Math.abs(found[run] - event.y) < Math.abs(values[best][run] - event.y) ? v : best, 0); };
  telling(plot, box, (event) => { const levels = levels_of(nearest_level(event)); return cell_told(context, nearest_variant(event), index(levels), levels); });
  plot.on_event("tap", (event) => {
    const place = FLOWN.indexOf(index(levels_of(nearest_level(event))));
    if (place >= 0) { open_run(nearest_variant(event), place); one("opened").scrollIntoView({block: "start"}); }
  });
  return {plots: [{title: named(figure), box, plot}], legend: key_of(colours)};
}
