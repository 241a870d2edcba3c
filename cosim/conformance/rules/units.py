"""Units and types (FMI 2.0: sections 2.2.2 and 2.2.3, 3.0: 2.4.3 and 2.4.4)."""
from collections.abc import Iterator

from lxml import etree

from ...master.declared import FAMILIES, SimpleType, Variable, integer, is_true, number
from ..repeats import repeated
from ..rule import static
from ..subject import Fault, Fmu

EXPONENTS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")

# Names with one meaning only: name -> exponents of (kg, m, s, A, K, mol, cd, rad) and the factor.
WELL_KNOWN: dict[str, tuple[tuple[int, ...], float]] = {
    "kg": ((1, 0, 0, 0, 0, 0, 0, 0), 1.0),
    "m": ((0, 1, 0, 0, 0, 0, 0, 0), 1.0),
    "s": ((0, 0, 1, 0, 0, 0, 0, 0), 1.0),
    "A": ((0, 0, 0, 1, 0, 0, 0, 0), 1.0),
    "K": ((0, 0, 0, 0, 1, 0, 0, 0), 1.0),
    "mol": ((0, 0, 0, 0, 0, 1, 0, 0), 1.0),
    "cd": ((0, 0, 0, 0, 0, 0, 1, 0), 1.0),
    "rad": ((0, 0, 0, 0, 0, 0, 0, 1), 1.0),
    "N": ((1, 1, -2, 0, 0, 0, 0, 0), 1.0),
    "Pa": ((1, -1, -2, 0, 0, 0, 0, 0), 1.0),
    "J": ((1, 2, -2, 0, 0, 0, 0, 0), 1.0),
    "W": ((1, 2, -3, 0, 0, 0, 0, 0), 1.0),
    "V": ((1, 2, -3, -1, 0, 0, 0, 0), 1.0),
    "km": ((0, 1, 0, 0, 0, 0, 0, 0), 1000.0),
    "bar": ((1, -1, -2, 0, 0, 0, 0, 0), 1e5),
    "deg": ((0, 0, 0, 0, 0, 0, 0, 1), 0.017453292519943295),
    "m/s": ((0, 1, -1, 0, 0, 0, 0, 0), 1.0),
    "rad/s": ((0, 0, -1, 0, 0, 0, 0, 1), 1.0),
    "ft": ((0, 1, 0, 0, 0, 0, 0, 0), 0.3048),
    "lbf": ((1, 1, -2, 0, 0, 0, 0, 0), 4.4482216152605),
}


def unit_elements(fmu: Fmu) -> list[etree._Element]:
    """The Unit elements."""
    return fmu.description.root.findall("UnitDefinitions/Unit")


def unit_names(fmu: Fmu) -> set[str]:
    """The names of the units that are defined."""
    return {unit.get("name", "") for unit in unit_elements(fmu)}


def unit_carriers(fmu: Fmu) -> Iterator[tuple[str, str | None, str | None]]:
    """(name, unit, display unit) of Real types, and of Real variables that have a unit or display unit of their own."""
    for declared in fmu.description.types:
        if FAMILIES.get(declared.type) == "Real":
            yield f"type {declared.name}", declared.attributes.get("unit"), declared.attributes.get("displayUnit")
    for v in [*fmu.description.variables, *fmu.description.aliases]:
        if v.family == "Real" and ("unit" in v.own or "displayUnit" in v.own):  # inherited faults are the type's
            yield v.name, v.resolved("unit"), v.resolved("displayUnit")


@static("unit.unique")
def unit_unique(fmu: Fmu) -> Iterator[Fault]:
    for name, count in repeated(unit.get("name", "") for unit in unit_elements(fmu)):
        yield Fault(name, f"{count} units of this name", "one")


@static("unit.display-unique")
def display_unique(fmu: Fmu) -> Iterator[Fault]:
    for unit in unit_elements(fmu):
        for name, count in repeated(display.get("name", "") for display in unit.findall("DisplayUnit")):
            yield Fault(f"{unit.get('name')}: {name}", f"{count} display units of this name", "one")


@static("unit.base-factor")
def base_factor(fmu: Fmu) -> Iterator[Fault]:
    for unit in unit_elements(fmu):
        for base in unit.findall("BaseUnit"):
            if number(base.get("factor", "1")) == 0:
                yield Fault(unit.get("name", ""), "BaseUnit factor 0", "a factor that can be inverted")


