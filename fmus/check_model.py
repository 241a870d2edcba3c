"""The mistakes of a model, each as one sentence that names the model, the place and what is allowed.

A model is checked before anything is made of it: its parts, its table, its presets, then its functions, which run
once on floats with the table's start values and once on symbols.
"""
from collections.abc import Callable
from inspect import signature
from math import isfinite, isnan
from numbers import Real
from pathlib import Path
from traceback import extract_tb
from types import ModuleType, SimpleNamespace
from typing import Any

import casadi

from . import floats, symbols
from .check_table import (
    NAME_RULE,
    check_presets,
    check_states,
    check_table,
    check_terminals,
    file_name,
    identifier,
    line_of_text,
)
from .integrators import METHODS, USUAL_ORDER, advancing
from .interface import GIVEN, ORIGIN, computed, names, sample_time, variables
from .lines import file_place, function_place
from .mistakes import ModelError as ModelError
from .mistakes import nearest
from .trace import Trace, trace_model

ARGUMENTS = {"start": "m, u, p", "derivative": "m, t, x, u, p", "advance": "m, t, h, x, u, p, c",
             "outputs": "m, t, x, u, p", "prepare": "m, p, h"}
OPTIONAL = ("derivative", "advance", "prepare")
STEP = 0.01  # s, for the trial step
BACKEND = sorted(name for name in vars(floats) if not name.startswith("_"))
NOT_THE_MODELS = (Path(__file__).parent, Path(casadi.__file__).parent)


def checked_trace(model: ModuleType) -> Trace:
    """The trace of `model`, in which no mistake was found. Raises ModelError at the first mistake."""
    check_parts(model)
    check_table(model)
    check_states(model)
    check_terminals(model)
    check_presets(model)
    check_functions(model)
    trace: Trace = attempt(model, SimpleNamespace(), SimpleNamespace(), trace_model, model)
    check_constants(model, trace)
    check_shown_states(model, trace)
    check_symbols(model)
    return trace


# --- what stands in the module ----------------------------------------------------------------------------

def check_parts(model: ModuleType) -> None:
    """Raises ModelError for a part that is missing, or a function with other arguments than the builder gives."""
    for part, kind, what in (("NAME", str, "a name"), ("DESCRIPTION", str, "one line of text"),
                             ("VARIABLES", list, "a list of rows"), ("PRESETS", dict, "a dict of dicts")):
        if not isinstance(getattr(model, part, None), kind):
            raise ModelError(model, f"{part} is missing or is not {what}; a model has NAME, DESCRIPTION, VARIABLES, "
                                    "PRESETS, start, outputs, and derivative or advance where it has a state",
                             file_place(model))
    if not identifier(model.NAME):
        raise ModelError(model, f"NAME {model.NAME!r} is not allowed; {NAME_RULE}")
    if not file_name(model.NAME):
        raise ModelError(model, f"NAME {model.NAME!r} is not allowed; Windows has no files of that name")
    if not line_of_text(model.DESCRIPTION):
        raise ModelError(model, "DESCRIPTION must be one line, without control characters")
    if not model.VARIABLES:
        raise ModelError(model, "VARIABLES is empty; an FMU has at least one variable", file_place(model))
    for part in ORIGIN:
        if not line_of_text(getattr(model, part, "")):
            raise ModelError(model, f"{part} must be one line of text, without control characters")
    for function, arguments in ARGUMENTS.items():
        written = getattr(model, function, None)
        if written is None and function in OPTIONAL:
            continue
        if not callable(written):
            raise ModelError(model, f"there is no function {function}({arguments})", file_place(model))
        try:
            signature(written).bind(*arguments.split(", "))
        except TypeError:
            raise ModelError(model, f"{function}{signature(written)} has other arguments than "
                                    f"{function}({arguments}), as which it is called",
                             function_place(written)) from None
    order = getattr(model, "ORDER", USUAL_ORDER)
    if type(order) is not int or order not in METHODS:
        raise ModelError(model, f"ORDER {order!r} is not allowed; the methods have the orders "
                                f"{', '.join(map(str, METHODS))}")


# --- what the functions do --------------------------------------------------------------------------------

