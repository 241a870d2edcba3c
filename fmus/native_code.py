"""A model's C: its traced functions through CasADi's code generator, and its table."""
import re
from importlib.metadata import version
from types import ModuleType

import casadi

from .hoist import Hoisted, hoisted
from .interface import Variable, computed, longest_step, names, states
from .references import all_variables
from .trace import Trace

ROLES = {"input": "INPUT", "output": "OUTPUT", "calculatedParameter": "CALCULATED_PARAMETER",
         "parameter": "PARAMETER", "local": "STATE", "independent": "TIME"}
OWN = ("exp", "sin", "cos", "tan", "asin", "fmin", "fmax")  # functions of mathematics.h


def rates(trace: Trace) -> casadi.Function:
    """The model's `derivative`, (t, x, u, p) -> rates; a model without has no rates."""
    if trace.derivative:
        return trace.derivative
    arguments = [casadi.SX.sym(name, trace.outputs.size1_in(name)) for name in "txup"]
    return casadi.Function("derivative", arguments, [casadi.SX(0, 1)])


def tangents(trace: Trace) -> list[casadi.Function]:
    """Directional derivatives: `start_tangent` of the initial state with respect to u and p, `tangent` of outputs and
    rates with respect to x, u and p."""
    n, derivative = trace.sizes, rates(trace)
    t = casadi.SX.sym("t")
    (x, dx), (u, du), (p, dp) = ((casadi.SX.sym(k, n[k]), casadi.SX.sym(f"d{k}", n[k])) for k in "xup")

    def along(expression: casadi.SX, variables: list[casadi.SX], direction: list[casadi.SX]) -> casadi.SX:
        change = casadi.jtimes(expression, casadi.vertcat(*variables), casadi.vertcat(*direction))
        return casadi.cse(casadi.densify(change))  # which halves the code

    after = [along(f(t, x, u, p), [x, u, p], [dx, du, dp]) for f in (trace.outputs, derivative)]
    return [casadi.Function("start_tangent", [u, p, du, dp], [along(trace.start(u, p), [u, p], [du, dp])]),
            casadi.Function("tangent", [t, x, u, p, dx, du, dp], after)]


def internal_function(name: str, body: str) -> str:
    """CasADi's static function as model_`name`(arg, res), without its optional arguments and work arrays."""
    body = re.sub(r"^static int casadi_f\d+\(.*?\) \{$",
                  f"static void model_{name}(const double **arg, double **res)\n{{\n  (void)arg, (void)res;",
                  body, flags=re.MULTILINE)
    body = re.sub(r"(arg\[\d+\])\? (\1\[\d+\]) : 0", r"\2", body)
    return re.sub(r"if \(res\[\d+\]!=0\) ", "", body).replace("  return 0;\n", "")


def function_code(trace: Trace, own: Hoisted) -> str:
    """The functions as C with internal linkage: void model_NAME(arguments, results).

    CasADi writes them for a library of their own, with exported functions to inquire about them; only the
    functions themselves and the helpers they call are kept. Raises RuntimeError for C of another shape than this
    version of CasADi is known to write.
    """
    generator = casadi.CodeGenerator("model", {"casadi_real": "double", "casadi_int": "int"})
    kept = [own.constants, own.prepare, own.hold, trace.start, *([own.advance] if own.advances_apart else []),
            own.finish, own.outputs, own.derivative, *tangents(trace)]
    for function in kept:
        generator.add(function)
    text = generator.dump()
    before = text.partition("/* Configuration this file")[0]
    _, begins, helpers = before.rpartition("#endif\n\ncasadi_real")
    helpers = re.sub(r"^casadi_real casadi_", "static double casadi_", begins[8:] + helpers, flags=re.MULTILINE)
    bodies = re.findall(r"^/\* (\w+):[^\n]*\*/\n(static int casadi_f\d+\(.*?^\}\n)", text, re.MULTILINE | re.DOTALL)
    code = "\n".join(['#include "mathematics.h"\n', helpers, *(internal_function(*body) for body in bodies)])
    code = re.sub(rf"\b({'|'.join(OWN)})\(", r"own_\1(", code.replace("casadi_real", "double"))
    code += "" if own.advances_apart else "\n#define model_advance model_finish\n"
    if [name for name, _ in bodies] != [f.name() for f in kept] or re.search(r"arg\[\d+\]\?|\b(iw|w|return 1)\b", code):
        raise RuntimeError(f"CasADi {version('casadi')} generates C of another shape than {__name__} knows")
    return code


