"""Units, conversions between them, and numbers with units as people write them: `2deg`, `7700 ft/s`, `2.3 km/s`.

FMI 2.0 (section 2.2.2) and SSP 1.0 define units alike: by a factor and an offset to SI base units.
"""
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from math import isclose, isfinite
from typing import TYPE_CHECKING, Any

from ..errors import UsageError
from .notes import note

if TYPE_CHECKING:
    from .declared import Variable
    from .description import Description

QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?+)\s*([^\d\s.+-].*?)\s*")
BASE = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
SIGNS = str.maketrans({"²": "2", "³": "3", "⁻": "-", "¹": "1", "µ": "u", "μ": "u", "Ω": "Ohm", "°": "deg"})
ROUNDING = 1e-9  # definitions that differ by less, relatively, are the same unit, written with fewer digits


@dataclass(frozen=True)
class DisplayUnit:
    """display = factor * value + offset."""
    name: str
    factor: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class Unit:
    """value in SI base units = factor * value + offset; `exponents` of BASE are None where they are not known."""
    name: str
    factor: float = 1.0
    offset: float = 0.0
    exponents: tuple[int, ...] | None = None
    displays: tuple[DisplayUnit, ...] = ()

    def __str__(self) -> str:
        """The unit with its definition, for messages about two of one name."""
        if self.exponents is None:
            return f"{self.name} (not defined)"
        powers = " ".join(f"{name}{n}" for name, n in zip(BASE, self.exponents) if n) or "1"
        return f"{self.name} ({self.factor:g} {powers}{f' + {self.offset:g}' if self.offset else ''})"


def unit(name: str, base: Mapping[str, Any] | None, displays: Iterable[Mapping[str, Any]] = ()) -> Unit:
    """From the attributes of a BaseUnit element and of DisplayUnit elements: FMI and SSP give it the same ones.

    A definition with an attribute that is no finite number counts as none; so does a factor of 0.
    """
    shown = tuple(DisplayUnit(d.get("name", ""), *scaled) for d in displays if (scaled := scale(d)))
    scaled = None if base is None else scale(base)
    try:
        exponents = tuple(int((base or {}).get(part, 0)) for part in BASE)
    except ValueError:
        scaled = None
    return Unit(name, *scaled, exponents, shown) if scaled else Unit(name, displays=shown)


def scale(attributes: Mapping[str, Any]) -> tuple[float, float] | None:
    """(factor, offset) as an element has them; None if they cannot be used."""
    try:
        factor, offset = (float(attributes.get(key, default)) for key, default in (("factor", 1.0), ("offset", 0.0)))
    except ValueError:
        return None
    return (factor, offset) if factor and isfinite(factor) and isfinite(offset) else None


def conversion(source: Unit, target: Unit, relative: bool = False) -> tuple[float, float] | None:
    """(factor, offset) from values in `source` to values in `target`; None if there is none.

    Of a difference (`relative`) only the factor changes. A unit that is not defined is known by its name alone, however
    that is spelt; the user is told of two spellings.
    """
    if source.exponents is None or target.exponents is None:
        if spelling(source.name) != spelling(target.name):
            return None
        if source.name != target.name:
            tell_spellings(source.name, target.name)
        return 1.0, 0.0
    if source.exponents != target.exponents:
        return None
    same_size = isclose(source.factor, target.factor, rel_tol=ROUNDING)
    same_origin = relative or isclose(source.offset, target.offset, rel_tol=ROUNDING)
    return (1.0 if same_size else source.factor / target.factor,
            0.0 if same_origin else (source.offset - target.offset) / target.factor)


def spelling(name: str) -> str:
    """A unit's name in one of the ways in which it is written: `m3` for [m3], m^3, m**3 and m³; `kg.m` for kg m, kg*m
    and kg·m."""
    found = name.strip().translate(SIGNS)
    while (found[:1], found[-1:]) in (("[", "]"), ("(", ")")) and not set(found[1:-1]) & set("[]()"):
        found = found[1:-1].strip()
    found = re.sub(r"\s*(/)\s*|\s*[.*·⋅]\s*|\s+", lambda sign: sign[1] or ".", found.replace("**", "").replace("^", ""))
    return "1" if found in ("", "-", "1") else found


@cache
def tell_spellings(one: str, other: str) -> None:
    """Tell the user, once, that two spellings are taken for one unit."""
    note(f"the units {one or 'without a name'} and {other or 'without a name'} are taken for one that is spelt in two "
         f"ways.")


def between(one: Unit, other: Unit) -> tuple[str, str]:
    """Two units as messages call them: with their definitions if they have one name."""
    return (str(one), str(other)) if one.name == other.name else (one.name, other.name)


def in_unit_of(variable: "Variable", description: "Description", text: str, full: str) -> str:
    """The number of `text` in the variable's unit, as text; `text` itself if it is no number with a unit.

    Known are the variable's unit, its display units, and the units of the FMU that measure the same. `full` names the
    variable in messages. Raises UsageError for another unit.
    """
    found = None if is_number(text) or variable.family != "Real" else QUANTITY.fullmatch(text)
    if found is None:
        return text
    number, word = float(found[1]), found[2]
    known = conversions(description, variable)
    if word not in known:
        word = next((name for name in known if spelling(name) == spelling(word)), word)
    if word not in known:
        allowed = f"its unit is one of {', '.join(known)}" if known else "the FMU declares no unit for it"
        raise UsageError(f"{full} = {text} is not allowed: {allowed}.")
    factor, offset = known[word]
    return repr(factor * number + offset)


def is_number(text: str) -> bool:
    """Whether `text` is a number by itself: the e of 1e-4 is no unit."""
    try:
        float(text)
    except ValueError:
        return False
    return True


def conversions(description: "Description", variable: "Variable") -> dict[str, tuple[float, float]]:
    """Unit -> (factor, offset) that lead from it to the variable's unit."""
    own = description.unit_of(variable)
    if own is None:
        return {}
    found: dict[str, tuple[float, float]] = {}
    for other in {own.name: own, **description.units}.values():
        change = (1.0, 0.0) if other.name == own.name else conversion(other, own, variable.relative)
        if change is None:
            continue
        factor, offset = found[other.name] = change
        for display in other.displays:  # of a difference the display unit's offset does not count either
            shift = 0.0 if variable.relative else display.offset
            found[display.name] = factor / display.factor, offset - factor * shift / display.factor
    return found
