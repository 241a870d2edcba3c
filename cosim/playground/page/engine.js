"use strict";
// Flies a system of FMUs by the master's own loop (loop.c) and lists of calls: `plan.initial` and `plan.tick`. FMUs and
// loop are one WebAssembly module (compile.py). Runs in a worker, or in the page where there is none.

const OK = 1; // statuses up to this one: OK and Warning
const ANSWERS = ["OK", "Warning", "Discard", "Error", "Fatal", "Pending"];
const BLOCK = 256; // ticks whose rows are turned into columns together, while they are near

class Refused extends Error {}

// The module's exports and memory. Nothing is given back but what `release` gives back.
class Engine {
  constructor(module) {
    this.module = module;
  }

  // Begins anew where the last flight did not end by itself.
  begin() {
    if (!this.ended) {
      this.exports = new WebAssembly.Instance(this.module).exports;
      this.exports._initialize();
      this.taken = [];
    }
    this.ended = false;
  }

  // Memory for `n` values of 8 bytes, zeros where `fill`: its address.
  room(n, fill = true) {
    const address = this.exports.malloc(8 * n);
    if (!address) throw new Refused("The flight does not fit into the memory of this browser.");
    if (fill) this.reals(address, n).fill(0);
    this.taken.push(address);
    return address;
  }

  // What lies at an address, until memory is taken again.
  reals(address, n) {
    return new Float64Array(this.exports.memory.buffer, address, n);
  }

  words(address, n) {
    return new BigInt64Array(this.exports.memory.buffer, address, n);
  }

  text(address) {
    const bytes = new Uint8Array(this.exports.memory.buffer);
    return new TextDecoder().decode(bytes.slice(address, bytes.indexOf(0, address)));
  }

  release() {
    this.taken.splice(0).forEach(this.exports.free);
    this.ended = true;
  }
}

// An instance of the FMU `fmu` of the engine; `label` is what messages call it.
class Component {
  constructor(engine, fmu, label) {
    this.engine = engine;
    this.own = name => engine.exports[`${fmu}_${name}`];
    this.label = label;
    this.references = new Map();
    const n = this.own("n_variables")();
    for (let i = 0; i < n; i++) this.references.set(engine.text(this.own("variable_name")(i)), i);
    this.instance = this.own("instantiate")();
    if (!this.instance) throw new Refused(`${label} does not instantiate: ${this.said()}`);
  }

  said() {
    return this.engine.text(this.own("message")());
  }

  refusal(status, call, time) {
    const when = time === undefined ? "" : ` at t = ${short(time)} s`;
    return `${this.label} answered ${ANSWERS[status]} to fmi2${call}${when}: ${this.said()}`;
  }

  call(name, ...more) {
    const status = this.own(`fmi2${name}`)(this.instance, ...more);
    if (status > OK) throw new Refused(this.refusal(status, name));
  }

  // Variables that are moved together: where their references are, and how many.
  group(names) {
    const references = this.engine.room(Math.ceil(names.length / 2));
    new Uint32Array(this.engine.exports.memory.buffer, references, names.length).set(
      names.map(name => {
        if (!this.references.has(name)) throw new Refused(`${this.label} has no variable ${name}.`);
        return this.references.get(name);
      }),
    );
    return [references, names.length];
  }

  // Sets numbers and truth values by name.
  set(values) {
    const value = this.engine.room(1);
    for (const [name, given] of Object.entries(values)) {
      const truth = typeof given === "boolean",
        group = this.group([name]);
      new (truth ? Int32Array : Float64Array)(this.engine.exports.memory.buffer, value, 1)[0] = given;
      this.call(truth ? "SetBoolean" : "SetReal", ...group, value);
    }
  }

  // The values of numbers by name.
  get(names) {
    const values = this.engine.room(names.length);
    this.call("GetReal", ...this.group(names), values);
    const found = this.engine.reals(values, names.length);
    return Object.fromEntries(names.map((name, i) => [name, found[i]]));
  }
}

