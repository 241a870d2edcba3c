"""Single defects of an FMI 3.0 FMU: the rule that each breaks, and what to replace in one of its XML files by what."""

from collections.abc import Callable
from typing import NamedTuple

import defects_dynamic
from check_fixture import library, swapped
from check_fixture3 import BASE_XML, CLOCK_XML, altered, members


class Defect(NamedTuple):
    """`build` gives the archive's members. `macro` is for a defect of the binary, which is run."""

    rule: str
    what: str
    build: Callable[[], dict[str, bytes]]
    macro: str = ""

    def __str__(self) -> str:
        return f"{self.rule}: {self.what}"


def _swap(rule: str, what: str, *edits: str, base: str = BASE_XML) -> Defect:
    """Old text, new text, and so on in turn, in modelDescription.xml."""
    xml = base
    for old, new in zip(edits[::2], edits[1::2], strict=True):
        xml = swapped(old, new, xml)
    return Defect(rule, what, lambda: members(xml))


def _edit(rule: str, what: str, variable: str, old: str, new: str, base: str = BASE_XML) -> Defect:
    """Replace text in the one line that declares a variable."""
    line = next(line for line in base.splitlines() if f' name="{variable}" valueReference=' in line)
    return _swap(rule, what, line, swapped(old, new, line), base=base)


def _before(rule: str, what: str, mark: str, new: str, *edits: str, base: str = BASE_XML) -> Defect:
    """Insert text before a mark, and perhaps make further edits."""
    return _swap(rule, what, mark, new + mark, *edits, base=base)


def _clock(rule: str, what: str, variable: str, old: str, new: str) -> Defect:
    """Replace text in the description that has clocks."""
    return _edit(rule, what, variable, old, new, base=CLOCK_XML)


def _file(rule: str, what: str, old: str, new: str) -> Defect:
    """Replace text in one of the further XML files."""
    return Defect(rule, what, lambda: altered(old, new))


def _member(rule: str, what: str, add: dict[str, bytes] | None = None, without: str = "") -> Defect:
    """Add members to the archive, or leave one out."""
    def build() -> dict[str, bytes]:
        return {name: data for name, data in members().items() if name != without} | (add or {})
    return Defect(rule, what, build)


_LAST = "  </ModelVariables>"
_COUNT = '    <Output valueReference="20" dependencies=""/>\n'
_TAU = '    <InitialUnknown valueReference="6" dependencies="4" dependenciesKind="dependent"/>\n'
_FIRST_INITIAL = '    <InitialUnknown valueReference="2"'
_DERIVATIVE = "    <ContinuousStateDerivative"
_Y = 'valueReference="8" dependencies="1 3" dependenciesKind="tunable constant"'
_PARAMETER = '<{} name="p" valueReference="90" causality="parameter" variability="fixed" {}/>\n'
_LATIN = 'encoding="ISO-8859-1"'
_FLAT = ('variableNamingConvention="structured"', 'variableNamingConvention="flat"')

