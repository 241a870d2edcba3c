"use strict";
const one = (id) => document.getElementById(id);
const SVG = "http://www.w3.org/2000/svg";

function made(tag, attributes = {}, ...children) {  // texts become text nodes: nothing here is parsed as HTML
  const element = ["svg", "rect", "line", "path", "text", "g"].includes(tag)
    ? document.createElementNS(SVG, tag) : document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (value !== false) element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children);
  return element;
}

const MINUS = "\u2212";
const signed = (text) => text.replace("-", MINUS);
function figure(value, places) {
  return value === null || !Number.isFinite(value) ? "–" : signed(value.toFixed(places));
}
function unitOf(unit) { return unit === "1" ? "" : unit; }

// About `count` round numbers from low to high.
function ticks(low, high, count) {
  const raw = (high - low) / count, power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].find((factor) => factor * power >= raw * 0.999) * power, found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) found.push(k * step);
  return {found, places: Math.max(0, -Math.floor(Math.log10(step) + 1e-9))};
}

const WIDTH = 170, EDGE = 8;  // of a gauge's drawing

// A value on a scale: a needle, the limits, and a mark where it is to be. Numbers are in the unit that is shown.
class Gauge {
  constructor({title, signal, low, high, commanded, limits}, show) {
    Object.assign(this, {title, signal, commanded, show, low, high});
    this.unit = unitOf(show(signal).unit);
    this.limits = limits && limits.map(show(signal).of);
    if (this.limits) {
      const room = 0.12 * (this.limits[1] - this.limits[0]);
      [this.low, this.high] = [this.limits[0] - room, this.limits[1] + room];
    }
    this.number = made("span", {class: "number"}, "–");
    this.note = made("span", {class: "note"});
    this.svg = made("svg", {viewBox: `0 0 ${WIDTH} 40`, "aria-hidden": "true"});
    this.element = made("div", {class: "gauge", role: "meter", tabindex: "-1", "aria-label": title},
      made("h3", {}, title),
      made("div", {class: "value"}, this.number, made("span", {class: "unit"}, this.unit), this.note), this.svg);
    this.scale();
  }

  x(value) { return EDGE + (WIDTH - 2 * EDGE) * Math.min(1, Math.max(0, (value - this.low) / (this.high - this.low))); }

  scale() {  // draws all that does not move
    const {found, places} = ticks(this.low, this.high, 4);
    this.places = Math.min(4, places + 1);
    const end = WIDTH - EDGE;
    this.svg.replaceChildren(made("rect", {class: "track", x: EDGE, y: 11, width: end - EDGE, height: 7, rx: 2}));
    if (this.limits) {
      const [a, b] = this.limits.map((limit) => this.x(limit));
      this.svg.append(made("rect", {class: "beyond", x: EDGE, y: 11, width: Math.max(0, a - EDGE), height: 7}),
        made("rect", {class: "beyond", x: b, y: 11, width: Math.max(0, end - b), height: 7}),
        ...[a, b].map((x) => made("line", {class: "limit", x1: x, x2: x, y1: 7, y2: 22})));
    }
    for (const value of found) {
      const x = this.x(value), anchor = x < 20 ? "start" : x > WIDTH - 20 ? "end" : "middle";
      this.svg.append(made("line", {class: "tick", x1: x, x2: x, y1: 18, y2: 23}),
        made("text", {x: anchor === "start" ? 0 : anchor === "end" ? WIDTH : x, y: 35, "text-anchor": anchor},
          figure(value, places)));
    }
    this.goal = made("path", {class: "goal", d: "M0 18 l-4 7 h8 z", visibility: "hidden"});
    this.needle = made("path", {class: "needle", d: "M0 15 l-6 -13 h12 z", visibility: "hidden"});
    this.svg.append(this.goal, this.needle);
    this.element.setAttribute("aria-valuemin", this.low);
    this.element.setAttribute("aria-valuemax", this.high);
  }

  widen(value) {  // where a signal leaves its scale
    if (value >= this.low && value <= this.high) return;
    const room = 0.2 * (this.high - this.low);
    if (value < this.low) this.low = value - room; else this.high = value + room;
    this.scale();
  }

  set(row) {
    const value = row(this.signal), goal = this.commanded ? row(this.commanded) : null;
    if (value === null) {  // not finite: the needle has no place
      this.number.textContent = "–";
      this.needle.setAttribute("visibility", "hidden");
      return;
    }
    for (const shown of [value, goal]) if (shown !== null) this.widen(shown);
    const text = figure(value, this.places);
    this.number.textContent = text;
    const at = this.limits && (value <= this.limits[0] + 1e-9 ? "at its lower limit" :
      value >= this.limits[1] - 1e-9 ? "at its upper limit" : "");
    const told = at || (this.limits ? `limits ${this.limits.map((x) => figure(x, 2).replace(/\.?0+$/, "")).join(" to ")}`
      : goal === null ? "" : `reference ${figure(goal, this.places)}`);
    if (this.note.textContent !== told) this.note.textContent = told;
    this.element.classList.toggle("limited", Boolean(at));
    this.element.setAttribute("aria-valuenow", value.toPrecision(6));
    this.element.setAttribute("aria-valuetext", `${text} ${this.unit}${told ? `, ${told}` : ""}`);
    for (const [part, x] of [[this.needle, value], [this.goal, goal]]) {
      if (x === null) continue;
      part.setAttribute("transform", `translate(${this.x(x).toFixed(1)} 0)`);
      part.setAttribute("visibility", "visible");
    }
  }
}
