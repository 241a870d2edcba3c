"""Writes modelDescription.xml of FMI 2.0 and the presets' parameter sets (SSV) from a model's table."""
from dataclasses import dataclass, field
from types import ModuleType
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from .dependencies import Dependencies, dependencies
from .interface import Variable, computed, names, variables
from .trace import Trace
from .units import DEGREES, si_base

AUTHOR = "the AHV FMU authors"
COPYRIGHT = f"Copyright 2026 {AUTHOR}"
LICENSE = "BSD-2-Clause"
LOG_CATEGORIES = {
    "logStatusWarning": "warnings",
    "logStatusDiscard": "steps and values refused, each with its reason",
    "logStatusError": "wrong use of the FMU",
    "logStatusFatal": "failures after which the FMU is of no use",
    "logAll": "everything",
}
EXPERIMENT = {"startTime": "0", "stopTime": "100", "stepSize": "0.01"}
SSV = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"


@dataclass(frozen=True)
class Flavour:
    """What one kind of FMU binary can do, as attributes of FMI 2.0's <CoSimulation>; its C sources if it has any, and
    the FMI versions that it serves."""
    capabilities: dict[str, str]
    sources: list[str] = field(default_factory=list)
    versions: tuple[str, ...] = ("2",)


def number(value: float) -> str:
    """A number as XML that gives the very same double."""
    return repr(float(value))


def boolean(value: object) -> str:
    """A truth value as XML."""
    return "true" if value else "false"


def head(model: ModuleType, version: str, tool: str, fmi: str, **token: str) -> Element:
    """<fmiModelDescription> of FMI `fmi`, without content; `token` is the attribute that identifies the build."""
    return Element("fmiModelDescription", token, fmiVersion=fmi, modelName=model.NAME,
                   description=model.DESCRIPTION, version=version, author=AUTHOR, copyright=COPYRIGHT,
                   license=LICENSE, generationTool=tool, variableNamingConvention="flat")


def add_units(root: Element, table: list[Variable]) -> None:
    """<UnitDefinitions>: the units of the table in SI base units, and what they are shown in."""
    definitions = SubElement(root, "UnitDefinitions")
    for unit in sorted({v.unit for v in table} - {""}):
        element = SubElement(definitions, "Unit", name=unit)
        factor, exponents = si_base(unit)
        base = {name: str(exponent) for name, exponent in exponents.items()}
        if factor != 1.0:
            base["factor"] = number(factor)
        SubElement(element, "BaseUnit", base)
        for shown in sorted({v.display_unit for v in table if v.unit == unit and v.display_unit}):
            SubElement(element, "DisplayUnit", name=shown, factor=number(DEGREES))


def variable_attributes(v: Variable) -> dict[str, str]:
    """What both versions say of a variable: name, reference, description, causality, variability and initial."""
    set_once = v.causality in ("parameter", "calculatedParameter")
    variability = "fixed" if set_once else "discrete" if v.discrete else "continuous"
    attributes = {"name": v.name, "valueReference": str(v.value_reference), "description": v.description,
                  "causality": v.causality, "variability": variability}
    initial = {"input": None, "independent": None, "parameter": "exact"}.get(v.causality, "calculated")
    return {**attributes, "initial": initial} if initial else attributes


def value_attributes(v: Variable) -> dict[str, str]:
    """What both versions say of a variable's values: units, limits, nominal, start."""
    if v.type == "Boolean":
        return {} if v.start is None else {"start": boolean(v.start)}
    real = {"unit": v.unit, "displayUnit": v.display_unit, "min": v.minimum, "max": v.maximum,
            "nominal": v.nominal, "start": v.start}
    return {k: x if isinstance(x, str) else number(x) for k, x in real.items() if x is not None}


def add_variable(parent: Element, v: Variable) -> None:
    """One <ScalarVariable>."""
    SubElement(SubElement(parent, "ScalarVariable", variable_attributes(v)), v.type, value_attributes(v))


def add_log_categories(root: Element) -> None:
    """<LogCategories>."""
    categories = SubElement(root, "LogCategories")
    for name, text in LOG_CATEGORIES.items():
        SubElement(categories, "Category", name=name, description=text)


def add_structure(root: Element, table: list[Variable], known: Dependencies) -> None:
    """<ModelStructure>, with the dependencies of what is computed."""
    position = {v.name: i + 1 for i, v in enumerate(table)}
    structure = SubElement(root, "ModelStructure")

    def add(parent: Element, name: str, needs: list[str]) -> None:
        indices = sorted(position[n] for n in needs if n in position)  # FMI 2.0 has no need of a variable for the time
        SubElement(parent, "Unknown", index=str(position[name]), dependencies=" ".join(map(str, indices)))

    outputs = SubElement(structure, "Outputs")
    for name in names(table, "output"):
        add(outputs, name, known.after_step[name])
    initial = SubElement(structure, "InitialUnknowns")
    for name in computed(table):
        add(initial, name, known.at_start[name])


def model_description(model: ModuleType, trace: Trace, flavour: Flavour, guid: str, version: str,
                      tool: str) -> bytes:
    """modelDescription.xml of `model` (FMI 2.0 section 2.2), the same bytes for the same arguments.

    `tool` names what made the FMU, with versions.
    """
    table = variables(model.VARIABLES)
    root = head(model, version, tool, "2.0", guid=guid)
    interface = SubElement(root, "CoSimulation", modelIdentifier=model.NAME,
                           canHandleVariableCommunicationStepSize="true", attrib=flavour.capabilities)
    if flavour.sources:
        files = SubElement(interface, "SourceFiles")
        for source in flavour.sources:
            SubElement(files, "File", name=source)
    add_units(root, table)
    add_log_categories(root)
    SubElement(root, "DefaultExperiment", EXPERIMENT)
    parent = SubElement(root, "ModelVariables")
    for v in table:
        add_variable(parent, v)
    add_structure(root, table, dependencies(model, trace))
    return xml_bytes(root)


def parameter_set(name: str, values: dict[str, float | bool]) -> bytes:
    """One preset as an SSP 1.0 parameter set (SSV)."""
    root = Element("ssv:ParameterSet", {"xmlns:ssv": SSV, "version": "1.0", "name": name})
    parent = SubElement(root, "ssv:Parameters")
    for key, value in values.items():
        parameter = SubElement(parent, "ssv:Parameter", name=key)
        if isinstance(value, bool):
            SubElement(parameter, "ssv:Boolean", value=boolean(value))
        else:
            SubElement(parameter, "ssv:Real", value=number(value))
    return xml_bytes(root)


def xml_bytes(root: Element) -> bytes:
    """The document `root`, indented; `root` is changed by that."""
    indent(root)
    return b'<?xml version="1.0" encoding="UTF-8"?>\n' + tostring(root) + b"\n"
