"""modelDescription.xml of a container: the components' variables under the container's names."""
import re
from collections.abc import Mapping
from dataclasses import dataclass
from xml.etree.ElementTree import Element, SubElement

from ..errors import UsageError
from ..master.declared import Variable
from ..master.dependencies import inputs_behind
from ..master.fmu import FmuFile
from ..master.quantities import BASE, DisplayUnit, Unit, conversion
from ..master.system import Value
from .write import TOOL, text, xml

RUNTIME = "container_fmu"  # the name of FMPy's libraries
DECLARED = ("quantity", "unit", "displayUnit", "relativeQuantity", "min", "max", "nominal", "unbounded")
NUMBERS = {"Integer": ("quantity", "min", "max"), "Boolean": (), "String": ()}  # of DECLARED, in other types than Real
SHARED = ("needsExecutionTool", "canBeInstantiatedOnlyOncePerProcess")  # true of the container if true of an FMU in it


@dataclass(frozen=True)
class Port:
    """A variable of the container: its name there, and the component's variable behind it; `value` is what the system
    sets, None where the FMU's own start value holds."""
    name: str
    component: str
    variable: Variable
    value: Value | None = None

    @property
    def full(self) -> str:
        """component.variable."""
        return f"{self.component}.{self.variable.name}"

    def start(self, files: Mapping[str, FmuFile]) -> str | None:
        """The start value as text, of a variable that has one."""
        if self.value is None:
            return self.variable.start
        return text(files[self.component].checked(self.variable.name, self.value, self.component))


def description(name: str, guid: str, files: Mapping[str, FmuFile], ports: list[Port], step: float,
                stop: float | None) -> bytes:
    """modelDescription.xml; value references count `ports` from 1, as the runtime does."""
    root = Element("fmiModelDescription", fmiVersion="2.0", modelName=name, guid=guid, generationTool=TOOL,
                   description=f"{', '.join(files)} in one FMU", variableNamingConvention="flat")
    flags = {flag: "true" for flag in SHARED if any(f.description.claims(flag) for f in files.values())}
    SubElement(root, "CoSimulation", modelIdentifier=RUNTIME, canNotUseMemoryManagementFunctions="true", attrib=flags)
    units: dict[str, Unit] = {}
    variables = Element("ModelVariables")
    for reference, port in enumerate(ports, 1):
        add_variable(variables, port, reference, files, units)
    if units:
        add_units(root, units)
    end = {} if stop is None else {"stopTime": repr(float(stop))}
    SubElement(root, "DefaultExperiment", startTime="0.0", attrib=end, stepSize=repr(float(step)))
    root.append(variables)
    add_structure(root, files, ports)
    return xml(root)


def add_variable(parent: Element, port: Port, reference: int, files: Mapping[str, FmuFile],
                 units: dict[str, Unit]) -> None:
    """One <ScalarVariable>; its unit is added to `units`, which has one unit of each name."""
    v = port.variable
    element = SubElement(parent, "ScalarVariable", name=port.name, valueReference=str(reference))
    if v.description:
        element.set("description", v.description)
    element.set("causality", v.causality)
    continuous = v.variability == "continuous"
    element.set("variability", "discrete" if continuous and v.type != "Real" else v.variability)  # as some leave it out
    if v.initial:
        element.set("initial", v.initial)
    kind = v.base
    typed = SubElement(element, kind)
    unit = files[port.component].description.unit_of(v)
    same = unit is not None and conversion(unit, units.setdefault(unit.name, unit)) == (1.0, 0.0)
    for attribute in NUMBERS.get(kind, DECLARED):
        value = v.resolved(attribute)
        if value is not None and (same or attribute not in ("unit", "displayUnit")):
            typed.set(attribute, value)
    start = port.start(files)
    if start is not None and re.search("[\x00-\x08\x0b\x0c\x0e-\x1f\ufffe\uffff]", start):
        raise UsageError(f"{port.full} = {start!r} is not allowed: XML has no such characters.")
    if start is not None and (v.causality == "input" or v.initial in ("exact", "approx")):
        typed.set("start", start)


def add_units(root: Element, units: Mapping[str, Unit]) -> None:
    """<UnitDefinitions>."""
    parent = SubElement(root, "UnitDefinitions")
    for name in sorted(units):
        unit = units[name]
        element = SubElement(parent, "Unit", name=name)
        if unit.exponents is not None:
            base = {part: str(n) for part, n in zip(BASE, unit.exponents) if n}
            SubElement(element, "BaseUnit", base | scaled(unit))
        for shown in unit.displays:
            SubElement(element, "DisplayUnit", name=shown.name, attrib=scaled(shown))


def scaled(unit: Unit | DisplayUnit) -> dict[str, str]:
    """factor and offset as attributes, where they are not the defaults."""
    return {key: repr(value) for key, value, default in (("factor", unit.factor, 1.0), ("offset", unit.offset, 0.0))
            if value != default}


def add_structure(root: Element, files: Mapping[str, FmuFile], ports: list[Port]) -> None:
    """<ModelStructure>: after a step an output depends on inputs of its own component alone, at the start on all."""
    index = {port.full: str(i) for i, port in enumerate(ports, 1)}
    structure = SubElement(root, "ModelStructure")
    outputs, initial = Element("Outputs"), Element("InitialUnknowns")
    for port in ports:
        if port.variable.causality == "output":
            behind = inputs_behind(files[port.component])[port.variable.name]
            known = [index[full] for full in index if full in {f"{port.component}.{name}" for name in behind}]
            SubElement(outputs, "Unknown", index=index[port.full], dependencies=" ".join(known))
        if port.variable.causality in ("output", "calculatedParameter") and port.variable.initial != "exact":
            SubElement(initial, "Unknown", index=index[port.full])
    structure.extend(part for part in (outputs, initial) if len(part))
