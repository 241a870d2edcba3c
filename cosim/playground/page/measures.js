"use strict";
// What is said of a flight: its series, the metrics of run.json, and sentences on how it flew. As cosim/master/course.py
// and cosim/vehicle/limits.py say it in Python.

// The sum of signals that `terms` names ([[sign, signal], ...]) by row; null if the flight does not have them all.
function series(flight, terms) {
  const columns = terms.map(([sign, name]) => [sign, column(flight, name)]);
  if (columns.some(([, c]) => c < 0)) return null;
  const { rows, n, count } = flight, found = new Float64Array(count);
  for (const [sign, c] of columns) for (let k = 0, i = c; k < count; k++, i += n) found[k] += sign * rows[i];
  return found;
}

function column(flight, name) {
  const at = flight.columns.indexOf(name);
  return at >= 0 ? at : flight.columns.indexOf(flight.standsIn[name]);
}

// Figures of values at the times k * step.
const FORMULAS = {
  min: values => values.reduce((a, b) => Math.min(a, b)),
  max: values => values.reduce((a, b) => Math.max(a, b)),
  max_abs: values => values.reduce((a, b) => Math.max(a, Math.abs(b)), 0),
  rms(values, step) {
    const last = values.length - 1;
    if (!last) return Math.abs(values[0]);
    let sum = 0;
    for (let k = 0; k < last; k++) sum += ((k + 1) * step - k * step) * (values[k + 1] ** 2 + values[k] ** 2);
    return Math.sqrt(sum / (2 * last * step));
  },
  travel(values) {
    let sum = 0;
    for (let k = 1; k < values.length; k++) sum += Math.abs(values[k] - values[k - 1]);
    return sum;
  },
  time_on(values, step) {
    let sum = 0;
    for (let k = 1; k < values.length; k++) if (values[k]) sum += k * step - (k - 1) * step;
    return sum;
  },
};

const DEGREES = 180 / Math.PI;

function metrics(flight, wanted) {
  return Object.fromEntries(Object.entries(wanted).map(([name, { unit, formula, terms }]) => {
    const values = series(flight, terms);
    if (values && unit === "deg") for (let k = 0; k < values.length; k++) values[k] *= DEGREES;
    return [name, values && FORMULAS[formula](values, flight.step)];
  }));
}

// Sentences on the start and on long times at a limit.
function remarks(flight, found, { share, arrived, actuators }) {
  const { plant, controller } = flight.asked, said = [], flown = (flight.count - 1) * flight.step;
  if (!(plant.trim_residual <= arrived))
    said.push(`The vehicle does not start in trim: no level flight was found at V = ${short(plant.V_start)} ft/s, ` +
              `h = ${short(plant.h_start)} ft.`);
  else {
    const needs = [["a fuel ratio", "fuel_ratio", 1, ""], ["an elevator", "elevator", DEGREES, " deg"]]
      .map(([words, name, factor, unit]) => [words, plant[`${name}_trim`] * factor, controller[`${name}_min`] * factor,
                                             controller[`${name}_max`] * factor, unit])
      .filter(([, value, low, high]) => !(low <= value && value <= high))
      .map(([words, value, low, high, unit]) =>
        `${words} of ${short(value, 4)}${unit} (${short(low)} to ${short(high)}${unit} is allowed)`);
    if (needs.length)
      said.push(`Level flight at V = ${short(plant.V_start)} ft/s, h = ${short(plant.h_start)} ft is beyond the ` +
                `vehicle's limits: it needs ${needs.join(" and ")}.`);
  }
  const long = Object.entries(actuators).map(([name, word]) => [word, found[`saturated_s.${name}`] || 0])
    .filter(([, seconds]) => seconds > share * flown).map(([word, seconds]) => `the ${word} for ${short(seconds, 4)} s`);
  if (long.length) said.push(`At a limit: ${long.join(" and ")} of the ${short(flown, 4)} s flown.`);
  return said;
}

// A sentence if the elevator was at its stops when the flight ended; empty if it was not.
function stuck(flight, { pause }) {
  const flags = series(flight, [[1, "controller.elevator_saturated"]]);
  const elevator = series(flight, [[1, "controller.elevator"]]);
  if (!flags || !elevator) return "";
  const last = flight.count - 1, rows = [...flags.keys()].filter(k => flags[k]);
  if (!rows.length) return "";
  const paused = rows.map((row, i) => {
    const next = i + 1 < rows.length ? rows[i + 1] : last;
    return next - row > 1 && (next - row) * flight.step > pause;
  });
  const since = rows[paused.lastIndexOf(true, -2) + 1];
  if (paused.at(-1) || (last - since) * flight.step < pause) return "";
  const stops = rows.filter(k => k >= since).map(k => elevator[k] * DEGREES);
  const stayed = Math.max(...stops) - Math.min(...stops) < 1e-6 ? "stayed there" : "stayed at its stops";
  return `The elevator reached its stop of ${short(stops[0], 4)} deg at t = ${short(since * flight.step, 4)} s and ${stayed}.`;
}