@static("unit.display-factor")
def display_factor(fmu: Fmu) -> Iterator[Fault]:
    for unit in unit_elements(fmu):
        for display in unit.findall("DisplayUnit"):
            if number(display.get("factor", "1")) == 0:
                yield Fault(f"{unit.get('name')}: {display.get('name')}", "factor 0", "a factor that can be inverted")


@static("unit.display-is-unit")
def display_is_unit(fmu: Fmu) -> Iterator[Fault]:
    for unit in unit_elements(fmu):
        for display in unit.findall("DisplayUnit"):
            factor, offset = number(display.get("factor", "1")), number(display.get("offset", "0"))
            if display.get("name") == unit.get("name") and factor != 0 and (factor, offset) != (1, 0):
                yield Fault(unit.get("name", ""), f"factor {factor:g}, offset {offset:g}", "factor 1, offset 0")


@static("unit.inverse")
def inverse(fmu: Fmu) -> Iterator[Fault]:
    for unit in unit_elements(fmu):
        for display in unit.findall("DisplayUnit"):
            if is_true(display.get("inverse")) and number(display.get("offset", "0")) != 0:
                yield Fault(f"{unit.get('name')}: {display.get('name')}", f"inverse, offset {display.get('offset')}",
                            "no offset")


@static("unit.known-name")
def known_name(fmu: Fmu) -> Iterator[Fault]:
    for unit in unit_elements(fmu):
        base, known = unit.find("BaseUnit"), WELL_KNOWN.get(unit.get("name", ""))
        factor = number(base.get("factor", "1")) if base is not None else None
        if base is None or known is None or not factor:
            continue
        exponents = tuple(integer(base.get(name, "0")) for name in EXPONENTS)
        without_rad = exponents[:-1], known[0][:-1]  # many tools take the radian as the number 1, which converts alike
        if without_rad[0] != without_rad[1] or abs(factor - known[1]) > 1e-4 * known[1]:
            yield Fault(unit.get("name", ""), spelled(exponents, factor), spelled(known[0], known[1]))


def spelled(exponents: tuple[int | None, ...], factor: float) -> str:
    """A base unit as text, such as 0.3048 m1."""
    parts = [f"{name}{power}" for name, power in zip(EXPONENTS, exponents, strict=True) if power]
    return f"{factor:g} " + (" ".join(parts) or "1")


@static("unit.defined")
def unit_defined(fmu: Fmu) -> Iterator[Fault]:
    for name, unit, _ in unit_carriers(fmu):
        if unit is not None and unit not in unit_names(fmu):
            yield Fault(name, f"unit '{unit}' is not defined", "a Unit of this name in UnitDefinitions")


@static("unit.display-needs-unit")
def display_needs_unit(fmu: Fmu) -> Iterator[Fault]:
    for name, unit, display in unit_carriers(fmu):
        if display is not None and unit is None:
            yield Fault(name, f"displayUnit '{display}' without unit", "a unit, or no displayUnit")


@static("unit.display-defined")
def display_defined(fmu: Fmu) -> Iterator[Fault]:
    known = {u.get("name", ""): {d.get("name") for d in u.findall("DisplayUnit")} for u in unit_elements(fmu)}
    for name, unit, display in unit_carriers(fmu):
        if display is not None and unit in known and display not in known[unit] | {unit}:
            yield Fault(name, f"displayUnit '{display}' is not defined for '{unit}'", "a DisplayUnit of this name")


@static("unit.unused")
def unit_unused(fmu: Fmu) -> Iterator[Fault]:
    used = {v.resolved("unit") for v in fmu.description.variables}
    used |= {declared.attributes.get("unit") for declared in fmu.description.types}
    for name in sorted(unit_names(fmu) - {unit for unit in used if unit is not None}):
        yield Fault(name, "used by no type and no variable", "a use, or no definition")


