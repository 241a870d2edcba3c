"use strict";
// Flies a system of FMUs, which are WebAssembly modules (docs/wasm.md), by the calls that `ahv`'s master makes:
// `plan.initial` and `plan.tick` are its own lists of calls. Runs in a worker, or in the page where there is none.

const OK = 1; // statuses up to this one: OK and Warning
const ANSWERS = ["OK", "Warning", "Discard", "Error", "Fatal", "Pending"];

class Refused extends Error {}

// An instance of the FMU in a compiled module; `label` is what messages call it.
class Component {
  constructor(module, label) {
    this.exports = new WebAssembly.Instance(module).exports;
    this.exports._initialize();
    this.label = label;
    this.references = new Map();
    const n = this.exports.n_variables();
    for (let i = 0; i < n; i++) this.references.set(this.text(this.exports.variable_name(i)), i);
    this.instance = this.exports.instantiate();
    if (!this.instance) throw new Refused(`${label} does not instantiate: ${this.text(this.exports.message())}`);
  }

  text(at) {
    const bytes = new Uint8Array(this.exports.memory.buffer);
    return new TextDecoder().decode(bytes.slice(at, bytes.indexOf(0, at)));
  }

  check(status, call, time) {
    if (status <= OK) return;
    const when = time === undefined ? "" : ` at t = ${short(time)} s`;
    throw new Refused(
      `${this.label} answered ${ANSWERS[status]} to fmi2${call}${when}: ` + this.text(this.exports.message()),
    );
  }

  call(name, ...more) {
    this.check(this.exports[`fmi2${name}`](this.instance, ...more), name);
  }

  // One call's variables of one type: where their references and values are in the module's memory.
  group(names, type = "Real") {
    const n = names.length,
      references = this.exports.malloc(4 * n),
      values = this.exports.malloc(8 * n);
    new Uint32Array(this.exports.memory.buffer, references, n).set(
      names.map(name => {
        if (!this.references.has(name)) throw new Refused(`${this.label} has no variable ${name}.`);
        return this.references.get(name);
      }),
    );
    return [references, n, values];
  }

  // Sets numbers and truth values by name.
  set(values) {
    for (const [name, value] of Object.entries(values)) {
      const truth = typeof value === "boolean",
        place = this.group([name], truth ? "Boolean" : "Real");
      new (truth ? Int32Array : Float64Array)(this.exports.memory.buffer, place[2], 1)[0] = value;
      this.call(truth ? "SetBoolean" : "SetReal", ...place);
    }
  }

  // The values of truth or number variables by name.
  get(names) {
    const [references, n, values] = this.group(names);
    this.call("GetReal", references, n, values);
    return Object.fromEntries(
      names.map((name, i) => [name, new Float64Array(this.exports.memory.buffer, values, n)[i]]),
    );
  }
}

// A call of a plan as a function of the time (s): its status. `signals` are the values by slot.
function prepared(component, [code, , names, sources], slot, signals, step) {
  const { exports, instance } = component;
  if (code === "step") return time => exports.fmi2DoStep(instance, time, step, 1);
  const [references, n, values] = component.group(names);
  const where = Int32Array.from(sources, name => slot.get(name));
  let view = new Float64Array(exports.memory.buffer, values, n);
  const current = () => {
    if (!view.length) view = new Float64Array(exports.memory.buffer, values, n); // the module's memory has grown
    return view;
  };
  if (code === "set")
    return () => {
      const to = current();
      for (let i = 0; i < n; i++) to[i] = signals[where[i]];
      return exports.fmi2SetReal(instance, references, n, values);
    };
  return () => {
    const status = exports.fmi2GetReal(instance, references, n, values),
      from = current();
    if (status <= OK) for (let i = 0; i < n; i++) signals[where[i]] = from[i];
    return status;
  };
}

// Flies {components: {name: {module, label, values}}, plan, step, stop, inquire}. What it gives: `count` rows of
// signals (the columns of plan.columns) at the times k * step, whether it finished, else why not, and the values that
// `inquire` names ({component: [variable, ...]}). Raises Refused if an FMU does not start.
function fly({ components, plan, step, stop, inquire }) {
  const loaded = {},
    slot = new Map(plan.columns.map((name, i) => [name, i])),
    n = plan.columns.length;
  const signals = new Float64Array(n),
    ticks = Math.round(stop / step);
  for (const [name, { module, label, values }] of Object.entries(components)) {
    loaded[name] = new Component(module, label);
    loaded[name].set(values);
  }
  const steps = calls =>
    calls.map(call => ({
      run: prepared(loaded[call[1]], call, slot, signals, step),
      component: loaded[call[1]],
      late: call[0] === "get" ? 1 : 0,
      name: { step: "DoStep", set: "SetReal", get: "GetReal" }[call[0]],
    }));
  for (const component of Object.values(loaded)) {
    component.call("SetupExperiment", 0, 0, 0, 1, stop);
    component.call("EnterInitializationMode");
  }
  const tick = steps(plan.tick);
  for (const one of steps(plan.initial)) one.component.check(one.run(0), one.name);
  for (const component of Object.values(loaded)) component.call("ExitInitializationMode");
  for (const one of tick.filter(one => one.late)) one.component.check(one.run(0), one.name, 0);
  const asked = Object.fromEntries(Object.entries(inquire).map(([name, names]) => [name, loaded[name].get(names)]));
  const rows = new Float64Array((ticks + 1) * n),
    runs = tick.map(one => one.run);
  rows.set(signals);
  let k = 0,
    message = "";
  flight: for (; k < ticks; k++) {
    const time = k * step;
    for (let i = 0; i < runs.length; i++) {
      const status = runs[i](time);
      if (status > OK) {
        try {
          tick[i].component.check(status, tick[i].name, (k + tick[i].late) * step);
        } catch (error) {
          message = error.message;
        }
        break flight;
      }
    }
    rows.set(signals, (k + 1) * n);
  }
  return { rows, n, count: k + 1, step, stop, finished: !message, message, asked };
}

// A number with six digits, as `%g` writes it in C and Python.
function short(x, digits = 6) {
  if (!Number.isFinite(x)) return x > 0 ? "inf" : x < 0 ? "-inf" : "nan";
  const [mantissa, power] = x.toExponential(digits - 1).split("e");
  if (power < -4 || power >= digits) {
    const sign = power < 0 ? "-" : "+",
      size = String(Math.abs(power)).padStart(2, "0");
    return (mantissa.includes(".") ? mantissa.replace(/\.?0+$/, "") : mantissa) + "e" + sign + size;
  }
  return String(Number(x.toPrecision(digits)));
}
