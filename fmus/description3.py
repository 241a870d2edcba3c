"""Writes modelDescription.xml of FMI 3.0, and the files that FMI 3.0 has beside it, from a model's table."""
from types import ModuleType
from xml.etree.ElementTree import Element, SubElement

from .dependencies import TIME, dependencies
from .description import (
    EXPERIMENT,
    Flavour,
    add_log_categories,
    add_units,
    head,
    value_attributes,
    variable_attributes,
    xml_bytes,
)
from .interface import computed, names, variables
from .trace import Trace

VERSION = "3.0"
TYPES = {"Real": "Float64", "Boolean": "Boolean"}

# What FMI 3.0 calls otherwise than FMI 2.0.
CAPABILITIES = {"canGetAndSetFMUstate": "canGetAndSetFMUState", "canSerializeFMUstate": "canSerializeFMUState",
                "providesDirectionalDerivative": "providesDirectionalDerivatives"}


def model_description(model: ModuleType, trace: Trace, flavour: Flavour, token: str, version: str,
                      tool: str) -> bytes:
    """modelDescription.xml of `model` (FMI 3.0 section 2.4), the same bytes for the same arguments.

    `token` is the instantiation token; `tool` names what made the FMU, with versions.
    """
    table = variables(model.VARIABLES)
    root = head(model, version, tool, VERSION, instantiationToken=token)
    able = {CAPABILITIES.get(name, name): value for name, value in flavour.capabilities.items()}
    SubElement(root, "CoSimulation", modelIdentifier=model.NAME, attrib=able,
               canHandleVariableCommunicationStepSize="true", hasEventMode="false", providesIntermediateUpdate="false",
               canReturnEarlyAfterIntermediateUpdate="false")
    add_units(root, table, "s")
    add_log_categories(root)
    SubElement(root, "DefaultExperiment", EXPERIMENT)
    parent = SubElement(root, "ModelVariables")
    for v in table:
        SubElement(parent, TYPES[v.type], {**variable_attributes(v), **value_attributes(v)})
    reference = {v.name: v.value_reference for v in table}
    reference[TIME] = len(reference)
    SubElement(parent, "Float64", name=TIME, valueReference=str(reference[TIME]), causality="independent",
               variability="continuous", unit="s", description="time since the experiment's zero")
    known = dependencies(model, trace)
    structure = SubElement(root, "ModelStructure")

    def add(tag: str, name: str, needs: list[str]) -> None:
        SubElement(structure, tag, valueReference=str(reference[name]),
                   dependencies=" ".join(map(str, sorted(reference[n] for n in needs))))

    for name in names(table, "output"):
        add("Output", name, known.after_step[name])
    for name in computed(table):
        add("InitialUnknown", name, known.at_start[name])
    return xml_bytes(root)


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
