"""Parameter sets (SSV of SSP 1.0) as data: those of SSP files, and the presets that FMUs carry."""
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from ..errors import UsageError
from .declared import Variable
from .quantities import Unit, between, conversion, unit
from .system import Value
from .xml_file import SSC, SSV, Node, short

READ: dict[str, Callable[[str], Value]] = {"Real": float, "Integer": int, "Boolean": ("true", "1").__contains__}


@dataclass(frozen=True)
class Given:
    """A value as a parameter set has it. `kind` is Real, Integer, Boolean, String or Enumeration."""
    value: Value
    kind: str
    unit: Unit | None = None
    factor: float = 1.0         # to be applied after the conversion of units
    offset: float = 0.0
    converts: bool = True

    def for_variable(self, variable: Variable | None, target: Unit | None, name: str) -> Value:
        """The value for `variable` (if it is one) in the unit `target`: an Enumeration's item as its number, a number
        converted.

        Raises UsageError, calling it `name`, if there is no such item or no such conversion.
        """
        if self.kind == "Enumeration" and variable is not None:
            if self.value not in variable.items:
                known = ", ".join(variable.items) or "no items"
                raise UsageError(f"{name} = {self.value} is not allowed; there are {known}.")
            return variable.items[str(self.value)]
        if isinstance(self.value, bool | str):
            return self.value
        value = self.value
        if self.converts and self.unit and target:
            change = conversion(self.unit, target, variable is not None and variable.relative)
            if change is None:
                ends = " to ".join(between(self.unit, target))
                raise UsageError(f"The value of {name} cannot be converted from {ends}.")
            value = change[0] * value + change[1]
        return value if (self.factor, self.offset) == (1.0, 0.0) else self.factor * value + self.offset


def units(parent: Node, namespace: str) -> dict[str, Unit]:
    """The units that an element of an SSP's file defines, by name."""
    return {node.get("name"): unit(node.get("name"), node.find(f"{SSC}BaseUnit").attrib)
            for node in parent.iterfind(f"{namespace}Units/{SSC}Unit")}


def parameters(node: Node) -> Iterator[tuple[str, Given]]:
    """Names and values of a valid parameter set."""
    known = units(node, SSV)
    for parameter in node.iterfind(f"{SSV}Parameters/{SSV}Parameter"):
        name, element = parameter.get("name"), parameter[0]
        kind, text = short(element.tag), element.get("value", "")
        if kind == "Binary":
            raise UsageError(f"The parameter {name} is Binary, which is not supported.")
        unit_name = element.get("unit")
        own_unit = known.get(unit_name, Unit(unit_name)) if unit_name else None
        yield name, Given(READ.get(kind, str)(text), kind, own_unit)
