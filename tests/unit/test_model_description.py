"""The one reading of modelDescription.xml: declared types, defaults, units, and what cannot be used."""
import pytest

from cosim.master.declared import Variable
from cosim.master.description import Description, read, usable
from cosim.master.fmu import settable
from cosim.master.xml_file import root_of

TYPES = """<UnitDefinitions>
  <Unit name="K"><BaseUnit K="1"/><DisplayUnit name="degC" offset="-273.15"/></Unit>
  <Unit name="km"><BaseUnit m="1" factor="1000"/></Unit><Unit name="km"><BaseUnit m="1" factor="999"/></Unit>
  <Unit name="bad"><BaseUnit m="1" factor="much"/></Unit></UnitDefinitions>
<TypeDefinitions>
  <SimpleType name="T"><Real unit="K" displayUnit="degC" min="0" max="500" nominal="300" relativeQuantity="true"/>
  </SimpleType><SimpleType name="T"><Real min="7"/></SimpleType>
  <SimpleType name="Mode"><!-- first a remark --><Enumeration><Item name="off" value="1"/><Item name="on" value="4"/>
  </Enumeration></SimpleType></TypeDefinitions>"""
VARIABLES = """<ScalarVariable name="typed" valueReference="0" description="warmth"><Real declaredType="T"/>
</ScalarVariable>
<ScalarVariable name="own" valueReference="1" causality="parameter" variability="fixed"><Real declaredType="T" unit="km"
  min="-1" max="0" nominal="2" relativeQuantity="false"/></ScalarVariable>
<ScalarVariable name="plain" valueReference="2" causality="input"><Real start="3"/></ScalarVariable>
<ScalarVariable name="mode" valueReference="3" causality="output" variability="discrete">
  <Enumeration declaredType="Mode"/></ScalarVariable>
<ScalarVariable name="strange" valueReference="4"><Real min="x" max="INF" unit="bad"/></ScalarVariable>"""
STRUCTURE = '<ModelStructure><Outputs><Unknown index="4" dependencies="1  3"/></Outputs></ModelStructure>'


def xml(types=TYPES, variables=VARIABLES, structure=STRUCTURE, version="2.0"):
    return (f'<fmiModelDescription fmiVersion="{version}" modelName="m"><CoSimulation modelIdentifier="m" '
            f'canGetAndSetFMUstate="1" canInterpolateInputs=" true " canRunAsynchronuously="false"/>{types}'
            f'<ModelVariables>{variables}</ModelVariables>{structure}</fmiModelDescription>').encode()


@pytest.fixture
def by_name():
    return {v.name: v for v in usable(xml()).variables}


def test_what_a_variable_leaves_out_is_its_declared_types(by_name):
    v = by_name["typed"]
    assert (v.unit, v.display_unit, v.min, v.max, v.nominal, v.relative) == ("K", "degC", 0.0, 500.0, 300.0, True)
    assert v.description == "warmth"


def test_what_a_variable_says_counts_before_its_declared_type(by_name):
    v = by_name["own"]
    assert (v.unit, v.display_unit, v.min, v.max, v.nominal, v.relative) == ("km", "degC", -1.0, 0.0, 2.0, False)


def test_what_nobody_says_is_none(by_name):
    v = by_name["plain"]
    assert (v.unit, v.display_unit, v.min, v.max, v.nominal, v.relative) == ("", "", None, None, None, False)
    strange = by_name["strange"]
    assert (strange.min, strange.max) == (None, None)


def test_defaults_of_causality_variability_and_initial(by_name):
    found = {name: (v.causality, v.variability, v.initial) for name, v in by_name.items()}
    assert found == {"typed": ("local", "continuous", "calculated"), "own": ("parameter", "fixed", "exact"),
                     "plain": ("input", "continuous", None), "mode": ("output", "discrete", "calculated"),
                     "strange": ("local", "continuous", "calculated")}


@pytest.mark.parametrize("causality,variability,initial", [
    ("output", "constant", "exact"), ("local", "constant", "exact"),
    ("parameter", "fixed", "exact"), ("parameter", "tunable", "exact"),
    *((causality, variability, "calculated") for causality in ("calculatedParameter", "local")
      for variability in ("fixed", "tunable")),
    *((causality, variability, "calculated") for causality in ("output", "local")
      for variability in ("discrete", "continuous")),
    ("input", "discrete", None), ("input", "continuous", None), ("independent", "continuous", None),
    ("parameter", "continuous", None)])  # which is not allowed
def test_the_default_of_initial_is_that_of_the_standards_table(causality, variability, initial):
    said = {"name": "x", "causality": causality, "variability": variability}
    assert Variable(1, said, "Real", {}).initial == initial
    assert Variable(1, said | {"initial": "approx"}, "Real", {}).initial == "approx"


def test_what_may_be_set_before_the_start():
    def said(causality, variability="continuous", **more):
        return Variable(1, {"name": "x", "causality": causality, "variability": variability, **more}, "Real", {})

    assert all(settable(said(*words)) for words in (("parameter", "fixed"), ("parameter", "tunable"), ("input",),
                                                    ("input", "discrete"), ("structuralParameter", "fixed")))
    assert settable(said("local", initial="exact")) and settable(said("output", initial="approx"))
    assert not any(settable(said(*words)) for words in (
        ("output",), ("local",), ("local", "constant"), ("calculatedParameter", "fixed"), ("independent",)))
    assert not settable(said("output", "constant", initial="exact"))


