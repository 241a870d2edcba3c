"""Single defects of modelDescription.xml: the rule that each breaks, and what to replace in fixture.xml by what."""

from typing import NamedTuple

from check_fixture import BASE_XML, swapped


class Defect(NamedTuple):
    """`edits` are pairs of old and new text."""

    rule: str
    what: str
    edits: tuple[tuple[str, str], ...]

    def xml(self) -> str:
        xml = BASE_XML
        for old, new in self.edits:
            xml = swapped(old, new, xml)
        return xml


def _swap(rule: str, what: str, *edits: str) -> Defect:
    """Old text, new text, and so on in turn."""
    return Defect(rule, what, tuple(zip(edits[::2], edits[1::2], strict=True)))


def _edit(rule: str, what: str, variable: str, old: str, new: str) -> Defect:
    """Replace text in the one line that declares a variable."""
    line = next(line for line in BASE_XML.splitlines() if f'<ScalarVariable name="{variable}"' in line)
    return Defect(rule, what, ((line, swapped(old, new, line)),))


def _before(rule: str, what: str, mark: str, new: str, *edits: str) -> Defect:
    """Insert text before a mark, and perhaps make further edits."""
    return _swap(rule, what, mark, new + mark, *edits)


_GUID = 'guid="{8c4e810f-3df3-4a00-8276-176fa3c9f001}"'
_DATE = "2026-01-02T03:04:05Z"
_LAST_UNIT, _LAST_TYPE, _LAST_VARIABLE = "  </UnitDefinitions>", "  </TypeDefinitions>", "  </ModelVariables>"
_LAST_CATEGORY, _LAST_ITEM = "  </LogCategories>", "</Enumeration></SimpleType>"
_LAST_OUTPUT, _LAST_DERIVATIVE, _LAST_INITIAL = "    </Outputs>", "    </Derivatives>", "    </InitialUnknowns>"
_COUNT_OUTPUT = '<Unknown index="8" dependencies=""/>'
_Y_OUTPUT = 'index="13" dependencies="2 4" dependenciesKind="tunable constant"'
_TAU_INITIAL = '<Unknown index="7" dependencies="5" dependenciesKind="dependent"/>'
_LOCAL = '<ScalarVariable name="{}" valueReference="{}" variability="{}" {}><Real {}/></ScalarVariable>'
_TYPED = '<ScalarVariable name="{}" valueReference="9" causality="parameter" variability="fixed">{}</ScalarVariable>'
_STRUCTURED = 'variableNamingConvention="structured"'
_FLAT = 'variableNamingConvention="flat"'

