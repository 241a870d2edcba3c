"""The interfaces of FMI-LS-WASM (working draft of July 2026), as its tools read them: FMI 3.0 in the Component Model's
words. A pair of an array and its length is a list, a pair of a truth and a value an option, and what C returns through
pointers beside a status is a result."""

WORLD = "fmu"
TYPES = {"float32": "f32", "float64": "f64", "int8": "s8", "int16": "s16", "int32": "s32", "int64": "s64",
         "uint8": "u8", "uint16": "u16", "uint32": "u32", "uint64": "u64", "boolean": "bool", "string": "string",
         "binary": "list<u8>", "clock": "bool"}
CLOCKS = {"interval-decimal": ("f64", "intervals", True), "interval-fraction": ("interval-fraction", "intervals", True),
          "shift-decimal": ("f64", "shifts", False), "shift-fraction": ("interval-fraction", "shifts", False)}

VALUES = """
  type value-reference = u32;
  type fmu-state = list<u8>;
  enum status { ok, warning, discard, error, fatal }
  enum interval-qualifier { interval-not-yet-known, interval-unchanged, interval-changed }
  enum dependency-kind { dependent, constant, fixed, tunable, discrete }
  record interval-fraction { counter: u64, resolution: u64 }
  record variable-dependency {
    dependent-value-reference: value-reference, element-index-of-dependent: u32,
    independent-value-reference: value-reference, element-index-of-independent: u32, kind: dependency-kind,
  }
  record discrete-states-info {
    new-discrete-states-needed: bool, terminate-simulation: bool, nominals-of-continuous-states-changed: bool,
    values-of-continuous-states-changed: bool, next-event-time-defined: bool, next-event-time: f64,
  }
"""
CALLBACKS = """
  use types.{status};
  log-message: func(instance-name: string, status: status, category: string, message: string);
  clock-update: func();
  lock-preemption: func();
  unlock-preemption: func();
"""
CO_SIMULATION = {
    "instantiate-co-simulation": "static func(instance-name: string, instantiation-token: string, "
                                 "resource-path: string, visible: bool, logging-on: bool, event-mode-used: bool, "
                                 "early-return-allowed: bool, required-intermediate-variables: list<value-reference>) "
                                 "-> option<co-simulation-instance>",
    "set-input-derivatives": "func(requests: list<tuple<value-reference, u32>>, values: list<f64>) -> status",
    "do-step": "func(current-communication-point: f64, communication-step-size: f64, "
               "no-set-fmu-state-prior-to-current-point: bool) -> result<do-step-result, status>",
}
MODEL_EXCHANGE = {
    "instantiate-model-exchange": "static func(instance-name: string, instantiation-token: string, "
                                  "resource-path: string, visible: bool, logging-on: bool) "
                                  "-> option<model-exchange-instance>",
    "enter-continuous-time-mode": "func() -> status",
    "set-time": "func(time: f64) -> status",
    "set-continuous-states": "func(continuous-states: list<f64>) -> status",
    **{name: "func() -> result<list<f64>, status>" for name in (
        "get-continuous-state-derivatives", "get-event-indicators", "get-continuous-states",
        "get-nominals-of-continuous-states")},
    **{name: "func() -> result<u64, status>" for name in (
        "get-number-of-event-indicators", "get-number-of-continuous-states")},
    "completed-integrator-step": "func(no-set-fmu-state-prior-to-current-point: bool) "
                                 "-> result<completed-step-result, status>",
}


def shared() -> dict[str, str]:
    """The methods of both kinds of instance: name -> type."""
    derivative = ("func(unknowns: list<value-reference>, knowns: list<value-reference>, seed: list<f64>) "
                  "-> result<list<f64>, status>")
    methods = {
        "set-debug-logging": "func(logging-on: bool, categories: list<string>) -> status",
        "enter-initialization-mode": "func(tolerance: option<f64>, start-time: f64, stop-time: option<f64>) -> status",
        **dict.fromkeys(("exit-initialization-mode", "enter-event-mode", "terminate", "reset",
                         "enter-configuration-mode", "exit-configuration-mode", "evaluate-discrete-states",
                         "enter-step-mode"), "func() -> status"),
        "update-discrete-states": "func() -> result<discrete-states-info, status>",
        "get-number-of-variable-dependencies": "func(vr: value-reference) -> result<u64, status>",
        "get-variable-dependencies": "func(dependent: value-reference) -> result<list<variable-dependency>, status>",
        "get-fmu-state": "func() -> result<fmu-state, status>",
        "set-fmu-state": "func(state: fmu-state) -> status",
        "get-directional-derivative": derivative,
        "get-adjoint-derivative": derivative,
        "get-output-derivatives": "func(requests: list<tuple<value-reference, u32>>) -> result<list<f64>, status>",
    }
    for name, kind in TYPES.items():
        methods[f"get-{name}"] = f"func(value-references: list<value-reference>) -> result<list<{kind}>, status>"
        methods[f"set-{name}"] = f"func(value-references: list<value-reference>, values: list<{kind}>) -> status"
    for name, (kind, values, qualified) in CLOCKS.items():
        got = f"tuple<{kind}, interval-qualifier>" if qualified else kind
        methods[f"get-{name}"] = f"func(value-references: list<value-reference>) -> result<list<{got}>, status>"
        methods[f"set-{name}"] = f"func(value-references: list<value-reference>, {values}: list<{kind}>) -> status"
    return methods


def instance(kind: str, record: str, methods: dict[str, str]) -> str:
    """An interface with the resource of one kind of FMU."""
    lines = "\n".join(f"    {name}: {what};" for name, what in {**methods, **shared()}.items())
    return (f"interface {kind} {{\n  use types.{{value-reference, status, fmu-state, interval-qualifier, "
            f"interval-fraction, variable-dependency, discrete-states-info}};\n  record {record}\n"
            f"  resource {kind}-instance {{\n{lines}\n  }}\n}}\n")


def interfaces() -> str:
    """All of it, with a world that is the draft's for co-simulation and its for model exchange in one."""
    step = "do-step-result { last-successful-time: f64, event-handling-needed: bool, terminate-simulation: bool, " \
           "early-return: bool }"
    completed = "completed-step-result { enter-event-mode: bool, terminate-simulation: bool }"
    return "\n".join([
        "package fmi:fmi3@3.0.0;", f"interface types {{{VALUES}}}", f"interface callbacks {{{CALLBACKS}}}",
        "interface common {\n  get-version: func() -> string;\n}",
        instance("co-simulation", step, CO_SIMULATION), instance("model-exchange", completed, MODEL_EXCHANGE),
        f"world {WORLD} {{\n  import callbacks;\n  export common;\n  export co-simulation;\n"
        "  export model-exchange;\n}", ""])
