"use strict";
Bokeh.logger.set_level("error");  // set_log_level would write a line
const PAGE = JSON.parse(document.getElementById("data").textContent);
const LEFT = 78;
const one = (id) => document.getElementById(id);
const dark = () => matchMedia("(prefers-color-scheme: dark)").matches;
// Okabe and Ito's colours; those that a background hides are darker or lighter there.
const COLOURS = {light: ["#0072b2", "#d55e00", "#007a5a", "#b4518c", "#000000", "#2f94c8", "#a97400"],
                 dark: ["#56b4e9", "#e69f00", "#1fc59a", "#e59ac6", "#ffffff", "#f0e442", "#ff7f3a"]};
const LINES = [[], [8, 4], [2, 3], [10, 3, 2, 3], [5, 2], [14, 4]];
const SHADES = ["#56b4e9", "#e69f00", "#cc79a7", "#009e73", "#999999", "#d55e00"];

function made(tag, attributes = {}, ...children) {  // texts become text nodes: nothing here is parsed as HTML
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (value !== false && value !== null) element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children);
  return element;
}

function numbers(text, Kind = Float32Array) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  return new Kind(bytes.buffer);
}

function digits(value, most = 7) {
  if (!Number.isFinite(value)) return "–";
  return value !== 0 && Math.abs(value) < 1e-4 ? Number(value.toPrecision(4)).toExponential()
    : String(Number(value.toPrecision(most)));
}

// Bokeh would load MathJax for what stands between these signs.
const plain = (text) => text.replace(/\$(?=\$)/g, "$\u200b").replace(/\\(?=[[(])/g, "\\\u200b");

const {Document} = Bokeh.require("document");
const models = {};
for (const name of ["Plot", "Range1d", "LinearAxis", "LogAxis", "Grid", "Line", "VArea", "Quad", "Segment", "Scatter",
                    "GlyphRenderer", "ColumnDataSource", "BoxAnnotation", "Span", "BoxZoomTool", "PanTool", "WheelZoomTool",
                    "SaveTool", "LinearScale", "LogScale", "BasicTickFormatter", "FixedTicker", "LogTickFormatter", "NoOverlap"])
  models[name] = Bokeh.Models.get(name);

async function embed(drawing, boxes) {  // Tab passes over plots: by keyboard they do nothing
  const views = await Bokeh.embed.add_document_standalone(drawing, document.body, boxes);
  for (const {canvas_view} of views) if (canvas_view) canvas_view.events_el.tabIndex = -1;  // one view is of no plot
}

function scheme() {  // the colours of the page as it is now
  const style = getComputedStyle(document.documentElement), name = dark() ? "dark" : "light";
  document.documentElement.dataset.scheme = name;
  const of = (word) => style.getPropertyValue(`--${word}`).trim();
  return {name, ink: of("ink"), line: of("line"), paper: of("paper"), soft: of("soft"), good: of("good"), bad: of("bad"),
          accent: of("accent"), colours: COLOURS[name]};
}

// A plot without curves: ranges, axes, grid. An axis has a `label`, `log`, `exact` (no powers
// of ten), and `ticks`: [place, text] each.
function frame(colours, {x, y, options = {}}) {
  const {Plot, LinearAxis, LogAxis, Grid, LinearScale, LogScale, BasicTickFormatter, FixedTicker, NoOverlap} = models;
  const {ink, line, paper} = colours;
  const scale = ({log}) => log ? new LogScale() : new LinearScale();
  const plot = new Plot({x_range: x.range, y_range: y.range, x_scale: scale(x), y_scale: scale(y), sizing_mode: "stretch_both",
    background_fill_color: paper, border_fill_color: paper, outline_line_color: line, min_border_left: LEFT,
    min_border_right: 12, min_border_top: 4, lod_threshold: null, toolbar_location: null, output_backend: "canvas",
    ...options});
  const text = {axis_label_text_color: ink, major_label_text_color: ink, axis_line_color: ink, major_tick_line_color: ink,
                minor_tick_line_color: null, axis_label_text_font_style: "normal", axis_label_text_font_size: "12px",
                major_label_text_font_size: "11px"};
  for (const [{label, log, ticks, exact}, place, dimension] of [[x, "below", 0], [y, "left", 1]]) {
    const own = {...text, axis_label: plain(label || ""), major_label_policy: new NoOverlap({min_distance: 6})};
    if (ticks) Object.assign(own, {ticker: new FixedTicker({ticks: ticks.map(([at]) => at)}),
                                   major_label_overrides: new Map(ticks.map(([at, word]) => [at, plain(word)]))});
    else if (!log) own.formatter = new BasicTickFormatter({precision: "auto", use_scientific: !exact, power_limit_high: 7,
                                                           power_limit_low: -4});
    const axis = new (log ? LogAxis : LinearAxis)(own);
    plot.add_layout(axis, place);
    plot.add_layout(new Grid({axis, dimension, grid_line_color: line, grid_line_alpha: 0.7}));
  }
  return plot;
}