DEFECTS: tuple[Defect, ...] = (
    # 2.2, 2.2.1: the file and its header
    _swap("xml.encoding", "encoded in Latin-1", 'encoding="UTF-8"', 'encoding="ISO-8859-1"'),
    _swap("xml.encoding-declared", "no encoding declared", '<?xml version="1.0" encoding="UTF-8"?>\n', ""),
    _swap("xml.well-formed", "an element left open", "</ModelStructure>", ""),
    _swap("xml.entities", "a harmless entity", '"UTF-8"?>', '"UTF-8"?>\n<!DOCTYPE a [<!ENTITY b "c">]>'),
    _swap("xml.fmi-version", "an FMI 1.0 description", 'fmiVersion="2.0"', 'fmiVersion="1.0"'),
    _swap("xml.schema", "no GUID", f" {_GUID}", ""),
    _swap("xml.schema", "an unknown attribute", 'modelName="Fixture"', 'modelName="Fixture" colour="red"'),
    _edit("xml.schema", "an unknown causality", "label", 'causality="parameter"', 'causality="knob"'),
    _edit("xml.schema", "no value reference", "u", ' valueReference="3"', ""),
    _edit("xml.schema", "a start value that is no number", "gain", 'start="2"', 'start="two"'),
    _before(
        "xml.schema", "an enumeration without type", _LAST_VARIABLE, _TYPED.format("e", '<Enumeration start="1"/>')
    ),
    _edit("xml.finite-attribute", "an infinite maximum", "u", 'max="10"', 'max="INF"'),
    _edit("xml.finite", "a start value that is NaN", "gain", 'start="2"', 'start="NaN"'),
    _swap("header.guid", "an empty GUID", _GUID, 'guid=""'),
    _swap("header.model-name", "an empty model name", 'modelName="Fixture"', 'modelName=""'),
    _swap("header.date", "a date without Z", _DATE, "2026-01-02T03:04:05"),
    _swap("header.date", "a date with a time zone", _DATE, "2026-01-02T03:04:05+00:00"),
    _swap("header.date-past", "a date in the future", _DATE, "2999-01-02T03:04:05Z"),
    _swap("header.event-indicators", "event indicators", _GUID, f'{_GUID} numberOfEventIndicators="3"'),
    _swap("header.interface", "no interface", BASE_XML[BASE_XML.index("  <Co") : BASE_XML.index("  <UnitD")], ""),
    # 4.3.1: the interface and its capability flags
    _swap("header.model-identifier", "a blank", 'modelIdentifier="Fixture"', 'modelIdentifier="Fix ture"'),
    _swap("header.model-identifier", "a word of C", 'modelIdentifier="Fixture"', 'modelIdentifier="double"'),
    _swap("header.serialize-needs-state", "bytes without state", 'canGetAndSetFMUstate="true"', ""),
    _edit("header.interpolate-needs-input", "nothing to interpolate", "u", '"continuous"', '"discrete"'),
    # 2.2.2: units
    _before("unit.unique", "a unit twice", _LAST_UNIT, '<Unit name="s"><BaseUnit s="1"/></Unit>'),
    _before("unit.display-unique", "a display unit twice", '<DisplayUnit name="cm"', '<DisplayUnit name="km"/>'),
    _swap("unit.base-factor", "base factor 0", '<BaseUnit s="-1"/>', '<BaseUnit s="-1" factor="0"/>'),
    _swap("unit.display-factor", "display factor 0", 'factor="0.001"', 'factor="0"'),
    _before("unit.display-is-unit", "a metre of 2 m", '<DisplayUnit name="cm"', '<DisplayUnit name="m" factor="2"/>'),
    _swap("unit.known-name", "a second of 2 s", '<BaseUnit s="1"/>', '<BaseUnit s="1" factor="2"/>'),
    _edit("unit.defined", "an unknown unit", "tau", 'unit="s"', 'unit="h"'),
    _before("unit.unused", "an unused unit", _LAST_UNIT, '<Unit name="kg"><BaseUnit kg="1"/></Unit>'),
    _edit("unit.display-needs-unit", "a display unit alone", "gain", "<Real ", '<Real displayUnit="%" '),
    _edit("unit.display-defined", "an unknown display unit", "y", 'displayUnit="cm"', 'displayUnit="mile"'),
    _edit("unit.derivative", "a speed in metres", "der(x)", 'unit="m/s"', 'unit="m"'),
    # 2.2.3: types
    _before("type.unique", "a type twice", _LAST_TYPE, '<SimpleType name="Length"><Real unit="m"/></SimpleType>'),
    _swap("type.no-variable-name", "a type and a variable", 'Type name="Mode"', 'Type name="k"', '"Mode"', '"k"'),
    _before("type.item-values", "an item value twice", _LAST_ITEM, '<Item name="full" value="2"/>'),
    _before("type.item-names", "an item name twice", _LAST_ITEM, '<Item name="idle" value="3"/>'),
    _edit("type.declared", "an unknown type", "gain", "<Real ", '<Real declaredType="Gain" '),
    _edit("type.kind", "a Real of an enumeration type", "gain", "<Real ", '<Real declaredType="Mode" '),
    _before("type.unused", "an unused type", _LAST_TYPE, '<SimpleType name="T"><Real/></SimpleType>'),
    _edit("range.min-max", "min above max", "u", 'min="-10" max="10"', 'min="10" max="-10"'),
    _swap("range.min-max", "min above max in a type", 'min="-1000" max="1000"', 'min="1000" max="-1000"'),
    _edit("range.within-type", "a range wider than the type's", "x", 'start="1"', 'start="1" max="2000"'),
    _edit("range.nominal", "nominal 0", "y", 'nominal="1"', 'nominal="0"'),
    _edit("range.nominal", "a negative nominal", "y", 'nominal="1"', 'nominal="-1"'),
    _swap("range.nominal", "nominal 0 in a type", 'nominal="1" min', 'nominal="0" min'),
    # 2.2.4 to 2.2.6: log categories, default experiment, annotations
    _before("log.unique", "a log category twice", _LAST_CATEGORY, '<Category name="logAll"/>'),
    _before("log.standard-name", "a misspelled category", _LAST_CATEGORY, '<Category name="LogEvents"/>'),
    _swap("experiment.stop", "stop before start", 'startTime="0"', 'startTime="2"'),
    _swap("experiment.tolerance", "a negative tolerance", 'tolerance="1e-6"', 'tolerance="-1e-6"'),
    _swap("experiment.step", "step size 0", 'stepSize="0.01"', 'stepSize="0"'),
    _swap("experiment.step-fits", "a step longer than the experiment", 'stepSize="0.01"', 'stepSize="5"'),
    _swap("annotation.unique", "a tool annotated twice", '<Tool name="two"/>', '<Tool name="one"/>'),
    # 2.2.7: variables
    _edit("variable.unique", "a name twice", "g", 'name="g"', 'name="gain"'),
    _edit("variable.named", "an empty name", "g", 'name="g"', 'name=""'),
    _edit("variable.causality", "a continuous parameter", "gain", '"tunable"', '"continuous"'),
    _edit("variable.causality", "a constant input", "on", '"discrete"', '"constant"'),
    _edit("variable.continuous-real", "a continuous Boolean", "on", '"discrete"', '"continuous"'),
    _edit("variable.continuous-real", "an Integer of default variability", "count", ' variability="discrete"', ""),
    _edit("variable.initial", "an input with initial", "u", '"input"', '"input" initial="exact"'),
    _edit("variable.initial", "a calculated parameter that is exact", "tau", '"calculated"', '"exact"'),
    _edit("variable.start-missing", "an input without start", "on", ' start="true"', ""),
    _edit("variable.start-missing", "an exact output without start", "count", ' start="0"', ""),
    _edit("variable.start-missing", "a parameter without start", "gain", ' start="2"', ""),
    _edit("variable.start-forbidden", "a calculated output with start", "y", "<Real ", '<Real start="0" '),
    _edit("variable.start-forbidden", "a time with start", "time", "<Real ", '<Real start="0" '),
    _edit("variable.start-range", "start above max", "u", 'start="0"', 'start="11"'),
    _edit("variable.start-range", "start above the type's max", "x", 'start="1"', 'start="2000"'),
    _before(
        "variable.start-item",
        "an enumeration that starts between its items",
        _LAST_VARIABLE,
        _TYPED.format("e", '<Enumeration declaredType="Mode" start="5"/>'),
    ),
    _before(
        "variable.independent",
        "two times",
        _LAST_VARIABLE,
        _LOCAL.format("t2", 0, "continuous", 'causality="independent"', 'unit="s"'),
    ),
    _edit("variable.derivative-index", "the derivative of variable 99", "y", "<Real ", '<Real derivative="99" '),
    _edit("variable.derivative-real", "the derivative of a parameter", "y", "<Real ", '<Real derivative="6" '),
    _edit("variable.reinit", "a state that can be reinitialized", "x", "<Real ", '<Real reinit="false" '),
    _before(
        "variable.reinit-state",
        "an input that can be reinitialized",
        "  <CoSimulation",
        '<ModelExchange modelIdentifier="Fixture"/>',
        '<Real unit="m/s" min',
        '<Real reinit="false" unit="m/s" min',
    ),
    _edit(
        "variable.multiple-set",
        "a flag for model exchange",
        "u",
        " caus",
        ' canHandleMultipleSetPerTimeInstant="1" caus',
    ),
    _before(
        "alias.settable",
        "two parameters of one value",
        _LAST_VARIABLE,
        _LOCAL.format("gain2", 5, "tunable", 'causality="parameter"', 'start="2"'),
    ),
    _before(
        "alias.constant",
        "a constant aliased to a parameter",
        _LAST_VARIABLE,
        _LOCAL.format("two", 5, "constant", "", 'start="2"'),
    ),
    _before(
        "alias.constant-start",
        "two constants of one value",
        _LAST_VARIABLE,
        _LOCAL.format("g2", 7, "constant", "", 'start="9.8"'),
    ),
    _edit("alias.unit", "an alias in seconds", "plant.x[1]", 'unit="m"', 'unit="s"'),
    _before(
        "alias.variability", "a discrete alias", _LAST_VARIABLE, _LOCAL.format("x2", 1, "discrete", "", 'unit="m"')
    ),
    _before(
        "alias.independent",
        "a parameter that is time",
        _LAST_VARIABLE,
        _LOCAL.format("t2", 0, "tunable", 'causality="parameter"', 'unit="s" start="0"'),
    ),
    # 2.2.9: names
    _before("variable.derivative-name", "an Integer derivative", _LAST_VARIABLE,
            '<ScalarVariable name="der(n)" valueReference="9" variability="discrete"><Integer/></ScalarVariable>'),
    _edit("variable.structured-name", "a name that begins with a digit", "g", 'name="g"', 'name="9g"'),
    _edit("variable.structured-name", "an open bracket", "plant.x[1]", "plant.x[1]", "plant.x[1"),
    _swap("variable.flat-name", "a line feed in a flat name", _STRUCTURED, _FLAT, 'name="g"', 'name="a&#10;g"'),
    _swap("variable.name-spaces", "a name that ends in a space", _STRUCTURED, _FLAT, 'name="g"', 'name="g "'),
    # 2.2.8: model structure
    _before("structure.index", "an output of index 99", _LAST_OUTPUT, '<Unknown index="99" dependencies=""/>'),
    _before("structure.unique", "an output twice", _LAST_OUTPUT, _COUNT_OUTPUT),
    _swap("structure.outputs-complete", "an output not listed", _COUNT_OUTPUT, ""),
    _before(
        "structure.outputs-only", "an input among the outputs", _LAST_OUTPUT, '<Unknown index="4" dependencies=""/>'
    ),
    _before("structure.derivative", "no derivative", _LAST_DERIVATIVE, '<Unknown index="12" dependencies=""/>'),
    _before(
        "structure.state",
        "an input that is a state",
        _LAST_DERIVATIVE,
        '<Unknown index="13" dependencies=""/>',
        'unit="m" displayUnit="cm" nominal="1"',
        'derivative="4"',
    ),
    _swap("structure.initial-complete", "an initial unknown not listed", _TAU_INITIAL, ""),
    _before(
        "structure.initial-only",
        "an exact unknown",
        _LAST_INITIAL,
        '<Unknown index="16" dependencies=""/>',
        _LAST_VARIABLE,
        _TYPED.format("p", '<Real start="1"/>') + _LAST_VARIABLE,
    ),
    _swap("structure.initial-order", "out of order", _TAU_INITIAL, "", _LAST_INITIAL, _TAU_INITIAL + _LAST_INITIAL),
    _swap(
        "dependency.index",
        "a dependency on variable 99",
        _Y_OUTPUT,
        'index="13" dependencies="2 4 99" dependenciesKind="tunable constant dependent"',
    ),
    _swap(
        "dependency.order",
        "dependencies out of order",
        _Y_OUTPUT,
        'index="13" dependencies="4 2" dependenciesKind="constant tunable"',
    ),
    _swap(
        "dependency.unique",
        "a dependency twice",
        _Y_OUTPUT,
        'index="13" dependencies="2 4 4" dependenciesKind="tunable constant constant"',
    ),
    _swap("dependency.kind-count", "a kind too many", '"tunable constant"', '"tunable constant fixed"'),
    _swap("dependency.kind-count", "kinds alone", _Y_OUTPUT, 'index="13" dependenciesKind="tunable constant"'),
    _swap("dependency.initial-kind", "a fixed initial dependency", "t constant dependent", "t fixed dependent"),
    _swap("dependency.kind-real", "a factor on a Boolean", '"fixed tunable dependent"', '"fixed tunable constant"'),
    _swap(
        "dependency.known",
        "an output that depends on an output",
        _Y_OUTPUT,
        'index="13" dependencies="2 4 8" dependenciesKind="tunable constant dependent"',
    ),
    # What naive importers do not bear: the correct FMU has the first two
    _swap("naive.non-real-output", "outputs of all types"),
    _swap("naive.needs-inputs", "outputs that depend on inputs at once"),
    _swap("naive.unit-name", "a unit with a root", '<Unit name="1/s">', '<Unit name="sqrt(s-2)">', 'unit="1/s"',
          'unit="sqrt(s-2)"'),
    _swap("dependency.missing", "an output without dependencies", _COUNT_OUTPUT, '<Unknown index="8"/>'),
)
