"""SystemStructure.ssd as plain data: elements by path, connections between their connectors, experiment."""
from dataclasses import dataclass, field

from ..errors import UsageError, did_you_mean
from ..master.parameter_set import units
from ..master.quantities import Unit
from ..master.xml_file import OSP, SSC, SSD, Node, short

ElementPath = tuple[str, ...]         # names from the outermost system, which is (), inwards
Point = tuple[ElementPath, str]       # a connector of an element, or a variable of an FMU

FMU_TYPE = "application/x-fmu-sharedlibrary"
TYPES = ("Real", "Integer", "Boolean", "String", "Enumeration", "Binary")


@dataclass(frozen=True)
class Connector:
    """A connector: `kind` is input, output, ..., `type` is one of TYPES where it is given."""
    kind: str
    type: str | None
    unit: Unit | None


@dataclass(frozen=True)
class Element:
    """A component (with the source of its FMU) or a system (without)."""
    path: ElementPath
    source: str | None
    connectors: dict[str, Connector]
    bindings: list[Node]


@dataclass(frozen=True)
class Link:
    """A connection: end = factor * start + offset, after conversion of units unless that is suppressed."""
    start: Point
    end: Point
    factor: float
    offset: float
    converts: bool


@dataclass
class Structure:
    """What a SystemStructure.ssd says; times in s, None where it says nothing."""
    name: str
    start: float | None
    stop: float | None
    step: float | None          # SSP has none; annotations of libcosim and OMSimulator give one
    units: dict[str, Unit]
    elements: dict[ElementPath, Element] = field(default_factory=dict)
    links: list[Link] = field(default_factory=list)

    def components(self) -> list[Element]:
        """The elements that are FMUs."""
        return [e for e in self.elements.values() if e.source is not None]


def shown(path: ElementPath) -> str:
    """An element as messages call it."""
    return ".".join(path) or "the system"


def called(point: Point) -> str:
    """A connector or variable as messages call it."""
    return ".".join((*point[0], point[1]))


def number(node: Node | None, attribute: str) -> float | None:
    """An attribute as a number; None where the element or the attribute is missing."""
    text = None if node is None else node.get(attribute)
    return None if text is None else float(text)


def linear(node: Node, what: str) -> tuple[float, float]:
    """(factor, offset) of the transformation in `node`. Raises UsageError, naming `what`, for another kind."""
    other = next((short(part.tag) for part in node if part.tag.endswith("MappingTransformation")), None)
    if other:
        raise UsageError(f"{what} has a {other}, which is not supported.")
    found = node.find(f"{SSC}LinearTransformation")
    return (1.0, 0.0) if found is None else (float(found.get("factor", 1.0)), float(found.get("offset", 0.0)))


def converts(node: Node) -> bool:
    """Whether a connection or mapping converts units."""
    return node.get("suppressUnitConversion", "false") not in ("true", "1")


def read(root: Node) -> Structure:
    """The structure that a valid SystemStructureDescription describes.

    Raises UsageError for what is not supported, by name.
    """
    experiment = root.find(f"{SSD}DefaultExperiment")
    step = (number(root.find(f".//{OSP}FixedStepAlgorithm"), "baseStepSize")
            or number(root.find(".//{*}FixedStepMaster"), "stepSize"))
    structure = Structure(root.get("name"), number(experiment, "startTime"), number(experiment, "stopTime"), step,
                          units(root, SSD))
    read_system(root.find(f"{SSD}System"), (), structure)
    return structure


def read_system(node: Node, path: ElementPath, structure: Structure) -> None:
    """Add a system, with all that is in it, to `structure`. Raises UsageError for what is not supported."""
    add_element(node, path, None, structure)
    for child in node.iterfind(f"{SSD}Elements/*"):
        inner = (*path, child.get("name"))
        if inner in structure.elements:
            raise UsageError(f"There are two elements called {shown(inner)}.")
        if child.tag == f"{SSD}System":
            read_system(child, inner, structure)
        elif child.tag == f"{SSD}Component":
            add_element(child, inner, fmu_source(child, inner), structure)
        else:
            raise UsageError(f"{shown(inner)} is a {short(child.tag)}, which is not supported.")
    for connection in node.iterfind(f"{SSD}Connections/{SSD}Connection"):
        structure.links.append(read_link(connection, path, structure))


def fmu_source(node: Node, path: ElementPath) -> str:
    """Where a component's FMU is. Raises UsageError unless it is an FMU for co-simulation."""
    if node.get("type", FMU_TYPE) != FMU_TYPE:
        raise UsageError(f"{shown(path)} is of type {node.get('type')}, which is not supported; FMUs ({FMU_TYPE}) are.")
    if node.get("implementation") == "ModelExchange":
        raise UsageError(f"{shown(path)} wants its FMU as ModelExchange, which is not supported; CoSimulation is.")
    return str(node.get("source"))


def add_element(node: Node, path: ElementPath, source: str | None, structure: Structure) -> None:
    """Add a component, or a system (whose `source` is None), to `structure`."""
    connectors = {}
    for connector in node.iterfind(f"{SSD}Connectors/{SSD}Connector"):
        name = connector.get("name")
        kind = next((part for part in TYPES if connector.find(f"{SSC}{part}") is not None), None)
        if kind == "Binary":
            raise UsageError(f"{shown(path)} has the Binary connector {name}, which is not supported.")
        unit_name = connector.find(f"{SSC}Real").get("unit") if kind == "Real" else None
        known = structure.units.get(unit_name, Unit(unit_name)) if unit_name else None
        connectors[name] = Connector(connector.get("kind"), kind, known)
    bindings = node.findall(f"{SSD}ParameterBindings/{SSD}ParameterBinding")
    structure.elements[path] = Element(path, source, connectors, bindings)


def read_link(node: Node, path: ElementPath, structure: Structure) -> Link:
    """A connection of the system at `path`; without an element, an end is a connector of the system itself."""
    start, end = (point_of(node, side, path, structure) for side in ("start", "end"))
    factor, offset = linear(node, f"The connection from {called(start)} to {called(end)}")
    return Link(start, end, factor, offset, converts(node))


def point_of(node: Node, side: str, path: ElementPath, structure: Structure) -> Point:
    """One end of a connection. Raises UsageError if nothing may start, or end, there."""
    name, connector = node.get(f"{side}Element"), node.get(f"{side}Connector")
    inner = (*path, name) if name else path
    if inner not in structure.elements:
        raise UsageError(f"A connection of {shown(path)} {side}s at {name}, which is no element of it"
                         f"{did_you_mean(name, [p[-1] for p in structure.elements if p[:-1] == path and p])}")
    known = structure.elements[inner].connectors
    if connector not in known:
        raise UsageError(f"A connection {side}s at the connector {connector}, which {shown(inner)} does not have"
                         f"{did_you_mean(connector, known)}")
    kind = known[connector].kind
    # A system's own input is a source inside it; an element's input is a target.
    wanted = "input" if (side == "end") == bool(name) else "output"
    if kind in ("input", "output") and kind != wanted:
        raise UsageError(f"A connection {side}s at {called((inner, connector))}, which is an {kind}.")
    return inner, connector
