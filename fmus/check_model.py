"""The mistakes of a model, each as one sentence that names the model, the place and what is allowed.

A model is checked before anything is made of it: its parts, its table, its presets, then its functions, which run
once on floats with the table's start values and once on symbols.
"""
import re
from collections.abc import Callable
from difflib import get_close_matches
from inspect import signature
from keyword import iskeyword
from math import isfinite, isnan
from numbers import Real
from pathlib import Path
from traceback import extract_tb
from types import ModuleType, SimpleNamespace
from typing import Any, TypeGuard

import casadi

from . import floats, symbols
from .integrators import METHODS, USUAL_ORDER, advancing
from .interface import CAUSALITIES, COLUMNS, GIVEN, Variable, computed, names, sample_time, states, variables
from .trace import Trace, trace_model
from .units import si_base

ARGUMENTS = {"start": "m, u, p", "derivative": "m, t, x, u, p", "advance": "m, t, h, x, u, p, c",
             "outputs": "m, t, x, u, p", "prepare": "m, p, h"}
OPTIONAL = ("derivative", "advance", "prepare")
STEP = 0.01  # s, for the trial step
STEPS = ("internal_step", "sample_time")
KINDS = ("", "frequency", "discrete")  # what may follow a unit, see `fmus.interface`
BACKEND = sorted(name for name in vars(floats) if not name.startswith("_"))
NAME_RULE = "a name has ASCII letters, digits and _, begins with no digit and is no Python keyword"
NOT_THE_MODELS = (Path(__file__).parent, Path(casadi.__file__).parent)


class ModelError(ValueError):
    """A mistake in a model: one sentence, which begins with the model's name."""

    def __init__(self, model: ModuleType, sentence: str):
        """`sentence` goes on after the model's name, and has no full stop."""
        super().__init__(f"{getattr(model, 'NAME', model.__name__)}: {sentence}.")


def checked_trace(model: ModuleType) -> Trace:
    """The trace of `model`, in which no mistake was found. Raises ModelError at the first mistake."""
    check_parts(model)
    check_table(model)
    check_states(model)
    check_presets(model)
    check_functions(model)
    trace: Trace = attempt(model, SimpleNamespace(), SimpleNamespace(), trace_model, model)
    check_constants(model, trace)
    check_shown_states(model, trace)
    return trace


# --- what stands in the module ----------------------------------------------------------------------------

def identifier(text: object) -> bool:
    """Whether C, XML and Python can have `text` as a name."""
    return isinstance(text, str) and bool(re.fullmatch(r"[A-Za-z_]\w*", text, re.ASCII)) and not iskeyword(text)


def line_of_text(text: object) -> bool:
    """Whether `text` can be an XML attribute: a string without line feeds and what else XML 1.0 does not have."""
    return isinstance(text, str) and not re.search("[\x00-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff]", text)


def finite_number(value: object) -> TypeGuard[float]:
    """Whether `value` is a finite number, and no truth value."""
    return isinstance(value, Real) and not isinstance(value, bool) and isfinite(value)


def check_parts(model: ModuleType) -> None:
    """Raises ModelError for a part that is missing, or a function with other arguments than the builder gives."""
    for part, kind, what in (("NAME", str, "a name"), ("DESCRIPTION", str, "one line of text"),
                             ("VARIABLES", list, "a list of rows"), ("PRESETS", dict, "a dict of dicts")):
        if not isinstance(getattr(model, part, None), kind):
            raise ModelError(model, f"{part} is missing or is not {what}; a model has NAME, DESCRIPTION, VARIABLES, "
                                    "PRESETS, start, outputs, and derivative or advance")
    if not identifier(model.NAME):
        raise ModelError(model, f"NAME {model.NAME!r} is not allowed; {NAME_RULE}")
    if not line_of_text(model.DESCRIPTION):
        raise ModelError(model, "DESCRIPTION must be one line, without control characters")
    for function, arguments in ARGUMENTS.items():
        written = getattr(model, function, None)
        if written is None and function in OPTIONAL:
            continue
        if not callable(written):
            raise ModelError(model, f"there is no function {function}({arguments})")
        try:
            signature(written).bind(*arguments.split(", "))
        except TypeError:
            raise ModelError(model, f"{function}{signature(written)} has other arguments than "
                                    f"{function}({arguments}), as which it is called") from None
    if not (hasattr(model, "derivative") or hasattr(model, "advance")):
        raise ModelError(model, f"there is neither a function derivative({ARGUMENTS['derivative']}) nor "
                                f"advance({ARGUMENTS['advance']}); a model has one of them, or both")
    if getattr(model, "ORDER", USUAL_ORDER) not in METHODS:
        raise ModelError(model, f"ORDER {model.ORDER!r} is not allowed; the methods have the orders "
                                f"{', '.join(map(str, METHODS))}")


