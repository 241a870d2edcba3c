"""The mistakes of a model's table, its states and its presets; see `fmus.check_model`."""
import re
from keyword import iskeyword
from math import isfinite
from numbers import Real
from types import ModuleType
from typing import Any, TypeGuard

from .interface import CAUSALITIES, COLUMNS, GIVEN, Variable, names, sample_time, states, variables
from .lines import file_place, function_place, key_place, row_place
from .mistakes import ModelError, nearest
from .units import BASE_UNITS, WORTH, Worth, si_base

STEPS = ("internal_step", "sample_time")
KINDS = ("", "frequency", "discrete")  # what may follow a unit, see `fmus.interface`
NAME_RULE = ("a name has ASCII letters, digits and _, begins with no digit and is no Python keyword, no keyword of C "
             "and nothing that C keeps for itself (__x, _X)")
C_KEYWORDS = (
    "auto", "break", "case", "char", "const", "continue", "default", "do", "double", "else", "enum", "extern", "float",
    "for", "goto", "if", "inline", "int", "long", "register", "restrict", "return", "short", "signed", "sizeof",
    "static", "struct", "switch", "typedef", "union", "unsigned", "void", "volatile", "while", "asm")
NO_FILES = re.compile(r"(con|prn|aux|nul|com\d|lpt\d)", re.IGNORECASE)  # on Windows, with any ending


def identifier(text: object) -> bool:
    """Whether C, XML and Python can have `text` as a name."""
    return (isinstance(text, str) and bool(re.fullmatch(r"[A-Za-z_]\w*", text, re.ASCII))
            and not re.match("_[_A-Z]", text) and not iskeyword(text) and text not in C_KEYWORDS)


def file_name(text: str) -> bool:
    """Whether every system can have a file of the name `text`, with any ending."""
    return not NO_FILES.fullmatch(text)


def line_of_text(text: object) -> bool:
    """Whether `text` can be an XML attribute: a string without line feeds and what else XML 1.0 does not have."""
    return isinstance(text, str) and not re.search("[\x00-\x1f\x7f-\x9f\ud800-\udfff\ufffe\uffff]", text)


def finite_number(value: object) -> TypeGuard[float]:
    """Whether `value` is a finite number, and no truth value."""
    return isinstance(value, Real) and not isinstance(value, bool) and isfinite(value)


def check_table(model: ModuleType) -> None:
    """Raises ModelError for a row of VARIABLES that has another length, contradicts itself, or cannot be written."""
    check_units(model)
    found: set[str] = set()
    for i, row in enumerate(model.VARIABLES):
        check_row(model, ("VARIABLES", i, row), CAUSALITIES, found)
    for v, row in zip(variables(model.VARIABLES), model.VARIABLES):
        place = ("VARIABLES", v.value_reference, row)
        check_values(model, place, v)
        if v.name in STEPS and not (v.causality == "parameter" and v.unit == "s" and (v.minimum or 0) > 0):
            raise row_error(model, place, f"{v.name} must be a parameter in s with a minimum above 0")
        if v.name in STEPS and found.issuperset(STEPS):
            raise row_error(model, place, "sample_time and internal_step exclude each other; a discrete law takes no "
                                          "internal steps")


Place = tuple[str, int, Any]  # name of a list of rows, number of a row in it, the row


def row_error(model: ModuleType, place: Place, sentence: str) -> ModelError:
    """The mistake of a row, with its line."""
    return ModelError(model, sentence, row_place(model, *place))


def check_row(model: ModuleType, place: Place, causalities: tuple[str, ...], found: set[str]) -> None:
    """Raises ModelError for a row that cannot become a record; its name joins `found`, the names before."""
    table, i, row = place

    def mistake(sentence: str) -> ModelError:
        return row_error(model, place, sentence)

    if not isinstance(row, (tuple, list)) or len(row) != len(COLUMNS):
        length = f" has {len(row)} entries" if isinstance(row, (tuple, list)) else " is not a tuple"
        raise mistake(f"row {i + 1} of {table}, {row!r},{length}; a row is ({', '.join(COLUMNS)})")
    name, causality, unit, *_, description = row
    if not identifier(name):
        raise mistake(f"the variable name {name!r} is not allowed; {NAME_RULE}")
    if name in found:
        raise mistake(f"{name} stands twice in the table; names must differ")
    if causality not in causalities:
        raise mistake(f"{name}: causality {causality!r} is none of {', '.join(causalities)}")
    reason = unit_mistake(unit, getattr(model, "UNITS", {}))
    if reason:
        raise mistake(f"{name}: {reason}")
    if not line_of_text(description):
        raise mistake(f"{name}: the description must be one line of text, without control characters")
    found.add(name)


def check_values(model: ModuleType, place: Place, v: Variable) -> None:
    """Raises ModelError for a limit, a nominal or a start value that `v` cannot have."""
    reason = range_mistake(v) or start_mistake(v)
    if reason:
        raise row_error(model, place, f"{v.name}: {reason}")


