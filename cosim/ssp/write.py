"""Writes a system as SSP 1.0: SystemStructure.ssd, the FMUs, and one parameter set (SSV) for each component.

Beside the standard, so that more tools read it: the prefixes ssd, ssc and ssv, which libcosim and ecos look for
by those letters; the annotations from which libcosim and OMSimulator take the step and a fixed-step master; one name
for all parameter sets, by which ecos applies them; a name that is an identifier, as OMSimulator wants it.
"""
import re
from collections.abc import Iterable
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from fmus import pack

from ..errors import UsageError
from ..master.fmu import FmuFile
from ..master.loaded import open_files
from ..master.quantities import BASE, Unit, conversion
from ..master.system import Component, Connection, System, Value
from ..names import named

PREFIXES = {
    "xmlns:ssd": "http://ssp-standard.org/SSP1/SystemStructureDescription",
    "xmlns:ssc": "http://ssp-standard.org/SSP1/SystemStructureCommon",
    "xmlns:ssv": "http://ssp-standard.org/SSP1/SystemStructureParameterValues",
    "xmlns:osp": "http://opensimulationplatform.com/SSP/OSPAnnotations",
    "xmlns:oms": "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd",
}
TOOL = "ahv"


def write(path: Path, name: str, system: System, step: float, stop: float) -> None:
    """Write `system` to `path`. The same system gives the same bytes.

    Raises UsageError for values or connections that do not fit the FMUs, for a component whose name is none, or if
    `path` cannot be written.
    """
    for component in system.components:  # their parameter sets are files that are called by it
        named("component", component.name)
    with open_files(system) as files:
        places = fmu_places(files)
        contents = {places[c.name]: c.fmu.read_bytes() for c in system.components}
        for component in system.components:
            if component.values:
                contents[parameter_file(component)] = parameter_set(name, component, files[component.name])
        contents["SystemStructure.ssd"] = description(name, system, files, places, step, stop)
    try:
        pack.write(path, contents)
    except OSError as error:
        raise UsageError(f"--out {path} cannot be written: {error.strerror}.") from None


def fmu_places(files: dict[str, FmuFile]) -> dict[str, str]:
    """Component -> its FMU's place in the archive: files that differ have places that differ, whatever their names."""
    places: dict[str, str] = {}
    taken: dict[str, str] = {}  # place -> the file's SHA-256
    for component, file in files.items():
        place, number = f"resources/{file.path.name}", 1
        while taken.setdefault(place, file.sha256) != file.sha256:
            number += 1
            place = f"resources/{file.path.stem}_{number}{file.path.suffix}"
        places[component] = place
    return places


def parameter_file(component: Component) -> str:
    """The parameter set of a component, by its place in the archive."""
    return f"resources/{component.name}.ssv"


def document(tag: str, prefixes: Iterable[str], name: str) -> Element:
    """The root element of a document with the given namespace prefixes."""
    return Element(tag, {**{f"xmlns:{p}": PREFIXES[f"xmlns:{p}"] for p in prefixes},
                         "version": "1.0", "name": name, "generationTool": TOOL})


def description(name: str, system: System, files: dict[str, FmuFile], places: dict[str, str], step: float, stop: float
                ) -> bytes:
    """SystemStructure.ssd of a system whose FMUs are at `places`; `step` and `stop` in s."""
    identifier = re.sub(r"\W", "_", name, flags=re.ASCII)
    root = document("ssd:SystemStructureDescription", ("ssd", "ssc", "ssv", "osp", "oms"), identifier)
    parent = SubElement(root, "ssd:System", name=identifier)
    elements = SubElement(parent, "ssd:Elements")
    units: dict[str, Unit] = {}
    for component in system.components:
        add_component(elements, component, files[component.name], places[component.name], units)
    connections = SubElement(parent, "ssd:Connections") if system.connections else parent  # the list may not be empty
    for link in system.connections:
        start, end = link.source.partition("."), link.target.partition(".")
        connection = SubElement(connections, "ssd:Connection", startElement=start[0], startConnector=start[2],
                                endElement=end[0], endConnector=end[2])
        if converted(link, files):  # the master's connections carry numbers, whatever the units
            connection.set("suppressUnitConversion", "true")
        if (link.factor, link.offset) != (1.0, 0.0):
            SubElement(connection, "ssc:LinearTransformation", factor=repr(link.factor), offset=repr(link.offset))
    add_annotation(parent, "org.openmodelica", "oms:Annotations/oms:SimulationInformation/oms:FixedStepMaster",
                   description="oms-ma", stepSize=repr(float(step)), absoluteTolerance="0.0001",
                   relativeTolerance="0.0001")
    add_units(root, units)
    experiment = SubElement(root, "ssd:DefaultExperiment", startTime=repr(float(system.start)),
                            stopTime=repr(float(stop)))
    add_annotation(experiment, "com.opensimulationplatform", "osp:Algorithm/osp:FixedStepAlgorithm",
                   baseStepSize=repr(float(step)))
    return xml(root)