// The tables of a system as loop.c has them (cosim/master/wiring.py), with `P`, the names of program.py; a signal is a
// slot, and all are recorded. `components` are loaded ones by name; a row of the program is one of `calls`.
function tables(engine, components, calls, columns, P) {
  const names = Object.keys(components),
    slots = new Map(columns.map((name, i) => [name, BigInt(i)])),
    moves = calls.filter(([code]) => code !== "step"),
    links = moves.reduce((sum, [, , variables]) => sum + variables.length, 0),
    groups = moves.map(([, component, variables]) => components[component].group(variables)),
    n = columns.length;
  const at = { slopes: 0, exact: 0, smooth: 0, texts: 0 }; // of which nothing is used here
  for (const name of ["where", "factor", "offset", "buffers"]) at[name] = engine.room(links);
  for (const name of ["signals", "before", "holder", "recorded"]) at[name] = engine.room(n);
  at.groups = engine.room(P.GROUP_COLUMNS * moves.length);
  at.components = engine.room(P.COMPONENT_COLUMNS * names.length);
  at.events = engine.room(P.EVENT_COLUMNS * names.length);
  at.clock = engine.room(2 * names.length);
  at.states = engine.room(names.length);
  at.offers = engine.room(names.length);
  const program = engine.room(5 * calls.length),
    wiring = engine.room(P.ARRAYS.length);
  new Uint32Array(engine.exports.memory.buffer, wiring, P.ARRAYS.length).set(P.ARRAYS.map(name => at[name]));
  engine.reals(at.factor, links).fill(1);
  engine.words(at.recorded, n).set([...slots.values()]);
  const row = (table, number, length, values) => {
    const cells = engine.words(at[table] + 8 * length * number, length);
    for (const [name, value] of Object.entries(values)) cells[P[name]] = BigInt(value);
  };
  names.forEach((name, i) =>
    row("components", i, P.COMPONENT_COLUMNS, {
      INSTANCE: components[name].instance,
      DO_STEP: components[name].own("do_step_at")(),
      ANSWERS: at.events + 8 * P.EVENT_COLUMNS * i,
    }),
  );
  let first = 0;
  moves.forEach(([code, component, , sources], i) => {
    const [references, count] = groups[i];
    row("groups", i, P.GROUP_COLUMNS, {
      CALL: components[component].own(`${code}_reals_at`)(),
      POINTER: components[component].instance,
      REFERENCES: references,
      COUNT: count,
      BUFFER: at.buffers + 8 * first,
      FIRST: first,
      KIND: P.REAL,
      OWNER: names.indexOf(component),
      VALUES: count,
    });
    engine.words(at.where + 8 * first, count).set(sources.map(name => slots.get(name)));
    first += count;
  });
  calls.forEach((call, i) => {
    const [code, component] = call,
      index = code === "step" ? names.indexOf(component) : moves.indexOf(call);
    engine.words(program + 40 * i, 5).set([P[code.toUpperCase()], index, 1, 0, 1].map(BigInt));
  });
  return { wiring, program, signals: at.signals };
}

// Flies {components: {name: {fmu, label, values}}, plan, step, stop, inquire} in `engine`; `P` as `tables` has it. What
// it gives: `count` values of each signal at the times k * step, as `column(name)` until the next flight, whether it
// finished, else why not, and the values that `inquire` names ({component: [variable, ...]}). Raises Refused if an FMU
// does not start.
function fly(engine, { components, plan, step, stop, inquire }, P) {
  const { columns, initial, tick } = plan,
    n = columns.length,
    ticks = Math.round(stop / step),
    loaded = {};
  engine.begin();
  for (const [name, { fmu, label, values }] of Object.entries(components)) {
    loaded[name] = new Component(engine, fmu, label);
    loaded[name].set(values);
  }
  const everyone = Object.values(loaded),
    gets = tick.filter(([code]) => code === "get"),
    found = engine.room(n * (ticks + 1), false),
    rows = engine.room(n * BLOCK),
    times = engine.room(BLOCK),
    cursor = engine.room(P.STEPS + 1),
    lists = [initial, gets, tick],
    { wiring, program, signals } = tables(engine, loaded, lists.flat(), columns, P);
  const starts = [0, initial.length, initial.length + gets.length],
    place = name => Number(engine.words(cursor + 8 * P[name], 1)[0]);
  // Carries out a list on `many` ticks from the first; its rows are recorded. Why not, or nothing.
  const carry = (which, first = 0, many = 1, recorded = 0) => {
    const list = lists[which];
    engine.words(cursor + 8 * P.ROWS, 1)[0] = 0n;
    const [length, width, from, count, decimate] = [list.length, n, first, many, recorded].map(BigInt),
      at = program + 40 * starts[which],
      { run } = engine.exports;
    const status = run(wiring, at, length, rows, times, cursor, width, from, count, 0, step, decimate);
    if (!status) return "";
    const [code, component] = list[place("AT")],
      call = { step: "DoStep", set: "SetReal", get: "GetReal" }[code],
      late = code === "get" && list === tick ? 1 : 0;
    return loaded[component].refusal(Number(status), call, which ? (place("TICK") + late) * step : undefined);
  };
  const must = refusal => {
    if (refusal) throw new Refused(refusal);
  };
  for (const component of everyone) {
    component.call("SetupExperiment", 0, 0, 0, 1, stop);
    component.call("EnterInitializationMode");
  }
  must(carry(0));
  for (const component of everyone) component.call("ExitInitializationMode");
  must(carry(1));
  const asked = Object.fromEntries(Object.entries(inquire).map(([name, names]) => [name, loaded[name].get(names)]));
  engine.exports.to_columns(signals, 1, n, found, ticks + 1);
  let count = 1,
    message = "";
  for (let first = 0; first < ticks && !message; first += BLOCK) {
    message = carry(2, first, Math.min(BLOCK, ticks - first), 1);
    engine.exports.to_columns(rows, place("ROWS"), n, found + 8 * count, ticks + 1);
    count += place("ROWS");
  }
  for (const component of everyone) component.own("fmi2FreeInstance")(component.instance);
  engine.release();
  const column = name => {
    const number = columns.indexOf(name);
    return number < 0 ? null : engine.reals(found + 8 * number * (ticks + 1), count);
  };
  return { column, count, step, stop, finished: !message, message, asked };
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
