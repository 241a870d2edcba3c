"""Builds the small FMU of small3.c, FMI 3.0, in the variants that tests and measurements need."""
import platform
import re
import zipfile
from pathlib import Path

from small import TRUE, library

REALS = ("a21", "a22", "x1", "x2", "substeps", "fault_time", "period", "early", "u", "y", "y1", "y2")
STARTS = {"a21": -4.0, "a22": -0.3, "x1": 1.0, "substeps": 1.0, "fault_time": 1e9}
FAULTS = ("none", "discard", "error", "fatal", "end", "end_in_event", "restless", "stuck", "refuse_event",
          "refuse_update")
TYPES = ("Float64", "Float32", "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64", "Boolean",
         "Enumeration")
MODES = {"aarch64": "aarch64-linux", "x86_64": "x86_64-linux"}


def element(kind: str, name: str, reference: int, causality: str, start: str | None = None, more: str = "",
            inside: str = "") -> str:
    given = "" if start is None or kind in ("String", "Binary") else f' start="{start}"'
    inside += "".join(f'<Start value="{x}"/>' for x in (start or "").split("|")) if kind in ("String", "Binary") and (
        start is not None) else ""
    return f'<{kind} name="{name}" valueReference="{reference}" causality="{causality}"{given}{more}>{inside}</{kind}>'


def describe(identifier: str, events: bool, states: bool, clock: str, more: str) -> str:
    """modelDescription.xml; `clock` is the causality of a clock (empty: none), `more` further elements of
    ModelVariables."""
    causality = {"u": "input", "y": "output", "y1": "output", "y2": "output"}
    lines = ['<Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>']
    for i, name in enumerate(REALS, 1):
        kind = causality.get(name, "parameter")
        fixed = ' variability="fixed"' if kind == "parameter" else ""
        start = None if kind == "output" else repr(STARTS.get(name, 0.0))
        lines.append(element("Float64", name, i, kind, start, fixed,
                             '<Alias name="position" description="another name of y"/>' if name == "y" else ""))
    by_size, two = '<Dimension valueReference="23"/>', '<Dimension start="2"/>'
    lines += [element("Float64", "vector_in", 20, "input", "0.5", "", by_size),
              element("Float64", "vector_out", 21, "output", None, "", two),
              element("Float64", "matrix", 22, "parameter", "1 2 3 4 5 6", ' variability="fixed"', two + by_size),
              element("UInt64", "size", 23, "structuralParameter", "3", ' variability="fixed"')]
    for i, kind in enumerate(TYPES):
        declared = ' declaredType="Colour"' if kind == "Enumeration" else ""
        start = "false" if kind == "Boolean" else "1" if declared else "0"
        lines += [element(kind, f"{kind}_in", 30 + 2 * i, "input", start, declared),
                  element(kind, f"{kind}_out", 31 + 2 * i, "output", None, declared)]
    lines += [element("String", "text_in", 60, "input", "start"), element("String", "text_out", 61, "output"),
              element("String", "texts_in", 62, "input", "one|two", "", two),
              element("String", "texts_out", 63, "output", None, "", two),
              element("Binary", "bytes_in", 64, "input", "00ff"), element("Binary", "bytes_out", 65, "output"),
              element("Int32", "table_in", 66, "input", "0 0 0 0", "", two + two),
              element("Int32", "table_out", 67, "output", None, "", two + two),
              element("Int32", "level_in", 80, "input", "0"), element("Int32", "level_out", 81, "output"),
              element("Int32", "count", 82, "output"), element("Int32", "entered", 83, "output"),
              element("Int32", "fault", 90, "parameter", "0", ' variability="fixed"')]
    if clock:
        lines.append(f'<Clock name="tick" valueReference="99" causality="{clock}" intervalVariability="triggered"/>')
    behind = {10: "", 11: "", 12: "", 21: "20", 61: "60", 63: "62", 65: "64", 67: "66", 81: "80", 82: "", 83: "",
              **{31 + 2 * i: str(30 + 2 * i) for i in range(len(TYPES))}}
    structure = "".join(f'<{tag} valueReference="{out}" dependencies="{inputs}"/>'
                        for tag in ("Output", "InitialUnknown") for out, inputs in behind.items())
    claims = ["canHandleVariableCommunicationStepSize"]
    claims += ["hasEventMode", "mightReturnEarlyFromDoStep"] if events else []
    claims += ["canGetAndSetFMUState", "canSerializeFMUState"] if states else []
    return (f'<?xml version="1.0" encoding="UTF-8"?>\n<fmiModelDescription fmiVersion="3.0" modelName="{identifier}" '
            f'instantiationToken="{{{identifier}}}"><CoSimulation modelIdentifier="small3" '
            f'{"".join(TRUE.format(claim) for claim in claims)}/><UnitDefinitions><Unit name="m"><BaseUnit m="1"/>'
            f'</Unit></UnitDefinitions><TypeDefinitions><EnumerationType name="Colour"><Item name="red" value="1"/>'
            f'<Item name="blue" value="2"/></EnumerationType></TypeDefinitions>'
            f'<ModelVariables>{"".join(lines)}{more}</ModelVariables><ModelStructure>{structure}</ModelStructure>'
            f'</fmiModelDescription>\n')


def build(folder: Path, events: bool = False, states: bool = True, clock: str = "", more: str = "",
          flags: tuple[str, ...] = (), **changed: str) -> Path:
    """Write a variant of the FMU into `folder` and return its path; `flags` are the compiler's, `changed` attributes
    that all elements have with another value."""
    identifier = "_".join(["small3", *(["events"] if events else []), *(["stateless"] if not states else []),
                           *(["clock", clock] if clock else []), *(["more"] if more else []), *changed.values()])
    path = folder / f"{identifier}.fmu"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.write(library(folder, *flags, source="small3.c"),
                      f"binaries/{MODES[platform.machine()]}/small3.so")
        xml = describe(identifier, events, states, clock, more)
        for attribute, value in changed.items():
            xml = re.sub(f'( {attribute})="[^"]*"', rf'\1="{value}"', xml)
        archive.writestr("modelDescription.xml", xml)
    return path
