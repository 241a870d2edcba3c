"""Units by their definitions, differences, and numbers with units in words."""
import pytest

from cosim.errors import UsageError
from cosim.master.description import usable
from cosim.master.quantities import Unit, conversion, in_unit_of, unit

METRE, SECOND, KELVIN = {"m": "1"}, {"s": "1"}, {"K": "1"}
KM = unit("km", METRE | {"factor": "1000"})
M = unit("m", METRE)
K = unit("K", KELVIN)
DEG_C = unit("degC", KELVIN | {"offset": "273.15"})
DEG_F = unit("degF", KELVIN | {"factor": "0.5555555555555556", "offset": "255.3722222222222"})


@pytest.mark.parametrize("source,target,expected,of_a_difference", [
    (KM, M, (1000, 0), (1000, 0)), (M, KM, (0.001, 0), (0.001, 0)), (M, M, (1, 0), (1, 0)),
    (DEG_C, K, (1, 273.15), (1, 0)), (K, DEG_C, (1, -273.15), (1, 0)),
    (DEG_F, DEG_C, (5 / 9, -160 / 9), (5 / 9, 0)), (DEG_C, DEG_F, (1.8, 32), (1.8, 0)),
    (Unit("m"), M, (1, 0), (1, 0)), (Unit("odd"), Unit("odd"), (1, 0), (1, 0)),
])
def test_factor_and_offset(source, target, expected, of_a_difference):
    assert conversion(source, target) == pytest.approx(expected)
    assert conversion(source, target, relative=True) == pytest.approx(of_a_difference)


@pytest.mark.parametrize("source,target", [
    (M, K), (M, unit("s", SECOND)), (Unit("m"), KM), (Unit("odd"), Unit("strange")), (M, unit("m", SECOND)),
    (M, unit("m2", {"m": "2"}))])
def test_what_measures_something_else_is_not_converted(source, target):
    assert conversion(source, target) is None and conversion(target, source, relative=True) is None


def test_units_of_one_name_are_compared_by_their_definitions():
    own = unit("foot", METRE | {"factor": "0.3048"})
    other = unit("foot", METRE | {"factor": "0.3"})
    assert conversion(own, other) == (pytest.approx(1.016), 0)
    warm = unit("deg", KELVIN | {"offset": "273.15"})
    assert conversion(warm, unit("deg", KELVIN | {"offset": "255"})) == (1, pytest.approx(18.15))


def test_definitions_that_differ_by_rounding_are_one_unit():
    exact, rounded = (unit("deg", {"rad": "1", "factor": f}) for f in ("0.017453292519943295", "0.0174532925199"))
    assert conversion(exact, rounded) == (1.0, 0.0)
    assert conversion(exact, unit("deg", {"rad": "1", "factor": "0.01745329"})) != (1.0, 0.0)


@pytest.mark.parametrize("base", [{"m": "1", "factor": "0"}, {"m": "1", "factor": "INF"}, {"m": "1", "factor": "x"},
                                  {"m": "1", "offset": "NaN"}, {"m": "one"}, None])
def test_a_definition_that_cannot_be_used_is_none(base):
    found = unit("u", base)
    assert (found.factor, found.offset, found.exponents) == (1.0, 0.0, None)


def test_every_base_unit_has_its_place():
    for place, part in enumerate(("kg", "m", "s", "A", "K", "mol", "cd", "rad")):
        assert unit("u", {part: "-2"}).exponents == (*[0] * place, -2, *[0] * (7 - place))


def test_a_unit_as_messages_show_it():
    assert str(DEG_C) == "degC (1 K1 + 273.15)"
    assert str(unit("N", {"kg": "1", "m": "1", "s": "-2"})) == "N (1 kg1 m1 s-2)"
    assert str(Unit("odd")) == "odd (not defined)" and str(unit("1", {})) == "1 (1 1)"


DESCRIPTION = usable(b"""<fmiModelDescription fmiVersion="2.0"><UnitDefinitions>
<Unit name="K"><BaseUnit K="1"/><DisplayUnit name="mK" factor="1000"/><DisplayUnit name="degC" offset="-273.15"/>
<DisplayUnit name="none" factor="0"/></Unit>
<Unit name="degF"><BaseUnit K="1" factor="0.5" offset="255"/><DisplayUnit name="half" factor="2" offset="1"/></Unit>
<Unit name="m"><BaseUnit m="1"/></Unit>
<Unit name="m/s^2"><BaseUnit m="1" s="-2"/></Unit></UnitDefinitions><TypeDefinitions>
<SimpleType name="Difference"><Real unit="K" relativeQuantity="true"/></SimpleType></TypeDefinitions><ModelVariables>
<ScalarVariable name="T" valueReference="0"><Real unit="K"/></ScalarVariable>
<ScalarVariable name="dT" valueReference="1"><Real declaredType="Difference"/></ScalarVariable>
<ScalarVariable name="x" valueReference="2"><Real/></ScalarVariable>
<ScalarVariable name="n" valueReference="3"><Integer/></ScalarVariable>
<ScalarVariable name="odd" valueReference="4"><Real unit="odd"/></ScalarVariable>
<ScalarVariable name="a" valueReference="5"><Real unit="m/s^2"/></ScalarVariable>
</ModelVariables></fmiModelDescription>""")


@pytest.mark.parametrize("name,text,expected", [
    ("T", "300 K", 300), ("T", "10degC", 283.15), ("T", "5000 mK", 5), ("T", "10 degF", 260), ("T", "3 half", 255.5),
    ("dT", "10 degC", 10), ("dT", "5000 mK", 5), ("dT", "10 degF", 5), ("dT", "3 half", 0.75), ("dT", "1e1 degC", 10),
    ("odd", "4 odd", 4), ("T", "-1.5", -1.5), ("a", "9.8 m/s^2", 9.8), ("a", "9.8 m/s2", 9.8)])
def test_a_number_with_a_unit(name, text, expected):
    variable = next(v for v in DESCRIPTION.variables if v.name == name)
    assert float(in_unit_of(variable, DESCRIPTION, text, "a")) == pytest.approx(expected)


@pytest.mark.parametrize("name,text,sentence", [
    ("T", "3 m", r"a = 3 m is not allowed: its unit is one of K, mK, degC, degF, half\."),
    ("T", "3 none", "its unit is one of"), ("x", "3 m", "the FMU declares no unit for it"),
    ("odd", "3 m", r"its unit is one of odd\.")])
def test_another_unit_is_refused(name, text, sentence):
    variable = next(v for v in DESCRIPTION.variables if v.name == name)
    with pytest.raises(UsageError, match=sentence):
        in_unit_of(variable, DESCRIPTION, text, "a")


def test_a_whole_number_has_no_unit():
    variable = next(v for v in DESCRIPTION.variables if v.name == "n")
    assert in_unit_of(variable, DESCRIPTION, "3 m", "a") == "3 m"
