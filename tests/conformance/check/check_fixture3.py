"""Builds the correct FMI 3.0 FMU of these tests (fixture3.c around fixture.c, fixture3.xml) and defective copies."""

import re
import tempfile
from functools import cache
from pathlib import Path

from check_fixture import _HEADERS, _WORK, HERE, swapped

from fmus.native_compiler import cc

BASE_XML = (HERE / "fixture3.xml").read_text("utf-8")
SOURCES = [(HERE / name).read_text("utf-8") for name in ("fixture.c", "fixture3.c")]
C_DEFECTS = sorted(set(re.findall(r"BUG\(([A-Z0-9_]+)\)", "".join(SOURCES))) - {"NAME"} | {"UNRESOLVED"})
PNG = b"\x89PNG\r\n\x1a\n"
_TERMINALS = """<?xml version="1.0" encoding="UTF-8"?>
<fmiTerminalsAndIcons fmiVersion="3.0">
  <GraphicalRepresentation>
    <CoordinateSystem x1="-100" y1="-100" x2="100" y2="100" suggestedScalingFactorTo_mm="0.1"/>
    <Icon x1="-80" y1="-80" x2="80" y2="80"/>
  </GraphicalRepresentation>
  <Terminals>
    <Terminal name="flange" matchingRule="bus">
      <TerminalMemberVariable variableName="u" memberName="speed" variableKind="signal"/>
      <TerminalMemberVariable variableName="plant.x[1]" memberName="place" variableKind="signal"/>
      <Terminal name="flange" matchingRule="sequence">
        <TerminalMemberVariable variableName="y" variableKind="signal"/>
      </Terminal>
      <TerminalGraphicalRepresentation x1="90" y1="-10" x2="110" y2="10" iconBaseName="flange"/>
    </Terminal>
  </Terminals>
</fmiTerminalsAndIcons>
"""
_BUILD = """<?xml version="1.0" encoding="UTF-8"?>
<fmiBuildDescription fmiVersion="3.0">
  <BuildConfiguration modelIdentifier="Fixture">
    <SourceFileSet language="C99"><SourceFile name="fixture.c"/></SourceFileSet>
  </BuildConfiguration>
  <BuildConfiguration modelIdentifier="Fixture" platform="x86_64-linux">
    <SourceFileSet language="C99" compiler="gcc"><SourceFile name="fixture.c"/></SourceFileSet>
  </BuildConfiguration>
</fmiBuildDescription>
"""
_MANIFEST = """<?xml version="1.0" encoding="UTF-8"?>
<fmiLayeredStandardManifest xmlns:fmi-ls="http://fmi-standard.org/fmi-ls-manifest" fmi-ls:fmi-ls-name="org.example.ls"
    fmi-ls:fmi-ls-version="1.0" fmi-ls:fmi-ls-description="an example"/>
"""
FURTHER = {
    "terminalsAndIcons/terminalsAndIcons.xml": _TERMINALS.encode(),
    "terminalsAndIcons/icon.png": PNG,
    "terminalsAndIcons/flange.png": PNG,
    "sources/buildDescription.xml": _BUILD.encode(),
    "sources/fixture.c": b"int nothing;\n",
    "extra/org.example.ls/fmi-ls-manifest.xml": _MANIFEST.encode(),
}
# A correct description with clocks; only what reads the file is tested with it.
CLOCKS = """
    <Clock name="tick" valueReference="80" causality="input" intervalVariability="constant" intervalDecimal="0.1"/>
    <Clock name="alarm" valueReference="81" causality="output" intervalVariability="triggered"/>
    <Int32 name="ticks" valueReference="82" causality="local" clocks="80" previous="83" initial="exact" start="0"/>
    <Int32 name="before" valueReference="83" causality="local" initial="exact" start="0"/>
  </ModelVariables>"""
CLOCK_XML = BASE_XML.replace("\n  </ModelVariables>", CLOCKS).replace(
    '    <ContinuousState', '    <Output valueReference="81" dependencies="80"/>\n    <ContinuousState', 1).replace(
    "    <InitialUnknown", '    <ClockedState valueReference="82" dependencies="80"/>\n    <InitialUnknown', 1)


@cache
def library(defect: str | None = None) -> bytes:
    """The shared library, with one defect or none."""
    if defect is not None and defect not in C_DEFECTS:
        raise ValueError(f"fixture.c and fixture3.c have no defect '{defect}'")
    folder = Path(tempfile.mkdtemp(dir=_WORK.name))
    (folder / "defect.h").write_text("".join(f"#define DEFECT_{name} {int(name == defect)}\n" for name in C_DEFECTS))
    target = folder / "Fixture.so"
    options = ["-shared", "-fPIC", "-O0", "-w", "-fno-sanitize=undefined", f"-I{folder}", f"-I{_HEADERS}"]
    cc(*options, HERE / "fixture3.c", HERE / "fixture3_rest.c", "-o", target, "-lm")
    return target.read_bytes()


def members(xml: str = BASE_XML, defect: str | None = None) -> dict[str, bytes]:
    """The archive's members."""
    named = re.search(r'<CoSimulation modelIdentifier="([^"]*)"', xml)
    binary = f"binaries/x86_64-linux/{named[1] if named else 'Fixture'}.so"
    return {"modelDescription.xml": xml.encode("utf-8"), binary: library(defect), **FURTHER}


def altered(old: str, new: str) -> dict[str, bytes]:
    """The archive's members with one piece of text replaced, in the one file that has it."""
    content = members()
    for name, data in content.items():
        if name.endswith(".xml") and old.encode() in data:
            return content | {name: swapped(old, new, data.decode()).encode()}
    raise ValueError(f"no file of the fixture has '{old}'")