def check_table(model: ModuleType) -> None:
    """Raises ModelError for a row of VARIABLES that has another length, contradicts itself, or cannot be written."""
    found: set[str] = set()
    for i, row in enumerate(model.VARIABLES):
        check_row(model, f"row {i + 1} of VARIABLES", row, CAUSALITIES, found)
    for v in variables(model.VARIABLES):
        check_values(model, v)
        if v.name in STEPS and not (v.causality == "parameter" and v.unit == "s" and (v.minimum or 0) > 0):
            raise ModelError(model, f"{v.name} must be a parameter in s with a minimum above 0")
    if found.issuperset(STEPS):
        raise ModelError(model, "sample_time and internal_step exclude each other; a discrete law takes no internal "
                                "steps")


def check_row(model: ModuleType, place: str, row: Any, causalities: tuple[str, ...], found: set[str]) -> None:
    """Raises ModelError for a row at `place` that cannot become a record; its name joins `found`, the names before."""
    if not isinstance(row, (tuple, list)) or len(row) != len(COLUMNS):
        length = f" has {len(row)} entries" if isinstance(row, (tuple, list)) else " is not a tuple"
        raise ModelError(model, f"{place}, {row!r},{length}; a row is ({', '.join(COLUMNS)})")
    name, causality, unit, *_, description = row
    if not identifier(name):
        raise ModelError(model, f"the variable name {name!r} is not allowed; {NAME_RULE}")
    if name in found:
        raise ModelError(model, f"{name} stands twice in the table; names must differ")
    if causality not in causalities:
        raise ModelError(model, f"{name}: causality {causality!r} is none of {', '.join(causalities)}")
    reason = unit_mistake(unit)
    if reason:
        raise ModelError(model, f"{name}: {reason}")
    if not line_of_text(description):
        raise ModelError(model, f"{name}: the description must be one line of text, without control characters")
    found.add(name)


def check_values(model: ModuleType, v: Variable) -> None:
    """Raises ModelError for a limit, a nominal or a start value that `v` cannot have."""
    reason = range_mistake(v) or start_mistake(v)
    if reason:
        raise ModelError(model, f"{v.name}: {reason}")


def check_states(model: ModuleType) -> None:
    """Raises ModelError for STATES that do not go with the table or with the functions."""
    if not hasattr(model, "derivative"):
        if hasattr(model, "STATES"):
            raise ModelError(model, "there are STATES, but no function derivative; STATES name its rates")
        return
    table = variables(model.VARIABLES)
    if sample_time(table) is not None:
        raise ModelError(model, "there are sample_time and derivative; a discrete law has advance only")
    if not isinstance(getattr(model, "STATES", None), (list, tuple)):
        raise ModelError(model, "STATES is missing or is not a list; beside derivative it has, for each rate, the name "
                                "of an output or a row with the causality 'local'")
    found = {v.name for v in table}
    shown = [v.name for v in table if v.causality == "output" and v.type == "Real" and not v.discrete]
    for i, entry in enumerate(model.STATES):
        if not isinstance(entry, str):
            check_row(model, f"entry {i + 1} of STATES", entry, ("local",), found)
        elif entry not in shown:
            raise ModelError(model, f"STATES names {entry}, which is no continuous output{nearest(entry, shown)}; a "
                                    "state that is no output is a row with the causality 'local'")
        elif entry in model.STATES[:i]:
            raise ModelError(model, f"{entry} stands twice in STATES")
    for v in states(model):
        check_values(model, v)
        if v.type == "Boolean" or v.discrete:
            raise ModelError(model, f"{v.name}: a continuous state has a unit, and is not discrete")
    if not hasattr(model, "advance") and "internal_step" not in names(table, "parameter"):
        raise ModelError(model, "there is no parameter internal_step; a model without advance is integrated in steps "
                                "no longer than that")


