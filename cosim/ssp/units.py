"""Units of FMUs (FMI 2.0 section 2.2.2) and of SSP, and conversion between them."""
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from fmpy.model_description import ModelDescription, ScalarVariable

BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")


@dataclass(frozen=True)
class Unit:
    """value in SI base units = factor * value + offset; `exponents` of BASE are None where they are not known."""
    name: str
    factor: float = 1.0
    offset: float = 0.0
    exponents: tuple[int, ...] | None = None


def unit(name: str, base: Mapping[str, Any] | None) -> Unit:
    """From the attributes of a BaseUnit element: FMI and SSP give it the same ones."""
    if base is None:
        return Unit(name)
    return Unit(name, float(base.get("factor", 1.0)), float(base.get("offset", 0.0)),
                tuple(int(base.get(part, 0)) for part in BASE))


def unit_of_variable(description: ModelDescription, variable: ScalarVariable) -> Unit | None:
    """The unit of an FMU's variable, its own or its type's; None without one."""
    name = variable.unit or getattr(variable.declaredType, "unit", None)
    if not name:
        return None
    base = next((u.baseUnit for u in description.unitDefinitions if u.name == name), None)
    return unit(name, None if base is None else {key: getattr(base, key) for key in (*BASE, "factor", "offset")})


def conversion(source: Unit, target: Unit) -> tuple[float, float] | None:
    """(factor, offset) from values in `source` to values in `target`; None if there is none."""
    if source.name == target.name:
        return 1.0, 0.0
    if source.exponents is None or source.exponents != target.exponents or target.factor == 0:
        return None
    if (source.factor, source.offset) == (target.factor, target.offset):
        return 1.0, 0.0
    return source.factor / target.factor, (source.offset - target.offset) / target.factor
