"use strict";
// The panels: curves of this flight, those of the last one in grey behind, with uPlot.

const COLOURS = {
  // Okabe and Ito's, those that can be seen on white and on black
  light: ["#0072b2", "#d55e00", "#007a5a", "#9a4f7d", "#000000"],
  dark: ["#56b4e9", "#e69f00", "#2bd4a0", "#e09ac4", "#f0e442"],
};
const DASHES = [[], [8, 8], [2, 6], [14, 6, 2, 6], [5, 10]];
const STYLES = ["solid", "dashed", "dotted", "dashed", "dashed"]; // the same as CSS has them
const INKS = {
  light: { text: "#333", grid: "#0001", old: "#8c8c8c", level: "#767676" },
  dark: { text: "#ddd", grid: "#fff2", old: "#757575", level: "#8f8f8f" },
};
const dark = matchMedia("(prefers-color-scheme: dark)");
const theme = () => (dark.matches ? "dark" : "light");

class Charts {
  // `panels` as in layout.json; `zoomed(from, to)` is told when the user has picked a part of the time.
  constructor(place, panels, zoomed) {
    this.place = place;
    this.panels = panels;
    this.zoomed = zoomed;
    this.flights = [];
    this.window = null;
    new ResizeObserver(() => this.resize()).observe(place);
    dark.addEventListener("change", () => {
      this.build();
      this.draw();
    });
    this.build();
  }

  build() {
    this.plots?.forEach(plot => plot.destroy());
    this.frames = this.panels.map(panel => {
      const box = make("div", { role: "img" });
      return [make("figure", {}, make("figcaption", { textContent: `${panel.title} (${panel.unit})` }), box), box];
    });
    this.place.replaceChildren(...this.frames.map(([figure]) => figure));
    this.plots = this.panels.map(
      (panel, i) => new uPlot(this.options(panel), [[], ...this.lines(panel).map(() => [])], this.frames[i][1]),
    );
  }

  // Each line twice: of the last flight, unless it is given from outside, then of this one. The first is wide, so that
  // it is seen under a dashed one that covers it.
  lines(panel) {
    return [
      ...panel.lines.filter(line => !line.given).map(line => ({ line, flight: 1 })),
      ...panel.lines.map(line => ({ line, flight: 0 })),
    ];
  }

  size() {
    const style = getComputedStyle(this.place),
      columns = style.gridTemplateColumns.split(" ").map(parseFloat);
    return {
      width: Math.max(200, Math.floor(columns[0]) - 2),
      height: parseInt(style.getPropertyValue("--chart-height")),
    };
  }

  options(panel) {
    const inks = INKS[theme()],
      colours = COLOURS[theme()];
    const axis = {
      stroke: inks.text,
      grid: { stroke: inks.grid, width: 1 },
      ticks: { stroke: inks.grid },
      font: "12px system-ui, sans-serif",
    };
    const lines = this.lines(panel),
      series = lines.map(({ line, flight }) => {
        const number = panel.lines.indexOf(line);
        return {
          label: line.name,
          show: true,
          points: { show: false },
          spanGaps: true,
          width: flight ? 1.5 : number || panel.lines.length === 1 ? 1.75 : 3,
          pxAlign: 0,
          stroke: flight ? inks.old : colours[number],
          dash: DASHES[number].map(length => length * devicePixelRatio),
          scale: "y",
          auto: true,
          value: (_, value) => (value === null || value === undefined ? "" : figure(value, 6)),
        };
      });
    return {
      ...this.size(),
      series: [{ label: "t", value: (_, value) => (value === null ? "" : `${figure(value, 5)} s`) }, ...series],
      pxAlign: 0,
      legend: {
        live: true,
        markers: { width: 2, dash: (_, i) => STYLES[panel.lines.indexOf(lines[i - 1]?.line)] ?? "solid" },
      },
      scales: {
        x: { time: false, range: () => this.span() },
        y: { range: (_, low, high) => this.range(panel, low, high) },
      },
      axes: [
        { ...axis, size: 28, values: (_, splits) => splits.map(x => `${x}`) },
        { ...axis, size: 58 },
      ],
      cursor: {
        sync: { key: "time", setSeries: false },
        drag: { x: true, y: false, setScale: false },
        points: { size: 6 },
        bind: {
          dblclick: () => () => {
            this.zoomed(null);
            return null;
          },
        },
      },
      hooks: {
        setSelect: [
          plot => {
            if (plot.select.width < 4) return;
            const [from, to] = [plot.select.left, plot.select.left + plot.select.width].map(x => plot.posToVal(x, "x"));
            plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
            this.zoomed(from, to);
          },
        ],
        drawAxes: [plot => this.marks(plot, panel)],
        init: [
          plot => {
            // the legend's rows of the last flight say nothing new
            plot.root.querySelectorAll(".u-legend .u-series").forEach((row, i) => {
              if (!i || lines[i - 1].flight) row.hidden = true;
            });
          },
        ],
        setLegend: [
          plot => {
            plot.root.querySelector(".u-legend .u-series").hidden = plot.cursor.idx === null;
          },
        ],
      },
    };
  }