def test_items_of_an_enumeration(by_name):
    assert by_name["mode"].items == {"off": 1, "on": 4} and by_name["mode"].base == "Integer"
    assert by_name["plain"].items == {} and by_name["plain"].base == "Real"


def test_units_are_those_of_the_first_definition_of_a_name():
    found = usable(xml())
    assert found.units["km"].factor == 1000 and found.units["km"].exponents == (0, 1, 0, 0, 0, 0, 0, 0)
    assert found.units["bad"].exponents is None
    by_name = {v.name: found.unit_of(v) for v in found.variables}
    assert by_name["plain"] is None and by_name["typed"] == found.units["K"]
    display, = by_name["typed"].displays
    assert (display.name, display.factor, display.offset) == ("degC", 1.0, -273.15)


def test_a_unit_that_is_not_defined_is_known_by_its_name():
    found = usable(xml("", '<ScalarVariable name="x" valueReference="0"><Real unit="m"/></ScalarVariable>', ""))
    assert found.unit_of(found.variables[0]).name == "m" and found.unit_of(found.variables[0]).exponents is None


def test_capabilities_that_are_claimed():
    found = usable(xml())
    flags = ("canGetAndSetFMUstate", "canInterpolateInputs", "canRunAsynchronuously", "canSerializeFMUstate")
    assert [found.claims(flag) for flag in flags] == [True, True, False, False]
    assert not Description(root_of(b"<fmiModelDescription/>")).claims("canGetAndSetFMUstate")


@pytest.mark.parametrize("given,sentence", [
    (b"not XML", "is not well-formed XML"), (b'<?xml version="1.0" encoding="odd"?><a/>', "is not well-formed XML"),
    (b"<nothing/>", "is not a description of an FMU"), (b"<fmiModelDescription/>", "is not a description of an FMU"),
    (xml("", '<ScalarVariable valueReference="0"><Real/></ScalarVariable>', ""), "its variable 1 has no name"),
    (xml("", '<ScalarVariable name="x" valueReference="0"/>', ""), "its variable x has no name, no type"),
    (xml("", '<ScalarVariable name="x"><Real/></ScalarVariable>', ""), "its variable x has no name, no type"),
    (xml(types=""), "its variable typed has the declaredType T, which is not there"),
    (xml(structure='<ModelStructure><Outputs><Unknown index="6"/></Outputs></ModelStructure>'),
     "an Unknown of its Outputs refers to the variable 6"),
    (xml(structure='<ModelStructure><InitialUnknowns><Unknown index="4" dependencies="0"/></InitialUnknowns>'
                   '</ModelStructure>'), "an Unknown of its InitialUnknowns refers to the variable 0"),
])
def test_a_description_that_cannot_be_used_is_refused(given, sentence):
    with pytest.raises(ValueError, match=sentence):
        usable(given)


def test_a_folder_without_a_description_is_refused(tmp_path):
    with pytest.raises(ValueError, match=r"it has no modelDescription\.xml"):
        read(tmp_path)
    (tmp_path / "modelDescription.xml").write_bytes(xml())
    assert [v.name for v in read(tmp_path).variables] == ["typed", "own", "plain", "mode", "strange"]


def test_every_type_of_the_standard_is_read():
    types = ["Real", "Integer", "Boolean", "String", "Enumeration"]
    lines = "".join(f'<ScalarVariable name="{t}" valueReference="0"><Annotations/><{t} start="1"/></ScalarVariable>'
                    for t in types)
    found = usable(xml("", lines, "")).variables
    assert [v.type for v in found] == types and all(v.start == "1" for v in found)


def test_entities_are_not_expanded():
    bomb = b'<!DOCTYPE d [<!ENTITY a "aaaa">]>' + xml().replace(b'"warmth"', b'"&a;"').replace(
        b'<Real start="3"/>', b'<Real start="3"/>&a;')
    assert "aaaa" not in "".join(root_of(bomb).itertext())


def test_other_versions_are_read_in_the_words_of_2():
    one = usable(xml('<TypeDefinitions><Type name="T"><RealType max="9"/></Type></TypeDefinitions>',
                     '<ScalarVariable name="a" valueReference="0" causality="internal"><Real declaredType="T"/>'
                     '</ScalarVariable><ScalarVariable name="b" valueReference="1" variability="parameter">'
                     '<Real/></ScalarVariable>', "", "1.0"))
    assert [(v.causality, v.variability, v.max) for v in one.variables] == [
        ("local", "continuous", 9.0), ("parameter", "fixed", None)]
    three = usable(xml('<TypeDefinitions><Float64Type name="T" max="9"/></TypeDefinitions>',
                       '<Float64 name="a" valueReference="0" declaredType="T"/><Int8 name="b" valueReference="1"/>'
                       '<String name="c" valueReference="2" causality="parameter"><Start value="x"/></String>',
                       "", "3.0"))
    assert [(v.type, v.variability, v.max, v.start) for v in three.variables] == [
        ("Float64", "continuous", 9.0, None), ("Int8", "discrete", None, None), ("String", "fixed", None, "x")]
