"""Writes modelDescription.xml and the presets' parameter sets (SSV) from a model's table."""
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import ModuleType
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import casadi

from .interface import Variable, computed, names, variables
from .trace import Trace
from .units import DEGREES, Worth, si_base

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
SSV = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"


@dataclass(frozen=True)
class Flavour:
    """What one kind of FMU binary can do; attributes of <CoSimulation>, and its C sources if it has any."""
    capabilities: dict[str, str]
    sources: list[str] = field(default_factory=list)


def number(value: float) -> str:
    """A number as XML that gives the very same double."""
    return repr(float(value))


def boolean(value: object) -> str:
    """A truth value as XML."""
    return "true" if value else "false"


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
        for shown in sorted({v.display_unit for v in table if v.unit == unit and v.display_unit}):
            SubElement(element, "DisplayUnit", name=shown, factor=number(DEGREES))


def add_variable(parent: Element, v: Variable) -> None:
    """One <ScalarVariable>."""
    port = v.causality in ("input", "output")
    variability = "fixed" if not port else "discrete" if v.discrete else "continuous"
    attributes = {"name": v.name, "valueReference": str(v.value_reference), "description": v.description,
                  "causality": v.causality, "variability": variability}
    initial = {"output": "calculated", "calculatedParameter": "calculated", "parameter": "exact"}.get(v.causality)
    if initial:
        attributes["initial"] = initial
    element = SubElement(parent, "ScalarVariable", attributes)
    if v.type == "Boolean":
        SubElement(element, "Boolean", {} if v.start is None else {"start": boolean(v.start)})
        return
    real = {"unit": v.unit, "displayUnit": v.display_unit, "min": v.minimum, "max": v.maximum,
            "nominal": v.nominal, "start": v.start}
    SubElement(element, "Real", {k: x if isinstance(x, str) else number(x) for k, x in real.items() if x is not None})


def dependencies(trace: Trace) -> tuple[list[list[int]], list[list[int]]]:
    """For each computed variable: the inputs it depends on directly after a step, and the inputs, then
    parameters (counted on from the inputs) it depends on at initialisation."""
    t, x = trace.outputs.sx_in("t"), trace.outputs.sx_in("x")
    u, p = trace.outputs.sx_in("u"), trace.outputs.sx_in("p")
    after_step = casadi.Function("y", [u, x, t, p], [trace.outputs(t, x, u, p)])
    at_start = casadi.Function("y0", [casadi.vertcat(u, p), t], [trace.outputs(t, trace.start(u, p), u, p)])

    def rows(function: casadi.Function) -> list[list[int]]:
        pattern = function.jac_sparsity(0, 0)
        found: list[list[int]] = [[] for _ in range(pattern.size1())]
        for row, column in zip(*pattern.get_triplet()):
            found[row].append(column)
        return found

    return rows(after_step), rows(at_start)


def add_structure(root: Element, table: list[Variable], trace: Trace) -> None:
    """<ModelStructure>, with the dependencies of what is computed."""
    position = {v.name: i + 1 for i, v in enumerate(table)}
    inputs, parameters = names(table, "input"), names(table, "parameter")
    after_step, at_start = dependencies(trace)
    structure = SubElement(root, "ModelStructure")

    def add(parent: Element, name: str, known: list[str]) -> None:
        SubElement(parent, "Unknown", index=str(position[name]),
                   dependencies=" ".join(str(i) for i in sorted(position[k] for k in known)))

    outputs = SubElement(structure, "Outputs")
    for name, columns in zip(computed(table), after_step):
        if table[position[name] - 1].causality == "output":
            add(outputs, name, [inputs[i] for i in columns])
    initial = SubElement(structure, "InitialUnknowns")
    for name, columns in zip(computed(table), at_start):
        add(initial, name, [(inputs + parameters)[i] for i in columns])


def model_description(model: ModuleType, trace: Trace, flavour: Flavour, guid: str, version: str,
                      tool: str) -> bytes:
    """modelDescription.xml of `model` (FMI 2.0 section 2.2), the same bytes for the same arguments.

    `tool` names what made the FMU, with versions.
    """
    table = variables(model.VARIABLES)
    root = Element("fmiModelDescription", fmiVersion="2.0", modelName=model.NAME, guid=guid,
                   description=model.DESCRIPTION, version=version, author=AUTHOR, copyright=COPYRIGHT,
                   license=LICENSE, generationTool=tool,
                   variableNamingConvention="flat")
    interface = SubElement(root, "CoSimulation", modelIdentifier=model.NAME,
                           canHandleVariableCommunicationStepSize="true", attrib=flavour.capabilities)
    if flavour.sources:
        files = SubElement(interface, "SourceFiles")
        for source in flavour.sources:
            SubElement(files, "File", name=source)
    add_units(root, table, getattr(model, "UNITS", {}))
    categories = SubElement(root, "LogCategories")
    for name, text in LOG_CATEGORIES.items():
        SubElement(categories, "Category", name=name, description=text)
    SubElement(root, "DefaultExperiment", startTime="0", stopTime="100", stepSize="0.01")
    parent = SubElement(root, "ModelVariables")
    for v in table:
        add_variable(parent, v)
    add_structure(root, table, trace)
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