def check_functions(model: ModuleType) -> None:
    """Run the functions on floats, from the table's start values. Raises ModelError for one that fails, or returns what
    it should not."""
    table = variables(model.VARIABLES)
    u, p = (SimpleNamespace(**{v.name: v.start for v in table if v.causality == kind}) for kind in GIVEN)
    h = sample_time(table) or min(STEP, float(getattr(p, "internal_step", STEP)))

    def call(name: str, *arguments: Any, function: Callable[..., Any] | None = None) -> Any:
        of = function or getattr(model, name)
        found, again = (attempt(model, u, p, of, floats, *arguments) for _ in range(2))
        if repr(again) != repr(found):
            raise ModelError(model, f"{name}() gives something else when it is called again with the same arguments; "
                                    "it must depend on nothing else", function_place(getattr(model, name, None)))
        return found

    x = call("start", u, p)
    check_numbers(model, "start", x, "state")
    if x and not (hasattr(model, "derivative") or hasattr(model, "advance")):
        raise ModelError(model, f"there is neither a function derivative({ARGUMENTS['derivative']}) nor "
                                f"advance({ARGUMENTS['advance']}); a model with a state has one of them, or both",
                         file_place(model))
    c = call("prepare", p, h) if hasattr(model, "prepare") else []
    check_numbers(model, "prepare", c, "number")
    if hasattr(model, "derivative"):
        rates = call("derivative", 0.0, x, u, p)
        check_numbers(model, "derivative", rates, "rate")
        if not len(rates) == len(model.STATES) <= len(x):
            raise ModelError(model, f"derivative() returns {len(rates)} rates, STATES has {len(model.STATES)} entries, "
                                    f"start() returns {len(x)} states; a rate and an entry belong to each of the first "
                                    "states, and the rest are memories", function_place(model.derivative))
    later = call("advance", 0.0, h, x, u, p, c, function=advancing(model))
    check_numbers(model, "advance", later, "state")
    if len(later) != len(x):
        raise ModelError(model, f"advance() returns {len(later)} states, but start() {len(x)}; their number is fixed",
                         function_place(getattr(model, "advance", None)))
    y = call("outputs", 0.0, x, u, p)
    if not isinstance(y, dict):
        raise ModelError(model, f"outputs() returns a {type(y).__name__}, not a dict of names and values",
                         function_place(model.outputs))
    missing = [name for name in computed(table) if name not in y]
    extra = [str(name) for name in y if name not in computed(table)]
    if missing:
        raise ModelError(model, f"outputs() does not return {', '.join(missing)}; it must return every output and "
                                "calculatedParameter of VARIABLES", function_place(model.outputs))
    if extra:
        raise ModelError(model, f"outputs() returns {', '.join(extra)}, which VARIABLES does not declare as "
                                "output or calculatedParameter", function_place(model.outputs))
    check_numbers(model, "outputs", [y[name] for name in computed(table)], "output", computed(table))


def check_numbers(model: ModuleType, function: str, values: Any, what: str, labels: list[str] | None = None) -> None:
    """Raises ModelError where what `function` returned is no list of finite numbers."""
    if not isinstance(values, (list, tuple)):
        raise ModelError(model, f"{function}() returns a {type(values).__name__}, not a list of numbers",
                         function_place(getattr(model, function, None)))
    for i, value in enumerate(values):
        if not (isinstance(value, Real) and isfinite(value)):
            raise ModelError(model, f"{function}() gives {value!r} for the {what} {labels[i] if labels else i}, from "
                                    "the start values of VARIABLES; a finite number is needed",
                             function_place(getattr(model, function, None)))


def attempt(model: ModuleType, u: SimpleNamespace, p: SimpleNamespace, function: Callable[..., Any],
            *arguments: Any) -> Any:
    """function(*arguments), a piece of `model`. Raises ModelError, which names the line, where it fails."""
    try:
        return function(*arguments)
    except Exception as error:
        raise ModelError(model, failure(error, model, u, p)) from error