def add_annotation(parent: Element, owner: str, path: str, **attributes: str) -> None:
    """The element that stands at the end of `path` in an annotation of `owner`'s."""
    element = SubElement(SubElement(parent, "ssd:Annotations"), "ssc:Annotation", type=owner)
    for tag in path.split("/"):
        element = SubElement(element, tag)
    element.attrib.update(attributes)


def converted(link: Connection, files: dict[str, FmuFile]) -> bool:
    """Whether a reader of the SSP would convert units along a connection."""
    source, target = (files[name].description.unit_of(files[name].variable(variable))
                      for name, _, variable in (link.source.partition("."), link.target.partition(".")))
    return source is not None and target is not None and conversion(source, target) != (1.0, 0.0)


def add_component(parent: Element, component: Component, file: FmuFile, place: str, units: dict[str, Unit]) -> None:
    """A component with all inputs and outputs of its FMU, which is at `place`, as connectors; their units are added to
    `units`."""
    element = SubElement(parent, "ssd:Component", name=component.name, type="application/x-fmu-sharedlibrary",
                         source=place, implementation="CoSimulation",
                         description=file.description.attributes.get("description", ""))
    connectors = SubElement(element, "ssd:Connectors")
    for variable in file.description.variables:
        if variable.causality not in ("input", "output"):
            continue
        connector = SubElement(connectors, "ssd:Connector", name=variable.name, kind=variable.causality)
        # SSP 1.0 knows the types of FMI 2.0: a number of any width is Real or Integer.
        kind = SubElement(connector, f"ssc:{variable.family}")
        if variable.type == "Enumeration":
            kind.set("name", variable.own.get("declaredType", ""))
        unit = file.description.unit_of(variable)
        # SSP knows units by their base units only, and one of each name; else the FMU's own unit holds.
        if unit and unit.exponents and conversion(unit, units.setdefault(unit.name, unit)) == (1.0, 0.0):
            kind.set("unit", unit.name)
    if component.values:
        bindings = SubElement(element, "ssd:ParameterBindings")
        SubElement(bindings, "ssd:ParameterBinding", source=parameter_file(component))


def add_units(root: Element, units: dict[str, Unit]) -> None:
    """Add the definitions of `units`."""
    if not units:
        return
    parent = SubElement(root, "ssd:Units")
    for name in sorted(units):
        unit = units[name]
        base = {part: str(n) for part, n in zip(BASE, unit.exponents or ()) if n}
        if unit.factor != 1.0:
            base["factor"] = repr(unit.factor)
        if unit.offset != 0.0:
            base["offset"] = repr(unit.offset)
        SubElement(SubElement(parent, "ssc:Unit", name=name), "ssc:BaseUnit", base)


def parameter_set(name: str, component: Component, file: FmuFile) -> bytes:
    """The values of a component as a parameter set. Raises UsageError for one that does not fit."""
    root = document("ssv:ParameterSet", ("ssv",), name)
    parent = SubElement(root, "ssv:Parameters")
    for key, given in component.values.items():
        value = file.checked(key, given, component.name)
        kind = {"Enumeration": "Integer"}.get(file.variables[key].family, file.variables[key].family)
        SubElement(SubElement(parent, "ssv:Parameter", name=key), f"ssv:{kind}", value=text(value))
    return xml(root)


def text(value: Value) -> str:
    """A value as XML writes it."""
    return str(value).lower() if isinstance(value, bool) else str(value)


def xml(root: Element) -> bytes:
    """A document as bytes."""
    indent(root)
    return b'<?xml version="1.0" encoding="UTF-8"?>\n' + tostring(root, encoding="utf-8") + b"\n"
