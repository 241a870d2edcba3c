"use strict";
// What is said of a flight: its signals, the metrics of run.json, and sentences on how it flew. As
// cosim/master/measures.py and cosim/vehicle/limits.py say it in Python.

const DEGREES = 180 / Math.PI;

// A signal at each time; null if the flight does not have it, nor what stands in for it.
function signal(flight, name) {
  return flight.column(name) ?? flight.column(flight.standsIn[name]);
}

function folded(values, combine, start) {
  let found = start;
  for (let k = 0; k < values.length; k++) found = combine(found, values[k]);
  return found;
}

function each(values, change) {
  if (typeof values === "number") return change(values, 0);
  const found = new Float64Array(values.length);
  for (let k = 0; k < found.length; k++) found[k] = change(values[k], k);
  return found;
}

// What expressions are made of, as in cosim/master/evaluate.py; signals have values at the times k * step.
const FUNCTIONS = {
  "+": (step, a, b) => each(a, (x, k) => x + b[k]),
  "-": (step, a, b) => each(a, (x, k) => x - b[k]),
  degrees: (step, a) => each(a, x => x * DEGREES),
  min: (step, a) => folded(a, Math.min, Infinity),
  max: (step, a) => folded(a, Math.max, -Infinity),
  max_abs: (step, a) => folded(a, (most, x) => Math.max(most, Math.abs(x)), 0),
  rms(step, a) {
    const last = a.length - 1;
    if (!last) return Math.abs(a[0]);
    let sum = 0;
    for (let k = 0; k < last; k++) sum += ((k + 1) * step - k * step) * (a[k + 1] ** 2 + a[k] ** 2);
    return Math.sqrt(sum / (2 * last * step));
  },
  travel(step, a) {
    let sum = 0;
    for (let k = 1; k < a.length; k++) sum += Math.abs(a[k] - a[k - 1]);
    return sum;
  },
  time_on(step, a) {
    let sum = 0;
    for (let k = 1; k < a.length; k++) if (a[k]) sum += k * step - (k - 1) * step;
    return sum;
  },
};

// What an expression is worth: a signal's name, or [function, argument, ...]; null without its signals.
function worth(flight, expression) {
  if (typeof expression === "string") return signal(flight, expression);
  const [name, ...parts] = expression,
    values = parts.map(part => worth(flight, part));
  return values.includes(null) ? null : FUNCTIONS[name](flight.step, ...values);
}

function metrics(flight, wanted) {
  return Object.fromEntries(Object.entries(wanted).map(([name, { expression }]) => [name, worth(flight, expression)]));
}

// Sentences on the start and on long times at a limit.
function remarks(flight, found, { share, arrived, actuators }) {
  const { plant, controller } = flight.asked,
    said = [],
    flown = (flight.count - 1) * flight.step;
  if (!(plant.trim_residual <= arrived))
    said.push(
      `The vehicle does not start in trim: no level flight was found at V = ${short(plant.V_start)} ft/s, ` +
        `h = ${short(plant.h_start)} ft.`,
    );
  else {
    const needs = [
      ["a fuel ratio", "fuel_ratio", 1, ""],
      ["an elevator", "elevator", DEGREES, " deg"],
    ]
      .map(([words, name, factor, unit]) => [
        words,
        plant[`${name}_trim`] * factor,
        controller[`${name}_min`] * factor,
        controller[`${name}_max`] * factor,
        unit,
      ])
      .filter(([, value, low, high]) => !(low <= value && value <= high))
      .map(
        ([words, value, low, high, unit]) =>
          `${words} of ${short(value, 4)}${unit} (${short(low)} to ${short(high)}${unit} is allowed)`,
      );
    if (needs.length)
      said.push(
        `Level flight at V = ${short(plant.V_start)} ft/s, h = ${short(plant.h_start)} ft is beyond the ` +
          `vehicle's limits: it needs ${needs.join(" and ")}.`,
      );
  }
  const long = Object.entries(actuators)
    .map(([name, word]) => [word, found[`saturated_s.${name}`] || 0])
    .filter(([, seconds]) => seconds > share * flown)
    .map(([word, seconds]) => `the ${word} for ${short(seconds, 4)} s`);
  if (long.length) said.push(`At a limit: ${long.join(" and ")} of the ${short(flown, 4)} s flown.`);
  return said;
}

// A sentence if the elevator was at its stops when the flight ended; empty if it was not.
function stuck(flight, { pause }) {
  const flags = signal(flight, "controller.elevator_saturated");
  const elevator = signal(flight, "controller.elevator");
  if (!flags || !elevator) return "";
  const last = flight.count - 1,
    rows = [...flags.keys()].filter(k => flags[k]);
  if (!rows.length) return "";
  const paused = rows.map((row, i) => {
    const next = i + 1 < rows.length ? rows[i + 1] : last;
    return next - row > 1 && (next - row) * flight.step > pause;
  });
  const since = rows[paused.lastIndexOf(true, -2) + 1];
  if (paused.at(-1) || (last - since) * flight.step < pause) return "";
  const stops = rows.filter(k => k >= since).map(k => elevator[k] * DEGREES);
  const stayed = Math.max(...stops) - Math.min(...stops) < 1e-6 ? "stayed there" : "stayed at its stops";
  const when = short(since * flight.step, 4);
  return `The elevator reached its stop of ${short(stops[0], 4)} deg at t = ${when} s and ${stayed}.`;
}