STATIC = (
    # the file and its header
    _swap("xml.encoding", "encoded in Latin-1", 'encoding="UTF-8"', _LATIN),
    _swap("xml.encoding-declared", "no encoding declared", '<?xml version="1.0" encoding="UTF-8"?>\n', ""),
    _swap("xml.well-formed", "an element left open", "</ModelStructure>", ""),
    _swap("xml.entities", "a harmless entity", '"UTF-8"?>', '"UTF-8"?>\n<!DOCTYPE a [<!ENTITY b "c">]>'),
    _swap("xml.fmi-version", "a beta version", 'fmiVersion="3.0"', 'fmiVersion="3.0-beta.3"'),
    _swap("xml.fmi-version", "a later version", 'fmiVersion="3.0"', 'fmiVersion="3.1"'),
    _swap("xml.schema", "the GUID of FMI 2.0", "instantiationToken=", "guid="),
    _edit("xml.schema", "the start value of a String as an attribute", "message", '"discrete"', '"discrete" start="a"'),
    _edit("xml.schema", "an unknown causality", "gain", 'causality="parameter"', 'causality="knob"'),
    _edit("xml.schema", "a Real", "gain", "<Float64", "<Real"),
    _swap("header.guid", "an empty token", '"{8c4e810f-3df3-4a00-8276-176fa3c9f001}"', '""'),
    _swap("header.model-name", "an empty model name", 'modelName="Fixture"', 'modelName=""'),
    _swap("header.date-past", "a date in the future", "2026-01-02T03:04:05Z", "2999-01-02T03:04:05Z"),
    _swap("header.interface", "no interface", BASE_XML[BASE_XML.index("  <Co") : BASE_XML.index("  <UnitD")], ""),
    _swap("header.model-identifier", "a blank", 'modelIdentifier="Fixture"', 'modelIdentifier="Fix ture"'),
    _swap("header.serialize-needs-state", "bytes without state", 'canGetAndSetFMUState="true"', ""),
    _swap("header.serialize-needs-state", "the flag as FMI 2.0 spells it", "canGetAndSetFMUState=",
          "canGetAndSetFMUstate="),
    _swap("header.early-return", "an early return without updates", 'hasEventMode="true"',
          'hasEventMode="true" canReturnEarlyAfterIntermediateUpdate="true"'),
    _before("log.unique", "a log category twice", "  </LogCategories>", '<Category name="logAll"/>'),
    _before("log.standard-name", "a misspelled category", "  </LogCategories>", '<Category name="LogEvents"/>'),
    _swap("experiment.stop", "stop before start", 'startTime="0"', 'startTime="2"'),
    _swap("experiment.tolerance", "a negative tolerance", 'tolerance="1e-6"', 'tolerance="-1e-6"'),
    _swap("experiment.step", "step size 0", 'stepSize="0.01"', 'stepSize="0"'),
    _swap("experiment.step-fits", "a step longer than the experiment", 'stepSize="0.01"', 'stepSize="5"'),
    # units and types
    _before("unit.unique", "a unit twice", "  </UnitDefinitions>", '<Unit name="s"><BaseUnit s="1"/></Unit>'),
    _before("unit.display-unique", "a display unit twice", '<DisplayUnit name="cm"', '<DisplayUnit name="km"/>'),
    _swap("unit.base-factor", "base factor 0", '"1/s"><BaseUnit s="-1"/>', '"1/s"><BaseUnit s="-1" factor="0"/>'),
    _swap("unit.display-factor", "display factor 0", 'factor="0.001"', 'factor="0"'),
    _before("unit.display-is-unit", "a metre of 2 m", '<DisplayUnit name="cm"', '<DisplayUnit name="m" factor="2"/>'),
    _swap("unit.inverse", "an inverse with an offset", 'inverse="true"', 'inverse="true" offset="1"'),
    _swap("unit.known-name", "a second of 2 s", '<BaseUnit s="1"/>', '<BaseUnit s="1" factor="2"/>'),
    _edit("unit.defined", "an unknown unit", "tau", 'unit="s"', 'unit="h"'),
    _before("unit.unused", "an unused unit", "  </UnitDefinitions>", '<Unit name="kg"><BaseUnit kg="1"/></Unit>'),
    _edit("unit.display-needs-unit", "a display unit alone", "gain", "start=", 'displayUnit="%" start='),
    _edit("unit.display-defined", "an unknown display unit", "y", 'displayUnit="cm"', 'displayUnit="mile"'),
    _edit("unit.display-defined", "an alias of an unknown display unit", "x", 'displayUnit="cm"', 'displayUnit="mile"'),
    _edit("unit.derivative", "a speed in metres", "der(x)", 'unit="m/s"', 'unit="m"'),
    _before("type.unique", "a type twice", "  </TypeDefinitions>", '<Float64Type name="Length" unit="m"/>'),
    _swap("type.no-variable-name", "a type and a variable", 'Type name="Mode"', 'Type name="k"',
          'declaredType="Mode"', 'declaredType="k"'),
    _before("type.item-values", "an item value twice", "</EnumerationType>", '<Item name="full" value="2"/>'),
    _before("type.item-names", "an item name twice", "</EnumerationType>", '<Item name="idle" value="3"/>'),
    _edit("type.declared", "an unknown type", "gain", "start=", 'declaredType="Gain" start='),
    _edit("type.kind", "a float of an enumeration type", "gain", "start=", 'declaredType="Mode" start='),
    _before("type.unused", "an unused type", "  </TypeDefinitions>", '<Int8Type name="T"/>'),
    _edit("range.min-max", "min above max", "u", 'min="-10" max="10"', 'min="10" max="-10"'),
    _edit("range.nominal", "nominal 0", "y", 'nominal="1"', 'nominal="0"'),
    _edit("range.within-type", "a range wider than the type's", "x", 'start="1"', 'start="1" max="2000"'),
    _before("xml.schema", "an Int8 of 200", _LAST, _PARAMETER.format("Int8", 'start="200"')),
    _before("xml.schema", "a UInt16 down to -1", _LAST, _PARAMETER.format("UInt16", 'start="1" min="-1"')),
    # variables
    _edit("variable.unique", "a name twice", "g", 'name="g"', 'name="gain"'),
    _edit("variable.unique", "an alias with a variable's name", "x", 'name="plant.x[1]"', 'name="y"'),
    _edit("variable.named", "an empty name", "g", 'name="g"', 'name=""'),
    _swap("variable.flat-name", "a line feed in a flat name", *_FLAT, ' name="g"', ' name="a&#10;g"'),
    _swap("variable.name-spaces", "a name that ends in a space", *_FLAT, ' name="g"', ' name="g "'),
    _edit("variable.structured-name", "a name with a blank", "g", 'name="g"', 'name="a g"'),
    _edit("variable.derivative-name", "der() of a whole number", "count", 'name="count"', 'name="der(n)"'),
    _edit("variable.reference-unique", "a value reference twice", "g", 'valueReference="7"', 'valueReference="5"'),
    _edit("variable.causality", "a continuous parameter", "gain", '"tunable"', '"continuous"'),
    _edit("variable.causality", "a discrete structural parameter", "size", '"fixed"', '"discrete"'),
    _edit("variable.continuous-real", "a continuous Boolean", "on", '"discrete"', '"continuous"'),
    _edit("variable.initial", "a calculated parameter that is exact", "tau", '"calculated"', '"exact"'),
    _edit("variable.start-missing", "an input without start", "on", ' start="true"', ""),
    _edit("variable.start-missing", "a String parameter without start", "label", '<Start value="tank"/>', ""),
    _edit("variable.start-forbidden", "a calculated output with start", "y", "nominal=", 'start="0" nominal='),
    _edit("variable.start-range", "start above max", "u", 'start="0"', 'start="11"'),
    _edit("variable.start-range", "an element below min", "table", 'start="1 2 3"', 'min="0" start="1 -2 3"'),
    _before("variable.start-item", "an enumeration between its items", _LAST,
            _PARAMETER.format("Enumeration", 'declaredType="Mode" start="5"')),
    _edit("variable.independent", "no time", "time", 'causality="independent"', 'causality="local"'),
    _before("variable.independent", "two times", _LAST,
            '<Float64 name="t2" valueReference="90" causality="independent"/>'),
    _edit("variable.independent-type", "a time of whole numbers", "time",
          '<Float64 name="time" valueReference="0" causality="independent" variability="continuous" unit="s"/>',
          '<Int64 name="time" valueReference="0" causality="independent" variability="discrete"/>'),
    _edit("variable.derivative-index", "the derivative of value reference 99", "der(x)", 'derivative="1"',
          'derivative="99"'),
    _edit("variable.derivative-real", "the derivative of a parameter", "y", "nominal=", 'derivative="5" nominal='),
    _edit("variable.reinit-state", "an input that can be reinitialized", "u", "start=", 'reinit="false" start='),
    _edit("variable.multiple-set-input", "a parameter to be set once", "gain", "start=",
          'canHandleMultipleSetPerTimeInstant="false" start='),
    _edit("variable.intermediate", "a discrete input between steps", "on", "start=",
          'intermediateUpdate="true" start='),
    # arrays
    _edit("array.dimension", "a size that no variable has", "table", 'valueReference="60"', 'valueReference="99"'),
    _edit("array.dimension", "a size by a Float64", "table", 'valueReference="60"', 'valueReference="5"'),
    _edit("array.size", "an array of size 0", "table", '<Dimension valueReference="60"/>', '<Dimension start="0"/>'),
    _edit("array.size", "a size of both kinds", "table", 'Dimension valueReference="60"',
          'Dimension start="3" valueReference="60"'),
    _edit("array.starts", "two start values for three elements", "table", 'start="1 2 3"', 'start="1 2"'),
    _edit("array.starts", "two start values for a scalar", "gain", 'start="2"', 'start="2 3"'),
    _before("array.structural", "a vector of sizes", _LAST, '<UInt64 name="p" valueReference="90" start="2" '
            'causality="structuralParameter" variability="fixed"><Dimension start="2"/></UInt64>\n'),
    # clocks
    _swap("clock.event-mode", "clocks without event mode", 'hasEventMode="true"', "", base=CLOCK_XML),
    _clock("clock.causality", "a clock that is a parameter", "tick", 'causality="input"', 'causality="parameter"'),
    _clock("clock.causality", "an output clock with an interval", "alarm", '"triggered"',
           '"constant" intervalDecimal="1"'),
    _clock("clock.causality", "an output clock with a priority", "alarm", '"triggered"', '"triggered" priority="1"'),
    _clock("clock.interval", "a constant clock without interval", "tick", 'intervalDecimal="0.1"', ""),
    _clock("clock.interval", "an interval of 0", "tick", 'intervalDecimal="0.1"', 'intervalDecimal="0"'),
    _clock("clock.interval", "a negative shift", "tick", 'intervalDecimal="0.1"',
           'intervalDecimal="0.1" shiftDecimal="-1"'),
    _clock("clock.interval", "a triggered clock with an interval", "alarm", '"triggered"',
           '"triggered" intervalDecimal="1"'),
    _clock("clock.interval", "a counter without resolution", "tick", 'intervalDecimal="0.1"',
           'intervalDecimal="0.1" intervalCounter="1"'),
    _clock("clock.reference", "clocked by a parameter", "before", "start=", 'clocks="5" start='),
    _clock("clock.reference", "clocked by what no variable has", "ticks", 'clocks="80"', 'clocks="99"'),
    _clock("clock.reference", "clocked twice by one", "ticks", 'clocks="80"', 'clocks="80 80"'),
    _clock("clock.state", "a clocked state without previous", "ticks", ' previous="83"', ""),
    _clock("variable.previous", "previous of itself", "ticks", 'previous="83"', 'previous="82"'),
    _clock("variable.previous", "previous of another type", "before", "<Int32", "<Int16"),
    # model structure
    _before("structure.index", "an output of value reference 99", _COUNT,
            '<Output valueReference="99" dependencies=""/>\n'),
    _before("structure.unique", "an output twice", _DERIVATIVE, _COUNT),
    _swap("structure.outputs-complete", "an output not listed", _COUNT, ""),
    _before("structure.outputs-only", "an input among the outputs", _COUNT,
            '<Output valueReference="3" dependencies=""/>\n'),
    _before("structure.derivative", "no derivative", _FIRST_INITIAL,
            '<ContinuousStateDerivative valueReference="1" dependencies=""/>\n'),
    _edit("structure.state", "a state that is an input", "der(x)", 'derivative="1"', 'derivative="3"'),
    _swap("structure.initial-complete", "an initial unknown not listed", _TAU, ""),
    _before("structure.initial-only", "an exact unknown", _TAU,
            '<InitialUnknown valueReference="5" dependencies=""/>\n'),
    _before("structure.event-indicator", "a parameter that indicates events", "  </ModelStructure>",
            '<EventIndicator valueReference="5"/>\n'),
    _swap("dependency.index", "a dependency on value reference 99", _Y,
          'valueReference="8" dependencies="1 3 99" dependenciesKind="tunable constant dependent"'),
    _swap("dependency.kind-count", "a kind too many", '"tunable constant"', '"tunable constant fixed"'),
    _swap("dependency.initial-kind", "a fixed initial dependency", "t constant dependent", "t fixed dependent"),
    _swap("dependency.kind-real", "an enumeration with a factor",
          '<Output valueReference="21" dependencies="3" dependenciesKind="dependent"/>',
          '<Output valueReference="21" dependencies="3" dependenciesKind="constant"/>'),
    _swap("dependency.known", "an output that depends on a calculated parameter", _Y,
          'valueReference="8" dependencies="1 3 6" dependenciesKind="tunable constant dependent"'),
    _swap("dependency.missing", "an output without dependencies", _COUNT, '    <Output valueReference="20"/>\n'),
    # terminals and icons, build description, layered standards
    _file("terminals.schema", "an unknown element", "<Terminals>", "<Terminals><Bolt/>"),
    _file("terminals.schema", "another version", '<fmiTerminalsAndIcons fmiVersion="3.0"',
          '<fmiTerminalsAndIcons fmiVersion="3.0.1"'),
    _file("terminals.variable", "a member that is no variable", 'variableName="u"', 'variableName="w"'),
    _file("terminals.unique", "a member name twice", 'memberName="place"', 'memberName="speed"'),
    _file("terminals.unique", "two terminals of one name", "  </Terminals>",
          '<Terminal name="flange" matchingRule="none"/></Terminals>'),
    _file("terminals.member-name", "a member of a bus without name", ' memberName="place"', ""),
    _file("terminals.icon", "an icon that is not there", 'iconBaseName="flange"', 'iconBaseName="bolt"'),
    _member("terminals.icon", "an icon that is no image", {"terminalsAndIcons/icon.png": b"<svg/>"}),
    _file("terminals.area", "an icon without width", 'x1="-80"', 'x1="80"'),
    _file("terminals.area", "coordinates from right to left", 'x1="-100" y1="-100" x2="100"',
          'x1="100" y1="-100" x2="-100"'),
    _file("build.schema", "a configuration without sources",
          '<SourceFileSet language="C99"><SourceFile name="fixture.c"/></SourceFileSet>', "<SourceFiles/>"),
    _member("build.present", "sources without a build description", without="sources/buildDescription.xml"),
    _file("build.identifier", "another model",
          'modelIdentifier="Fixture" platform', 'modelIdentifier="Other" platform'),
    _file("build.identifier", "two configurations for any platform", ' platform="x86_64-linux"', ""),
    _file("build.files", "a file that is not there", 'compiler="gcc"><SourceFile name="fixture.c"/>',
          'compiler="gcc"><SourceFile name="other.c"/>'),
    _file("build.files", "a file twice", 'compiler="gcc"><SourceFile name="fixture.c"/>',
          'compiler="gcc"><SourceFile name="fixture.c"/><SourceFile name="fixture.c"/>'),
    _file("layered.manifest", "no version", 'fmi-ls:fmi-ls-version="1.0"', ""),
    _member("layered.folder", "a folder without a domain", {"extra/notes/a.txt": b"a"}),
    # the archive
    _member("archive.entries", "an icon where FMI 2.0 had it", {"model.png": b"\x89PNG\r\n\x1a\n"}),
    _member("archive.documentation", "documentation without index.html", {"documentation/a.txt": b"a"}),
    _member("binary.platform", "a folder as FMI 2.0 named it", {"binaries/linux64/Fixture.so": b""}),
    _member("binary.format", "a text file for Windows", {"binaries/x86_64-windows/Fixture.dll": b"a"}),
    _member("binary.name", "another name for Windows", {"binaries/x86_64-windows/Other.dll": b"a"}),
    Defect("binary.exports", "FMI 2.0's functions only", lambda: members() | {
        "binaries/x86_64-linux/Fixture.so": library()}),
)