def c_number(value: float | bool | None, otherwise: str = "0.0") -> str:
    """A number as C that gives the very same double; `otherwise` for None."""
    return otherwise if value is None else repr(float(value))


def table_row(v: Variable, place: int, state: int) -> str:
    """A row of TABLE; `place` is where the value stands among those of its role, `state` which state it is, or -1."""
    limits = f'{c_number(v.minimum, "-DBL_MAX")}, {c_number(v.maximum, "DBL_MAX")}'
    return (f'    {{"{v.name}", {"RATE" if v.derivative_of else ROLES[v.causality]}, {int(v.type == "Boolean")}, '
            f'{int(v.discrete)}, {place}, {state}, {c_number(v.start)}, {limits}, "{v.unit_suffix}", '
            f'{c_number(v.factor)}}},')


def c_array(kind: str, name: str, values: list[str]) -> str:
    """A constant array of C, which has at least one entry."""
    return f"static const {kind} {name}[] = {{{', '.join(values or ['0'])}}};"


def table_header(model: ModuleType, trace: Trace, own: Hoisted) -> str:
    """model.h: sizes, the table, and its limits as arrays."""
    rows, continuous = all_variables(model), [v.name for v in states(model)]
    reference = {v.name: v.value_reference for v in rows}
    groups = {causality: names(rows, causality) for causality in ("input", "parameter", "independent")}
    y = computed(rows)
    results = [rows[reference[name]] for name in y]
    longest = longest_step(rows)
    place = groups["parameter"].index(longest) if longest else None

    def row(v: Variable) -> str:
        state = continuous.index(v.name) if v.name in continuous else -1
        if v.causality == "local":
            return table_row(v, continuous.index(v.derivative_of or v.name), state)
        return table_row(v, groups.get(v.causality, y).index(v.name), state)

    def lengths(of: dict[str, int]) -> str:
        return "enum { " + ", ".join(f"N{name.upper()} = {n}" for name, n in of.items()) + " };"

    return "\n".join([
        f'#define MODEL_NAME "{model.NAME}"',
        lengths({"v": len(rows), **trace.sizes, "c": own.sizes["c"], "s": len(continuous)}),
        lengths({"k": own.sizes["k"], "w": own.sizes["w"]}),
        f"enum {{ HAS_DERIVATIVE = {int(trace.derivative is not None)}, "
        f"HAS_DISCRETE_OUTPUTS = {int(any(v.discrete for v in results))}, "
        f"FIRST_RATE = {len(rows) - 1 - len(continuous)} }};",
        f"#define INTERNAL_STEP(p) {f'((p)[{place}])' if longest else 'INFINITY'}",
        "",
        "static const Variable TABLE[] = {",
        *map(row, rows),
        "};",
        c_array("unsigned", "INPUTS", [str(reference[name]) for name in groups["input"]]),
        c_array("unsigned", "COMPUTED", [str(reference[name]) for name in y]),
        c_array("double", "Y_MINIMUM", [c_number(v.minimum, "-DBL_MAX") for v in results]),
        c_array("double", "Y_MAXIMUM", [c_number(v.maximum, "DBL_MAX") for v in results]),
        c_array("double", "NOMINALS", [c_number(v.nominal, "1.0") for v in states(model)]),
        ""])


def generated_sources(model: ModuleType, trace: Trace) -> dict[str, bytes]:
    """The generated files: name -> content. Raises RuntimeError where CasADi generates other C than expected."""
    own = hoisted(trace, rates(trace))
    return {"model.h": table_header(model, trace, own).encode(),
            "model.c": function_code(trace, own).encode()}
