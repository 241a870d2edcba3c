"""A model's C: its traced functions through CasADi's code generator, and its table."""
import re
from importlib.metadata import version
from types import ModuleType

import casadi

from .interface import Variable, computed, names, variables
from .hoist import hoisted
from .trace import Trace
from .units import DEGREES

CAUSALITY = {"input": "INPUT", "output": "OUTPUT", "calculatedParameter": "CALCULATED_PARAMETER",
             "parameter": "PARAMETER"}


def tangents(trace: Trace) -> list[casadi.Function]:
    """Directional derivatives of the outputs: after a step with respect to u; at the start, through the
    initial state, with respect to u and p."""
    n = trace.sizes
    t, x = casadi.SX.sym("t"), casadi.SX.sym("x", n["x"])
    u, p = casadi.SX.sym("u", n["u"]), casadi.SX.sym("p", n["p"])
    du, dp = casadi.SX.sym("du", n["u"]), casadi.SX.sym("dp", n["p"])
    after = casadi.jtimes(trace.outputs(t, x, u, p), u, du)
    start = casadi.jtimes(trace.outputs(t, trace.start(u, p), u, p), casadi.vertcat(u, p), casadi.vertcat(du, dp))
    return [casadi.Function("tangent", [t, x, u, p, du], [casadi.densify(after)]),
            casadi.Function("start_tangent", [t, u, p, du, dp], [casadi.densify(start)])]


def internal_function(name: str, body: str) -> str:
    """CasADi's static function as model_`name`(arg, res), without its optional arguments and work arrays."""
    body = re.sub(r"^static int casadi_f\d+\(.*?\) \{$",
                  f"static void model_{name}(const double **arg, double **res)\n{{\n  (void)arg, (void)res;",
                  body, flags=re.MULTILINE)
    body = re.sub(r"(arg\[\d+\])\? (\1\[\d+\]) : 0", r"\2", body)
    return re.sub(r"if \(res\[\d+\]!=0\) ", "", body).replace("  return 0;\n", "")


def function_code(trace: Trace) -> str:
    """The functions as C with internal linkage: void model_NAME(arguments, results).

    CasADi writes them for a library of their own, with exported functions to inquire about them; only the
    functions themselves and the helpers they call are kept. Raises RuntimeError for C of another shape than this
    version of CasADi is known to write.
    """
    generator = casadi.CodeGenerator("model", {"casadi_real": "double", "casadi_int": "int"})
    own = hoisted(trace)
    kept = [own.constants, own.prepare, own.hold, trace.start, own.advance, own.outputs, own.finish, *tangents(trace)]
    for function in kept:
        generator.add(function)
    text = generator.dump()
    before = text.partition("/* Configuration this file")[0]
    _, begins, helpers = before.rpartition("#endif\n\ncasadi_real")
    helpers = re.sub(r"^casadi_real casadi_", "static double casadi_", begins[8:] + helpers, flags=re.MULTILINE)
    bodies = re.findall(r"^/\* (\w+):[^\n]*\*/\n(static int casadi_f\d+\(.*?^\}\n)", text, re.MULTILINE | re.DOTALL)
    code = "\n".join(["#include <math.h>\n", helpers, *(internal_function(*body) for body in bodies)])
    code = code.replace("casadi_real", "double")
    if [name for name, _ in bodies] != [f.name() for f in kept] or re.search(r"arg\[\d+\]\?|\b(iw|w|return 1)\b", code):
        raise RuntimeError(f"CasADi {version('casadi')} generates C of another shape than {__name__} knows")
    return code


def c_number(value: float | bool | None, otherwise: str = "0.0") -> str:
    """A number as C that gives the very same double; `otherwise` for None."""
    return otherwise if value is None else repr(float(value))


def table_row(v: Variable, place: int) -> str:
    """A row of TABLE; `place` is where the value stands among those of its causality."""
    factor = DEGREES if v.display_unit else 1.0
    limits = f'{c_number(v.minimum, "-DBL_MAX")}, {c_number(v.maximum, "DBL_MAX")}'
    return (f'    {{"{v.name}", {CAUSALITY[v.causality]}, {int(v.type == "Boolean")}, {place}, {c_number(v.start)}, '
            f'{limits}, "{v.unit_suffix}", {c_number(factor)}}},')


def c_array(kind: str, name: str, values: list[str]) -> str:
    """A constant array of C, which has at least one entry."""
    return f"static const {kind} {name}[] = {{{', '.join(values or ['0'])}}};"


def table_header(model: ModuleType, trace: Trace) -> str:
    """model.h: sizes, the table, and its limits as arrays."""
    rows = variables(model.VARIABLES)
    reference = {v.name: v.value_reference for v in rows}
    groups = {"input": names(rows, "input"), "parameter": names(rows, "parameter")}
    y = computed(rows)
    results = [rows[reference[name]] for name in y]
    step = groups["parameter"].index("internal_step") if "internal_step" in groups["parameter"] else None
    return "\n".join([
        f'#define MODEL_NAME "{model.NAME}"',
        f"enum {{ NV = {len(rows)}, " + ", ".join(f"N{k.upper()} = {n}" for k, n in trace.sizes.items()) + " };",
        f"#define INTERNAL_STEP(p) {'INFINITY' if step is None else f'((p)[{step}])'}",
        "",
        "static const Variable TABLE[] = {",
        *(table_row(v, groups.get(v.causality, y).index(v.name)) for v in rows),
        "};",
        c_array("unsigned", "INPUTS", [str(reference[name]) for name in groups["input"]]),
        c_array("unsigned", "COMPUTED", [str(reference[name]) for name in y]),
        c_array("double", "Y_MINIMUM", [c_number(v.minimum, "-DBL_MAX") for v in results]),
        c_array("double", "Y_MAXIMUM", [c_number(v.maximum, "DBL_MAX") for v in results]),
        ""])


def generated_sources(model: ModuleType, trace: Trace) -> dict[str, bytes]:
    """The generated files: name -> content. Raises RuntimeError where CasADi generates other C than expected."""
    return {"model.h": table_header(model, trace).encode(), "model.c": function_code(trace).encode()}