# Of the defects of fixture.c, what FMI 3.0 has no function or argument for.
_OF_2 = {"TYPES_PLATFORM", "INPUT_DERIVATIVES", "LOG_NAME", "STEP_PENDING", "DISCARD_STATUS", "SPOILS"}
_OF_3 = (
    ("event-mode", "EVENT_REFUSED", "fmi3EnterEventMode fails"),
    ("event-mode", "EVENT_FAILS", "fmi3UpdateDiscreteStates fails"),
    ("event-mode", "EVENT_RESTLESS", "discrete states always need another update"),
    ("event-unasked", "EVENT_UNASKED", "a step asks for event mode, which is not used"),
    ("event-unasked", "EARLY_UNASKED", "a step returns early, which is not allowed"),
    ("last-time", "LAST_TIME", "fmi3DoStep does not tell the time"),
    ("configuration", "CONFIGURE_FAILS", "fmi3EnterConfigurationMode fails"),
    ("write-ignored", "ARRAY_IGNORED", "an array that is set keeps its values"),
)


def _dynamic(rule: str, macro: str, what: str) -> Defect:
    return Defect(rule, what.replace("fmi2", "fmi3"), lambda: members(defect=macro), macro)


DYNAMIC = (*(_dynamic(defect.rule, defect.macro, defect.what) for defect in defects_dynamic.DEFECTS
             if defect.macro not in _OF_2 and not defect.edits),
           *(_dynamic(f"dynamic.{rule}", macro, what) for rule, macro, what in _OF_3))