def failure(error: BaseException, model: ModuleType, u: SimpleNamespace, p: SimpleNamespace) -> str:
    """Where and why a model's function, or its file, failed."""
    if isinstance(error, SyntaxError):
        file = Path(error.filename or str(model.__file__)).name
        return f"{file}, line {error.lineno or 1}, is no Python: {error.msg}"
    frames = [f for f in extract_tb(error.__traceback__)
              if not any(Path(f.filename).is_relative_to(folder) for folder in NOT_THE_MODELS)
              or Path(f.filename) == Path(str(model.__file__))]
    where = f"{frames[-1].name}() in {Path(frames[-1].filename).name}, line {frames[-1].lineno}," if frames else "it"
    if isinstance(error, AttributeError) and any(error.obj is backend for backend in (floats, symbols)):
        return f"{where} uses m.{error.name}, which the backend lacks; m has {', '.join(BACKEND)}"
    for letter, values, kind in (("u", u, "input"), ("p", p, "parameter")):
        if isinstance(error, AttributeError) and error.obj is values:
            return f"{where} reads {letter}.{error.name}, which is no {kind}{nearest(error.name, vars(values))}"
    if "truth value" in str(error):
        return (f"{where} decides on a symbol, which has no value yet (if, and, or, not, min, max, a < b < c); use "
                "m.where, m.both, m.either, m.fmin and m.fmax instead")
    if "to_int" in str(error) or (isinstance(error, TypeError) and "integer" in str(error)):
        return f"{where} uses a symbol as a whole number (int, range or an index); use m.floor and m.where instead"
    return f"{where} fails with {type(error).__name__}: {' '.join(str(error).split()).removesuffix('.')}"


def check_constants(model: ModuleType, trace: Trace) -> None:
    """Raises ModelError where a traced function has NaN in it: what `math` and float() make of a symbol."""
    derivative = [trace.derivative] if trace.derivative else []
    for function in (trace.start, trace.prepare, *derivative, trace.advance, trace.outputs):
        constants = [function.instruction_constant(k) for k in range(function.n_instructions())
                     if function.instruction_id(k) == casadi.OP_CONST]
        if any(map(isnan, constants)):
            raise ModelError(model, f"{function.name()}() gives NaN on symbols, which is what float() and the "
                                    f"functions of math make of them; use m, which has {', '.join(BACKEND)}",
                             function_place(getattr(model, function.name(), None)))


def check_shown_states(model: ModuleType, trace: Trace) -> None:
    """Raises ModelError where an output that STATES names does not show that state."""
    t, x, u, p = (casadi.SX.sym(name, trace.outputs.size1_in(name)) for name in "txup")
    y, place = trace.outputs(t, x, u, p), computed(variables(model.VARIABLES)).index
    for i, entry in enumerate(getattr(model, "STATES", [])):
        if isinstance(entry, str) and not casadi.is_equal(y[place(entry)], x[i]):
            raise ModelError(model, f"outputs() gives something else for {entry} than state {i}, which STATES names so",
                             function_place(model.outputs))


def check_symbols(model: ModuleType) -> None:
    """Raises ModelError for a function that changes its arguments, and for a calculated parameter that would change
    during a flight."""
    table = variables(model.VARIABLES)
    t, h = casadi.SX.sym("t"), casadi.SX.sym("h")
    u, p = (SimpleNamespace(**{name: casadi.SX.sym(name) for name in names(table, kind)}) for kind in GIVEN)

    def call(name: str, *arguments: Any) -> Any:
        if not hasattr(model, name):
            return []
        before = repr((u, p, arguments))
        found = attempt(model, u, p, getattr(model, name), symbols, *arguments)
        if repr((u, p, arguments)) != before:
            raise ModelError(model, f"{name}() changes its arguments; it must leave x, u and p as they are, and return "
                                    "what is new", function_place(getattr(model, name)))
        return found

    x = [casadi.SX.sym(f"x[{i}]") for i in range(len(call("start", u, p)))]
    c = [casadi.SX.sym(f"c[{i}]") for i in range(len(call("prepare", p, h)))]
    call("derivative", t, x, u, p)
    call("advance", t, h, x, u, p, c)
    y = call("outputs", t, x, u, p)
    changing = [("t", t), *((f"u.{name}", symbol) for name, symbol in vars(u).items()),
                *((symbol.name(), symbol) for symbol in x[:len(getattr(model, "STATES", []))])]
    for name in names(table, "calculatedParameter"):
        for of, symbol in changing:
            if casadi.depends_on(casadi.SX(y[name]), symbol):
                raise ModelError(model, f"outputs() computes {name} from {of}, which changes; a calculatedParameter "
                                        "depends on parameters and memories only, another is an output",
                                 function_place(model.outputs))