@static("unit.derivative")
def derivative_unit(fmu: Fmu) -> Iterator[Fault]:
    bases = {unit.get("name", ""): unit.find("BaseUnit") for unit in unit_elements(fmu)}
    for rate in fmu.description.variables:
        of = fmu.description.variable(rate.derivative)
        units = [bases.get(v.resolved("unit") or "") for v in (rate, of) if v is not None]
        if of is None or any(base is None for base in units):
            continue
        of_rate, of_value = (si_exponents(base) for base in units if base is not None)
        of_value[EXPONENTS.index("s")] -= 1
        if of_rate != of_value:
            yield Fault(rate.name, f"unit '{rate.resolved('unit')}'", f"that of '{of.name}' per second")


def si_exponents(base: etree._Element) -> list[int]:
    """The exponents of a BaseUnit without rad, by which a derivative may differ."""
    return [integer(base.get(name, "0")) or 0 for name in EXPONENTS[:7]]


@static("type.unique")
def type_unique(fmu: Fmu) -> Iterator[Fault]:
    for name, count in repeated(declared.name for declared in fmu.description.types):
        yield Fault(name, f"{count} types of this name", "one")


@static("type.no-variable-name")
def type_not_variable(fmu: Fmu) -> Iterator[Fault]:
    variables = {v.name for v in fmu.description.variables}
    for declared in fmu.description.types:
        if declared.name in variables:
            yield Fault(declared.name, "the name of a type and of a variable", "different names")


@static("type.item-values")
def item_values(fmu: Fmu) -> Iterator[Fault]:
    for declared in fmu.description.types:
        for value, count in repeated(item.get("value", "") for item in declared.items):
            yield Fault(declared.name, f"{count} items of value {value}", "one")


@static("type.item-names")
def item_names(fmu: Fmu) -> Iterator[Fault]:
    for declared in fmu.description.types:
        for name, count in repeated(item.get("name", "") for item in declared.items):
            yield Fault(declared.name, f"{count} items named '{name}'", "one")


@static("type.declared")
def type_declared(fmu: Fmu) -> Iterator[Fault]:
    for v in fmu.description.variables:
        if "declaredType" in v.own and v.declared is None:
            yield Fault(v.name, f"declaredType '{v.own['declaredType']}' is not defined", "a SimpleType of this name")


@static("type.kind")
def type_kind(fmu: Fmu) -> Iterator[Fault]:
    for v in fmu.description.variables:
        if v.declared is not None and v.declared.type != v.type:
            yield Fault(v.name, f"{v.type} with declaredType '{v.declared.name}'", f"a type of kind {v.type}")


@static("type.unused")
def type_unused(fmu: Fmu) -> Iterator[Fault]:
    used = {v.own.get("declaredType") for v in fmu.description.variables}
    for declared in fmu.description.types:
        if declared.name not in used:
            yield Fault(declared.name, "used by no variable", "a use, or no definition")


def ranged(fmu: Fmu) -> Iterator[tuple[str, Variable | SimpleType]]:
    """Types and variables with their names in messages."""
    yield from ((f"type {declared.name}", declared) for declared in fmu.description.types)
    yield from ((v.name, v) for v in fmu.description.variables)


@static("range.min-max")
def min_max(fmu: Fmu) -> Iterator[Fault]:
    for name, item in ranged(fmu):
        if isinstance(item, Variable) and not {"min", "max"} & item.own.keys():
            continue  # what is inherited is the type's fault
        get = item.resolved if isinstance(item, Variable) else item.attributes.get
        low, high = number(get("min")), number(get("max"))
        if low is not None and high is not None and low > high:
            yield Fault(name, f"min {low:g} above max {high:g}", "min <= max")


@static("range.within-type")
def within_type(fmu: Fmu) -> Iterator[Fault]:
    for v in fmu.description.variables:
        if v.declared is None:
            continue
        low, high = number(v.declared.attributes.get("min")), number(v.declared.attributes.get("max"))
        wider = (low is not None and (v.min or low) < low) or (high is not None and (v.max or high) > high)
        if wider and {"min", "max"} & v.own.keys():
            yield Fault(v.name, f"{v.resolved('min')} to {v.resolved('max')}, wider than type '{v.declared.name}'",
                        "a range within the type's")


@static("range.nominal")
def nominal(fmu: Fmu) -> Iterator[Fault]:
    for name, item in ranged(fmu):
        attributes = item.own if isinstance(item, Variable) else item.attributes
        value = number(attributes.get("nominal"))
        if value is not None and value <= 0:
            yield Fault(name, f"nominal {value:g}", "a value above 0")
