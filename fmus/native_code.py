"""A model's C: its traced functions through CasADi's code generator, and its table."""
import re
from types import ModuleType

import casadi

from .interface import Variable, computed, names, variables
from .trace import Trace
from .units import DEGREES, display_unit

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


def functions(trace: Trace) -> str:
    """The functions as C with internal linkage: model_NAME(arg, res), pointers to arguments and results.

    CasADi writes them for a library of their own, with exported access functions, optional arguments and work
    arrays; of all that only the bodies are kept.
    """
    generator = casadi.CodeGenerator("model", {"casadi_real": "double", "casadi_int": "int"})
    kept = [trace.prepare, trace.start, trace.advance, trace.outputs, *tangents(trace)]
    for function in kept:
        generator.add(function)
    text = generator.dump()
    helpers = text.rpartition("/* Configuration this file")[0].rpartition("#endif\n\ncasadi_real")
    bodies = re.findall(r"^/\* (\w+):[^\n]*\*/\n(static int casadi_f\d+\(.*?^\}\n)", text, re.MULTILINE | re.DOTALL)
    if [name for name, _ in bodies] != [function.name() for function in kept]:
        raise RuntimeError(f"CasADi {casadi.__version__} generates C of another shape than {__name__} knows")
    parts = ["#include <math.h>\n"]
    if helpers[1]:
        parts.append(re.sub(r"^casadi_real casadi_", "static double casadi_", "casadi_real" + helpers[2], flags=re.MULTILINE))
    for name, body in bodies:
        body = re.sub(r"^static int casadi_f\d+\(.*?\) \{$",
                      f"static void model_{name}(const double **arg, double **res)\n{{\n"
                      "  (void)arg, (void)res;", body, flags=re.MULTILINE)
        body = re.sub(r"  return 0;\n", "", body)
        body = re.sub(r"(arg\[\d+\])\? (\1\[\d+\]) : 0", r"\2", body)
        parts.append(re.sub(r"if \(res\[0\]!=0\) ", "", body))
    code = "\n".join(parts).replace("casadi_real", "double")
    if re.search(r"\b(arg\[\d+\]\?|iw|w)\b", code):
        raise RuntimeError(f"CasADi {casadi.__version__} generates C of another shape than {__name__} knows")
    return code


def real(value: float | bool | None, otherwise: str = "0.0") -> str:
    return otherwise if value is None else repr(float(value))


def row(v: Variable, place: int) -> str:
    unit, factor = v.unit, 1.0
    shown = display_unit(unit)
    if shown:
        unit, factor = shown, DEGREES
    unit = "" if unit in ("", "1") else f" {unit}"
    boolean = int(v.type == "Boolean")
    return (f'    {{"{v.name}", {CAUSALITY[v.causality]}, {boolean}, {place}, {real(v.start)}, '
            f'{real(v.minimum, "-DBL_MAX")}, {real(v.maximum, "DBL_MAX")}, "{unit}", {real(factor)}}},')


def array(kind: str, name: str, values: list[str]) -> str:
    return f"static const {kind} {name}[] = {{{', '.join(values or ['0'])}}};"


def table(model: ModuleType, trace: Trace) -> str:
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
        *(row(v, groups.get(v.causality, y).index(v.name)) for v in rows),
        "};",
        array("unsigned", "INPUTS", [str(reference[name]) for name in groups["input"]]),
        array("unsigned", "COMPUTED", [str(reference[name]) for name in y]),
        array("double", "Y_MINIMUM", [real(v.minimum, "-DBL_MAX") for v in results]),
        array("double", "Y_MAXIMUM", [real(v.maximum, "DBL_MAX") for v in results]),
        ""])


def sources(model: ModuleType, trace: Trace) -> dict[str, bytes]:
    """The generated files."""
    return {"model.h": table(model, trace).encode(), "model.c": functions(trace).encode()}