def unit_mistake(text: object) -> str | None:
    """Why `text` cannot be the unit in a row, or None."""
    if not isinstance(text, str):
        return f"the unit {text!r} is not text, such as 'ft/s'; '' makes a Boolean"
    unit, _, kind = text.partition(" ")
    try:
        if unit:
            si_base(unit)
    except ValueError as error:
        return f"in the unit {text!r}, {error}; '' makes a Boolean"
    return None if kind in KINDS else f"in the unit {text!r}, only 'frequency' or 'discrete' may follow"


def range_mistake(v: Variable) -> str | None:
    """Why `v` cannot have its limits and nominal value, or None."""
    limits = {"min": v.minimum, "max": v.maximum, "nominal": v.nominal}
    given = {column: value for column, value in limits.items() if value is not None}
    for column, value in given.items():
        if v.type == "Boolean":
            return f"a Boolean (unit '') has no {column}, but {value!r} is given; None is right"
        if not finite_number(value):
            return f"{column} {value!r} is not a finite number; None means that there is none"
    if v.minimum is not None and v.maximum is not None and v.minimum > v.maximum:
        return f"min {v.minimum} is above max {v.maximum}"
    if v.nominal is not None and v.nominal <= 0:
        return f"nominal {v.nominal} is not above 0"
    return None


def start_mistake(v: Variable) -> str | None:
    """Why `v` cannot have its start value, or None."""
    if (v.start is not None) != (v.causality in GIVEN):
        return ("inputs and parameters have a start value, outputs have none; "
                f"this {v.causality} has {v.start!r}")
    return None if v.start is None else value_mistake(v, v.start, "start")


def value_mistake(v: Variable, value: object, what: str) -> str | None:
    """Why `v` cannot have `value`, which is its `what`, or None."""
    if v.type == "Boolean":
        return None if isinstance(value, bool) else f"{what} {value!r} is not True or False, as a Boolean (unit '') has"
    if not finite_number(value):
        return f"{what} {value!r} is not a finite number"
    low = float("-inf") if v.minimum is None else v.minimum
    high = float("inf") if v.maximum is None else v.maximum
    return None if low <= value <= high else f"{what} {value} is outside [{low}, {high}]"


def check_presets(model: ModuleType) -> None:
    """Raises ModelError for a preset whose name cannot be a file's, or which sets what it cannot."""
    parameters = {v.name: v for v in variables(model.VARIABLES) if v.causality == "parameter"}
    for preset, values in model.PRESETS.items():
        if not (isinstance(preset, str) and re.fullmatch(r"\w[\w.-]*", preset, re.ASCII)):
            raise ModelError(model, f"the preset name {preset!r} is not allowed; it becomes a file's name, of "
                                    "ASCII letters, digits, '_', '-' and '.' after the first")
        if not isinstance(values, dict):
            raise ModelError(model, f"the preset {preset} is not a dict of parameters and values")
        for name, value in values.items():
            if name not in parameters:
                raise ModelError(model, f"the preset {preset} sets {name}, which is no parameter"
                                        + nearest(name, parameters))
            reason = value_mistake(parameters[name], value, "the value")
            if reason:
                raise ModelError(model, f"the preset {preset} sets {name}, but {reason}")


def nearest(name: object, known: Any) -> str:
    """What may have been meant by `name`, in brackets."""
    near = get_close_matches(str(name), known, 3)
    return f" (did you mean {' or '.join(near)}?)" if near else f" (there are {', '.join(known) or 'none'})"


