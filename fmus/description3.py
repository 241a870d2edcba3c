"""Writes modelDescription.xml of FMI 3.0, and the files that FMI 3.0 has beside it, from a model's table."""
from types import ModuleType
from xml.etree.ElementTree import Element, SubElement

from .dependencies import Dependencies, dependencies
from .description import (
    EXPERIMENT,
    Flavour,
    add_log_categories,
    add_units,
    boolean,
    head,
    number,
    value_attributes,
    variable_attributes,
    xml_bytes,
)
from .interface import Variable
from .references import all_variables
from .trace import Trace

VERSION = "3.0"
TYPES = {"Real": "Float64", "Boolean": "Boolean"}

# What FMI 3.0 calls otherwise than FMI 2.0.
CAPABILITIES = {"canGetAndSetFMUstate": ("canGetAndSetFMUState",), "canSerializeFMUstate": ("canSerializeFMUState",),
                "providesDirectionalDerivative": ("providesDirectionalDerivatives", "providesAdjointDerivatives")}

CO_SIMULATION = {"canHandleVariableCommunicationStepSize": "true", "hasEventMode": "false",
                 "providesIntermediateUpdate": "false", "canReturnEarlyAfterIntermediateUpdate": "false"}


def model_description(model: ModuleType, trace: Trace, flavour: Flavour, token: str, version: str,
                      tool: str) -> bytes:
    """modelDescription.xml of `model` (FMI 3.0 section 2.4), the same bytes for the same arguments.

    `token` is the instantiation token; `tool` names what made the FMU, with versions.
    """
    everything = all_variables(model)
    root = head(model, version, tool, VERSION, instantiationToken=token)
    able = {name: value for old, value in flavour.capabilities.items() for name in CAPABILITIES.get(old, (old,))}
    identity = {"modelIdentifier": model.NAME, **able}
    if trace.derivative and flavour.exchanges:
        SubElement(root, "ModelExchange", identity,
                   needsCompletedIntegratorStep=boolean(any(v.discrete for v in everything)))
    SubElement(root, "CoSimulation", {**identity, **CO_SIMULATION, **sample_time(model)})
    add_units(root, everything, getattr(model, "UNITS", {}))
    add_log_categories(root)
    SubElement(root, "DefaultExperiment", EXPERIMENT)
    place = {v.name: str(v.value_reference) for v in everything}
    parent = SubElement(root, "ModelVariables")
    for v in everything:
        rate = {"derivative": place[v.derivative_of]} if v.derivative_of else {}
        SubElement(parent, TYPES[v.type], {**variable_attributes(v), **value_attributes(v), **rate})
    add_structure(root, everything, dependencies(model, trace))
    return xml_bytes(root)


def sample_time(model: ModuleType) -> dict[str, str]:
    """The internal step of a law that runs at instants of its own."""
    times = [row[3] for row in model.VARIABLES if row[0] == "sample_time"]
    return {"fixedInternalStepSize": number(times[0])} if times else {}


def add_structure(root: Element, everything: list[Variable], known: Dependencies) -> None:
    """<ModelStructure>, with the dependencies of what is computed."""
    place = {v.name: v.value_reference for v in everything}
    structure = SubElement(root, "ModelStructure")

    def add(tag: str, name: str, needs: list[str]) -> None:
        SubElement(structure, tag, valueReference=str(place[name]),
                   dependencies=" ".join(str(place[need]) for need in needs))

    for v in everything:
        if v.causality == "output":
            add("Output", v.name, known.after_step[v.name])
    for v in everything:
        if v.derivative_of:
            add("ContinuousStateDerivative", v.name, known.after_step[v.name])
    for v in everything:
        if v.name in known.at_start:
            add("InitialUnknown", v.name, known.at_start[v.name])


def build_description(model: ModuleType, flavour: Flavour) -> bytes:
    """sources/buildDescription.xml: how the sources are compiled."""
    root = Element("fmiBuildDescription", fmiVersion=VERSION)
    configuration = SubElement(root, "BuildConfiguration", modelIdentifier=model.NAME)
    files = SubElement(configuration, "SourceFileSet", language="C99")
    for source in flavour.sources:
        SubElement(files, "SourceFile", name=source)
    SubElement(configuration, "Library", name="m", external="true", description="the C library's mathematics")
    return xml_bytes(root)


def terminals(model: ModuleType) -> bytes:
    """terminalsAndIcons/terminalsAndIcons.xml: the model's icon, and its TERMINALS (name -> names of variables).

    Two terminals of one name, of any two models, fit each other: each member connects variables of its name.
    """
    root = Element("fmiTerminalsAndIcons", fmiVersion=VERSION)
    drawing = SubElement(root, "GraphicalRepresentation")
    square = {"x1": "-100", "y1": "-100", "x2": "100", "y2": "100"}
    SubElement(drawing, "CoordinateSystem", {**square, "suggestedScalingFactorTo_mm": "0.1"})
    SubElement(drawing, "Icon", square)
    groups = getattr(model, "TERMINALS", {})
    if groups:
        parent = SubElement(root, "Terminals")
    for name, members in groups.items():
        terminal = SubElement(parent, "Terminal", name=name, matchingRule="plug")
        for member in members:
            SubElement(terminal, "TerminalMemberVariable", variableName=member, memberName=member,
                       variableKind="signal")
    return xml_bytes(root)
