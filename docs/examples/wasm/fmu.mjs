// An FMU as a plain WebAssembly module, in a browser or in node: the functions of FMI 2.0, by names of variables.

export class Fmu {
  // `bytes`: the .wasm file. An instance is made at once; it is set up by `begin`.
  static async load(bytes) {
    return new Fmu((await WebAssembly.instantiate(bytes)).instance.exports);
  }

  constructor(exports) {
    exports._initialize();
    this.fmi = exports;
    this.references = new Map();
    for (let i = 0; i < exports.n_variables(); i++) this.references.set(this.text(exports.variable_name(i)), i);
    this.instance = exports.instantiate();
    if (!this.instance) throw new Error(this.text(exports.message()));
  }

  text(at) {
    const bytes = new Uint8Array(this.fmi.memory.buffer);
    return new TextDecoder().decode(bytes.slice(at, bytes.indexOf(0, at)));
  }

  call(name, ...more) {
    if (this.fmi[`fmi2${name}`](this.instance, ...more)) throw new Error(this.text(this.fmi.message()));
  }

  // Some variables of one type, to be read and set together.
  ports(names, type = "Real") {
    const n = names.length, references = this.fmi.malloc(4 * n), values = this.fmi.malloc(8 * n);
    new Uint32Array(this.fmi.memory.buffer, references, n).set(names.map(name => {
      if (!this.references.has(name)) throw new Error(`there is no variable ${name}`);
      return this.references.get(name);
    }));
    const Values = type === "Real" ? Float64Array : Int32Array;
    const view = () => new Values(this.fmi.memory.buffer, values, n); // anew, since memory may have grown
    return {
      get: () => (this.call(`Get${type}`, references, n, values), view()),
      set: given => (view().set(given), this.call(`Set${type}`, references, n, values)),
    };
  }

  // Sets `values`, numbers and booleans by name, and begins the initialisation.
  begin(values = {}, start = 0) {
    this.call("SetupExperiment", 0, 0, start, 0, 0);
    this.call("EnterInitializationMode");
    for (const [name, value] of Object.entries(values))
      this.ports([name], typeof value === "boolean" ? "Boolean" : "Real").set([value]);
  }

  step(time, step) {
    this.call("DoStep", time, step, 1);
  }
}
