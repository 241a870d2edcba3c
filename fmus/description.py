"""Writes modelDescription.xml of FMI 2.0 and the presets' parameter sets (SSV) from a model's table."""
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import ModuleType
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from .dependencies import Dependencies, dependencies
from .interface import GIVEN, ORIGIN, Variable, names, variables
from .references import all_variables
from .trace import Trace
from .units import Worth, si_base

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
    """What one kind of FMU binary can do, as attributes of FMI 2.0's <CoSimulation>; its C sources if it has any, the
    FMI versions that it serves, and whether it serves model exchange."""
    capabilities: dict[str, str]
    sources: list[str] = field(default_factory=list)
    versions: tuple[str, ...] = ("2",)
    exchanges: bool = False


def number(value: float) -> str:
    """A number as XML that gives the very same double."""
    return repr(float(value))


def boolean(value: object) -> str:
    """A truth value as XML."""
    return "true" if value else "false"


def head(model: ModuleType, version: str, tool: str, fmi: str, **token: str) -> Element:
    """<fmiModelDescription> of FMI `fmi`, without content; `token` is the attribute that identifies the build."""
    return Element("fmiModelDescription", token, fmiVersion=fmi, modelName=model.NAME,
                   description=model.DESCRIPTION, **about(model, version), generationTool=tool,
                   variableNamingConvention="flat")


def about(model: ModuleType, version: str) -> dict[str, str]:
    """What a model says of its origin, as attributes of both versions; of our own the rest is known, with the
    package's `version`."""
    said = {name.lower(): getattr(model, name) for name in ORIGIN if hasattr(model, name)}
    ours = {"version": version, "author": AUTHOR, "copyright": COPYRIGHT, "license": LICENSE}
    return ours | said if said.get("author") == AUTHOR else said


def add_units(root: Element, table: list[Variable], own: Mapping[str, Worth]) -> None:
    """<UnitDefinitions>: the units of the table in SI base units, and what they are shown in; `own` are the model's."""
    definitions = SubElement(root, "UnitDefinitions")
    for unit in sorted({v.unit for v in table} - {""}):
        element = SubElement(definitions, "Unit", name=unit)
        factor, exponents = si_base(unit, own)
        base = {name: str(exponent) for name, exponent in exponents.items()}
        if factor != 1.0:
            base["factor"] = number(factor)
        SubElement(element, "BaseUnit", base)
        for shown, scale in sorted({(v.display_unit, v.factor) for v in table if v.unit == unit and v.display_unit}):
            SubElement(element, "DisplayUnit", name=shown, factor=number(scale))


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


def add_interface(root: Element, kind: str, model: ModuleType, flavour: Flavour, **attributes: str) -> None:
    """<CoSimulation> or <ModelExchange>, with the sources if there are any."""
    interface = SubElement(root, kind, {"modelIdentifier": model.NAME, **attributes, **flavour.capabilities})
    if flavour.sources:
        files = SubElement(interface, "SourceFiles")
        for source in flavour.sources:
            SubElement(files, "File", name=source)


def add_variables(root: Element, table: list[Variable]) -> None:
    """<ModelVariables>."""
    parent, position = SubElement(root, "ModelVariables"), {v.name: str(i + 1) for i, v in enumerate(table)}
    for v in table:
        rate = {"derivative": position[v.derivative_of]} if v.derivative_of else {}
        element = SubElement(parent, "ScalarVariable", variable_attributes(v))
        SubElement(element, v.type, {**value_attributes(v), **rate})


def add_log_categories(root: Element) -> None:
    """<LogCategories>."""
    categories = SubElement(root, "LogCategories")
    for name, text in LOG_CATEGORIES.items():
        SubElement(categories, "Category", name=name, description=text)


def add_structure(root: Element, table: list[Variable], known: Dependencies) -> None:
    """<ModelStructure>, with the dependencies of what is computed on inputs, parameters, and the states whose rates the
    table has."""
    position = {v.name: i + 1 for i, v in enumerate(table)}
    continuous = {v.derivative_of for v in table}
    structure = SubElement(root, "ModelStructure")

    def add(kind: str, listed: list[str], needs: dict[str, list[str]]) -> None:
        parent = SubElement(structure, kind)
        for name in listed:
            # FMI 2.0 has no need of a variable for the time.
            indices = sorted(position[n] for n in needs[name] if n in continuous or
                             (n in position and table[position[n] - 1].causality in GIVEN))
            SubElement(parent, "Unknown", index=str(position[name]), dependencies=" ".join(map(str, indices)))

    add("Outputs", names(table, "output"), known.after_step)
    if continuous - {None}:
        add("Derivatives", [v.name for v in table if v.derivative_of], known.after_step)
    add("InitialUnknowns", [v.name for v in table if v.causality not in GIVEN], known.at_start)


def model_description(model: ModuleType, trace: Trace, flavour: Flavour, guid: str, version: str,
                      tool: str) -> bytes:
    """modelDescription.xml of `model` (FMI 2.0 section 2.2), the same bytes for the same arguments.

    `tool` names what made the FMU, with versions.
    """
    exchange = bool(trace.derivative and flavour.exchanges)
    table = all_variables(model)[:-1] if exchange else variables(model.VARIABLES)
    root = head(model, version, tool, "2.0", guid=guid)
    if exchange:
        add_interface(root, "ModelExchange", model, flavour,
                      completedIntegratorStepNotNeeded=boolean(not any(v.discrete for v in table)))
    add_interface(root, "CoSimulation", model, flavour, canHandleVariableCommunicationStepSize="true")
    add_units(root, table, getattr(model, "UNITS", {}))
    add_log_categories(root)
    SubElement(root, "DefaultExperiment", EXPERIMENT)
    add_variables(root, table)
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