def check_states(model: ModuleType) -> None:
    """Raises ModelError for STATES that do not go with the table or with the functions."""
    entries = getattr(model, "STATES", None)
    if not hasattr(model, "derivative"):
        if entries is not None:
            raise ModelError(model, "there are STATES, but no function derivative; STATES name its rates",
                             file_place(model))
        return
    table = variables(model.VARIABLES)
    if sample_time(table) is not None:
        raise ModelError(model, "there are sample_time and derivative; a discrete law has advance only",
                         function_place(model.derivative))
    if not isinstance(entries, (list, tuple)):
        raise ModelError(model, "STATES is missing or is not a list; beside derivative it has, for each rate, the name "
                                "of an output or a row with the causality 'local'", file_place(model))
    found = {v.name for v in table}
    shown = [v.name for v in table if v.causality == "output" and v.type == "Real" and not v.discrete]
    for i, entry in enumerate(entries):
        place = ("STATES", i, entry)
        if not isinstance(entry, str):
            check_row(model, place, ("local",), found)
        elif entry not in shown:
            raise row_error(model, place, f"STATES names {entry}, which is no continuous output{nearest(entry, shown)}"
                                          "; a state that is no output is a row with the causality 'local'")
        elif entry in entries[:i]:
            raise row_error(model, place, f"{entry} stands twice in STATES")
    for i, v in enumerate(states(model)):
        check_values(model, ("STATES", i, entries[i]), v)
        if v.type == "Boolean" or v.discrete:
            raise row_error(model, ("STATES", i, entries[i]), f"{v.name}: a continuous state has a unit, and is not "
                                                              "discrete")
    if not hasattr(model, "advance") and "internal_step" not in names(table, "parameter"):
        raise ModelError(model, "there is no parameter internal_step; a model without advance is integrated in steps "
                                "no longer than that", file_place(model))


def check_units(model: ModuleType) -> None:
    """Raises ModelError for UNITS that are not the worth of new names in units that there are."""
    own = getattr(model, "UNITS", {})
    if not isinstance(own, dict):
        raise ModelError(model, "UNITS is not a dict of names and their worth, such as {'furlong': (220, 'yd')}",
                         file_place(model))
    for name, worth in own.items():
        place = key_place(model, name)
        if not (isinstance(name, str) and re.fullmatch("[A-Za-z]+", name)) or name in {*WORTH, *BASE_UNITS}:
            raise ModelError(model, f"UNITS names {name!r}; a new unit's name has ASCII letters only and is not in use",
                             place)
        if not (isinstance(worth, tuple) and len(worth) == 2 and finite_number(worth[0]) and worth[0] > 0):
            raise ModelError(model, f"UNITS gives {worth!r} for {name}; a unit's worth is how many of which unit, such "
                                    "as (220, 'yd')", place)
        reason = unit_mistake(worth[1] or None, {})
        if reason:
            raise ModelError(model, f"UNITS: {name}: {reason}", place)


def unit_mistake(text: object, own: dict[str, Worth]) -> str | None:
    """Why `text` cannot be the unit in a row, or None; `own` are the model's UNITS."""
    if not isinstance(text, str):
        return f"the unit {text!r} is not text, such as 'ft/s'; '' makes a Boolean"
    unit, _, kind = text.partition(" ")
    try:
        if unit:
            si_base(unit, own)
    except ValueError as error:
        return f"in the unit {text!r}, {error}; '' makes a Boolean"
    if kind.startswith("in "):
        return display_mistake(text, unit, kind.removeprefix("in "))
    return None if kind in KINDS else (f"in the unit {text!r}, only 'frequency' or 'discrete' may follow, or 'in' and "
                                       "the unit to show it in")


def display_mistake(text: str, unit: str, shown: str) -> str | None:
    """Why `unit` cannot be shown in `shown`, or None; `text` is what the row has."""
    try:
        sizes = [si_base(name)[1] for name in (unit, shown)]
    except ValueError as error:
        return f"in the unit {text!r}, {error}; a unit of UNITS is shown as it is"
    return None if sizes[0] == sizes[1] else f"in the unit {text!r}, {shown} is no unit of the same quantity as {unit}"


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


def check_terminals(model: ModuleType) -> None:
    """Raises ModelError for TERMINALS that are not names of inputs and outputs under a name."""
    terminals = getattr(model, "TERMINALS", {})
    if not isinstance(terminals, dict):
        raise ModelError(model, "TERMINALS is not a dict of names and the names of inputs and outputs",
                         file_place(model))
    ports = names(variables(model.VARIABLES), "input", "output")
    for terminal, members in terminals.items():
        place = key_place(model, terminal)
        if not identifier(terminal) or not isinstance(members, (list, tuple)):
            raise ModelError(model, f"the terminal {terminal!r} is not a name with a list of inputs and outputs", place)
        for member in members:
            if member not in ports:
                raise ModelError(model, f"the terminal {terminal} has {member!r}, which is no input or output"
                                        + nearest(member, ports), place)


def check_presets(model: ModuleType) -> None:
    """Raises ModelError for a preset whose name cannot be a file's, or which sets what it cannot."""
    parameters = {v.name: v for v in variables(model.VARIABLES) if v.causality == "parameter"}

    def mistake(key: object, sentence: str) -> ModelError:
        return ModelError(model, sentence, key_place(model, key))

    for preset, values in model.PRESETS.items():
        if not (isinstance(preset, str) and re.fullmatch(r"\w[\w.-]*", preset, re.ASCII)):
            raise mistake(preset, f"the preset name {preset!r} is not allowed; it becomes a file's name, of "
                                  "ASCII letters, digits, '_', '-' and '.' after the first")
        if not isinstance(values, dict):
            raise mistake(preset, f"the preset {preset} is not a dict of parameters and values")
        for name, value in values.items():
            if name not in parameters:
                raise mistake(name, f"the preset {preset} sets {name}, which is no parameter"
                                    + nearest(name, parameters))
            reason = value_mistake(parameters[name], value, "the value")
            if reason:
                raise mistake(name, f"the preset {preset} sets {name}, but {reason}")
