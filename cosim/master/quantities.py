"""Numbers with units, as people write them: `2deg`, `7700 ft/s`, `2.3 km/s`."""
import re

from fmpy.model_description import ModelDescription, ScalarVariable

from ..errors import UsageError

QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?+)\s*([^\d\s.+-].*?)\s*")
BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")


def in_unit_of(variable: ScalarVariable, description: ModelDescription, text: str, full: str) -> str:
    """The number of `text` in the variable's unit, as text; `text` itself if it is no number with a unit.

    Known are the variable's unit, its display units, and the units of the FMU that measure the same. `full` names the
    variable in messages. Raises UsageError for another unit.
    """
    found = None if is_number(text) or variable.type != "Real" else QUANTITY.fullmatch(text)
    if found is None:
        return text
    number, unit = float(found[1]), found[2]
    own = variable.unit or getattr(variable.declaredType, "unit", None)
    known = conversions(description, own)
    if unit not in known:
        allowed = f"its unit is one of {', '.join(known)}" if known else "the FMU declares no unit for it"
        raise UsageError(f"{full} = {text} is not allowed: {allowed}.")
    factor, offset = known[unit]
    return repr(factor * number + offset)


def is_number(text: str) -> bool:
    """Whether `text` is a number by itself: the e of 1e-4 is no unit."""
    try:
        float(text)
    except ValueError:
        return False
    return True


def conversions(description: ModelDescription, own: str | None) -> dict[str, tuple[float, float]]:
    """Unit -> (factor, offset) that lead from it to the unit called `own`."""
    definitions = {unit.name: unit for unit in description.unitDefinitions}
    if own not in definitions:
        return {own: (1.0, 0.0)} if own else {}
    target = definitions[own]
    found: dict[str, tuple[float, float]] = {}
    for unit in definitions.values():
        if unit.name == own:
            factor, offset = 1.0, 0.0
        elif unit.baseUnit and target.baseUnit and dimension(unit.baseUnit) == dimension(target.baseUnit):
            factor = unit.baseUnit.factor / target.baseUnit.factor
            offset = (unit.baseUnit.offset - target.baseUnit.offset) / target.baseUnit.factor
        else:
            continue
        found[unit.name] = factor, offset
        for display in unit.displayUnits:  # display = display.factor * value + display.offset
            found[display.name] = factor / display.factor, offset - factor * display.offset / display.factor
    return found


def dimension(base: object) -> tuple[int, ...]:
    """Exponents of the SI base units."""
    return tuple(int(getattr(base, name) or 0) for name in BASE)