# --- what the functions do --------------------------------------------------------------------------------

def check_functions(model: ModuleType) -> None:
    """Run the functions on floats, from the table's start values. Raises ModelError for one that fails, or returns what
    it should not."""
    table = variables(model.VARIABLES)
    u, p = (SimpleNamespace(**{v.name: v.start for v in table if v.causality == kind}) for kind in GIVEN)
    h = sample_time(table) or min(STEP, float(getattr(p, "internal_step", STEP)))

    def call(name: str, *arguments: Any) -> Any:
        return attempt(model, u, p, getattr(model, name), floats, *arguments)

    x = call("start", u, p)
    check_numbers(model, "start()", x, "state")
    c = call("prepare", p, h) if hasattr(model, "prepare") else []
    check_numbers(model, "prepare()", c, "number")
    if hasattr(model, "derivative"):
        rates = call("derivative", 0.0, x, u, p)
        check_numbers(model, "derivative()", rates, "rate")
        if not len(rates) == len(model.STATES) <= len(x):
            raise ModelError(model, f"derivative() returns {len(rates)} rates, STATES has {len(model.STATES)} entries, "
                                    f"start() returns {len(x)} states; a rate and an entry belong to each of the first "
                                    "states, and the rest are memories")
    later = attempt(model, u, p, advancing(model), floats, 0.0, h, x, u, p, c)
    check_numbers(model, "advance()", later, "state")
    if len(later) != len(x):
        raise ModelError(model, f"advance() returns {len(later)} states, but start() {len(x)}; their number is fixed")
    y = call("outputs", 0.0, x, u, p)
    if not isinstance(y, dict):
        raise ModelError(model, f"outputs() returns a {type(y).__name__}, not a dict of names and values")
    missing = [name for name in computed(table) if name not in y]
    extra = [str(name) for name in y if name not in computed(table)]
    if missing:
        raise ModelError(model, f"outputs() does not return {', '.join(missing)}; it must return every output and "
                                "calculatedParameter of VARIABLES")
    if extra:
        raise ModelError(model, f"outputs() returns {', '.join(extra)}, which VARIABLES does not declare as "
                                "output or calculatedParameter")
    check_numbers(model, "outputs()", [y[name] for name in computed(table)], "output", computed(table))


def check_numbers(model: ModuleType, function: str, values: Any, what: str, labels: list[str] | None = None) -> None:
    """Raises ModelError where what `function` returned is no list of finite numbers."""
    if not isinstance(values, (list, tuple)):
        raise ModelError(model, f"{function} returns a {type(values).__name__}, not a list of numbers")
    for i, value in enumerate(values):
        if not (isinstance(value, Real) and isfinite(value)):
            raise ModelError(model, f"{function} gives {value!r} for the {what} {labels[i] if labels else i}, from the "
                                    "start values of VARIABLES; a finite number is needed")


def attempt(model: ModuleType, u: SimpleNamespace, p: SimpleNamespace, function: Callable[..., Any],
            *arguments: Any) -> Any:
    """function(*arguments), a piece of `model`. Raises ModelError, which names the line, where it fails."""
    try:
        return function(*arguments)
    except Exception as error:
        raise ModelError(model, failure(error, model, u, p)) from error


def failure(error: Exception, model: ModuleType, u: SimpleNamespace, p: SimpleNamespace) -> str:
    """Where and why a model's function failed."""
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
                                    f"functions of math make of them; use m, which has {', '.join(BACKEND)}")


def check_shown_states(model: ModuleType, trace: Trace) -> None:
    """Raises ModelError where an output that STATES names does not show that state."""
    t, x, u, p = (casadi.SX.sym(name, trace.outputs.size1_in(name)) for name in "txup")
    y, place = trace.outputs(t, x, u, p), computed(variables(model.VARIABLES)).index
    for i, entry in enumerate(getattr(model, "STATES", [])):
        if isinstance(entry, str) and not casadi.is_equal(y[place(entry)], x[i]):
            raise ModelError(model, f"outputs() gives something else for {entry} than state {i}, which STATES names so")
