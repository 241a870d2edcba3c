// Okabe and Ito's colours; those that a background hides are darker or lighter there.
const COLOURS = {light: ["#0072b2", "#d55e00", "#007a5a", "#b4518c", "#000000"],
                 dark: ["#56b4e9", "#e69f00", "#1fc59a", "#e59ac6", "#ffffff"]};
const DASHES = [[], [8, 4], [2, 3], [10, 3, 2, 3], [14, 4]];
const INKS = {light: {text: "#333", grid: "#0001", mark: "#565c66", limit: "#a83e00"},
              dark: {text: "#ddd", grid: "#fff2", mark: "#abb3bf", limit: "#ffad66"}};
const dark = matchMedia("(prefers-color-scheme: dark)");
const theme = () => (dark.matches ? "dark" : "light");
const LONGEST = 24_000;  // rows that are kept: the oldest go
const HEIGHT = 200;      // px, as live.css has it

const plain = (x) => signed(String(Number(x.toPrecision(9))));

// Panels over one time that runs. `data` has the times, then a column for each signal, in the units that are shown.
class Charts {
  constructor(place, charts, stop, show) {
    Object.assign(this, {place, charts, stop, show, window: 60, marks: []});
    this.signals = [...new Set(charts.flatMap((chart) => chart.signals))];
    this.data = [[], ...this.signals.map(() => [])];
    this.build();
    dark.addEventListener("change", () => { this.build(); this.draw(); });
    new ResizeObserver(() => this.fit()).observe(place);
  }

  build() {
    for (const {plot} of this.panels || []) plot.destroy();
    const frames = this.charts.map((chart) => {
      const unit = unitOf(this.show(chart.signals[0]).unit), box = made("div", {class: "plot", role: "img"});
      const values = chart.signals.map(() => made("output", {"aria-live": "off"}));
      const key = made("ul", {class: "key"}, ...chart.signals.map((name, i) => made("li", {}, made("svg",
        {viewBox: "0 0 28 8", "aria-hidden": "true"}, made("line", {x1: 0, x2: 28, y1: 4, y2: 4, "stroke-width": 2.5,
          stroke: COLOURS[theme()][i], "stroke-dasharray": DASHES[i].join(" ")})),
        made("span", {}, name), values[i])));
      const figureOf = made("figure", {}, made("h3", {}, chart.title + (unit ? ` (${unit})` : "")), key, box);
      return {chart, box, values, figure: figureOf};
    });
    this.place.replaceChildren(...frames.map(({figure: frame}) => frame));
    this.panels = frames.map((frame) => ({...frame, plot: new uPlot(this.options(frame.chart, frame.box), [[],
      ...frame.chart.signals.map(() => [])], frame.box)}));
  }

  options(chart, box) {
    const inks = INKS[theme()], axis = {stroke: inks.text, grid: {stroke: inks.grid, width: 1},
      ticks: {stroke: inks.grid}, font: "12px system-ui, sans-serif"};
    return {
      width: Math.max(200, box.clientWidth), height: HEIGHT, legend: {show: false}, pxAlign: 0,
      series: [{}, ...chart.signals.map((name, i) => ({stroke: COLOURS[theme()][i], width: Math.max(1.5, 3.6 - 0.7 * i), pxAlign: 0,
        dash: DASHES[i].map((length) => length * devicePixelRatio), points: {show: false}, spanGaps: false}))],
      scales: {x: {time: false, range: () => this.span()}, y: {range: (_, low, high) => this.range(chart, low, high)}},
      axes: [{...axis, size: 28, values: (_, splits) => splits.map((x) => `${plain(x)} s`)},
        {...axis, size: 58, values: (_, splits) => splits.map(plain)}],
      cursor: {show: false},
      hooks: {drawAxes: [(plot) => this.mark(plot, chart)]},
    };
  }

  span() {
    const times = this.data[0], last = times.length ? times[times.length - 1] : 0, first = times.length ? times[0] : 0;
    if (!this.window || this.stop - first <= this.window) return [first, this.window ? this.stop : Math.max(last, first + 1)];
    return last < first + this.window ? [first, first + this.window] : [last - this.window, last];
  }

  range(chart, low, high) {
    if (low === null || high === null) [low, high] = [0, 1];
    const least = Math.max(Math.abs(high) * 1e-3, 0.01), room = Math.max((high - low) * 0.08, least);
    return [low - room, high + room];
  }

  mark(plot, chart) {  // limits, and the steps made by hand
    const {ctx, bbox} = plot, inks = INKS[theme()], [from, to] = this.span();
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    const line = (colour, dash, a, b, c, d) => {
      ctx.strokeStyle = colour; ctx.lineWidth = 1.5 * devicePixelRatio;
      ctx.setLineDash(dash.map((length) => length * devicePixelRatio));
      ctx.beginPath(); ctx.moveTo(a, b); ctx.lineTo(c, d); ctx.stroke();
    };
    for (const limit of chart.limits || []) {
      const y = plot.valToPos(this.show(chart.signals[0]).of(limit), "y", true);
      line(inks.limit, [2, 2], bbox.left, y, bbox.left + bbox.width, y);
    }
    for (const {time} of this.marks) if (time >= from && time <= to) {
      const x = plot.valToPos(time, "x", true);
      line(inks.mark, [5, 4], x, bbox.top, x, bbox.top + bbox.height);
    }
    ctx.restore();
  }

  clear() { for (const column of this.data) column.length = 0; }

  add(time, row) {
    this.data[0].push(time);
    this.signals.forEach((name, i) => this.data[i + 1].push(row(name)));
    if (this.data[0].length > LONGEST) for (const column of this.data) column.splice(0, LONGEST / 10);
  }

  draw() {
    const last = this.data[0].length - 1;
    for (const {plot, chart, values, box} of this.panels) {
      const places = chart.signals.map((name) => 1 + this.signals.indexOf(name));
      plot.setData([this.data[0], ...places.map((place) => this.data[place])]);
      if (last < 0) continue;
      const told = places.map((place) => this.data[place][last]);
      told.forEach((value, i) => { values[i].textContent = value === null ? "–" : signed(String(Number(value.toPrecision(5)))); });
      box.setAttribute("aria-label", `${chart.title} over time: ${chart.signals.map((name, i) =>
        `${name} ${values[i].textContent}`).join(", ")} at ${this.data[0][last].toFixed(1)} s`);
    }
  }

  fit() {
    for (const {plot, box} of this.panels)
      if (box.clientWidth && plot.width !== box.clientWidth) plot.setSize({width: box.clientWidth, height: HEIGHT});
  }
}