  // Levels of the limits, and when the flight departed.
  marks(plot, panel) {
    const [flight] = this.flights,
      { ctx, bbox } = plot,
      inks = INKS[theme()];
    if (!flight) return;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    ctx.lineWidth = devicePixelRatio;
    const line = (a, b, c, d) => {
      ctx.beginPath();
      ctx.moveTo(a, b);
      ctx.lineTo(c, d);
      ctx.stroke();
    };
    ctx.strokeStyle = inks.level;
    ctx.setLineDash([3 * devicePixelRatio, 3 * devicePixelRatio]);
    for (const name of panel.levels ?? []) {
      const y = plot.valToPos(flight.asked.controller[name] * (panel.factor ?? 1), "y", true);
      line(bbox.left, y, bbox.left + bbox.width, y);
    }
    if (!flight.finished) {
      const x = plot.valToPos(flight.reached, "x", true);
      ctx.setLineDash([]);
      ctx.strokeStyle = COLOURS[theme()][1];
      line(x, bbox.top, x, bbox.top + bbox.height);
    }
    ctx.restore();
  }

  span() {
    return this.window ?? [0, this.flights[0]?.stop ?? 100];
  }

  // The range of what this flight shows; the last one may leave it.
  range(panel, low, high) {
    const [own] = this.extents?.get(panel) ?? [[low, high]];
    let [least, most] = own ?? [low, high];
    if (!Number.isFinite(least)) [least, most] = [0, 1];
    const room = Math.max((most - least) * 0.06, Math.abs(most) * 1e-6, 1e-6);
    return [least - room, most + room];
  }

  // The flights to show: this one, and the last one or none.
  show(flight, last) {
    this.flights = last ? [flight, last] : [flight];
    this.draw();
  }

  draw() {
    if (!this.flights.length) return;
    const [from, to] = this.span(),
      times = grid(from, to);
    this.extents = new Map();
    this.panels.forEach((panel, i) => {
      let low = Infinity,
        high = -Infinity;
      const data = this.lines(panel).map(({ line, flight }) => {
        const shown = this.flights[flight],
          values = shown?.series[line.signal];
        if (!values) return new Array(times.length).fill(null);
        const points = decimated(values, shown.step, times, panel.factor ?? 1);
        if (!flight)
          for (const y of points)
            if (y !== null) {
              if (y < low) low = y;
              if (y > high) high = y;
            }
        return points;
      });
      this.extents.set(panel, [[low, high]]);
      this.plots[i].setData([times, ...data]);
      const unit = panel.unit === "1" ? "" : ` ${panel.unit}`;
      this.frames[i][1].setAttribute(
        "aria-label",
        `${panel.title}: between ${figure(low)} and ${figure(high)}${unit}, ` +
          `from ${figure(from)} s to ${figure(to)} s`,
      );
    });
  }

  resize() {
    const size = this.size();
    if (size.width === this.plots[0].width && size.height === this.plots[0].height) return;
    this.plots.forEach(plot => plot.setSize(size));
  }
}
