"""Units in SI base units: factors known from elsewhere, and what is no unit."""
import pytest

from fmus.units import SYMBOLS, per_second, si_base

FT, SLUG, LBF = 0.3048, 14.593902937206365, 4.4482216152605005  # m, kg, N


@pytest.mark.parametrize(("unit", "factor", "exponents"), [
    ("1", 1.0, {}),
    ("1/s3", 1.0, {"s": -3}),
    ("1/ft2", FT**-2, {"m": -2}),
    ("s2/rad2", 1.0, {"s": 2, "rad": -2}),
    ("ft/s2", FT, {"m": 1, "s": -2}),
    ("slug/ft3", SLUG / FT**3, {"kg": 1, "m": -3}),
    ("slug.ft", SLUG * FT, {"kg": 1, "m": 1}),
    ("lbf", LBF, {"kg": 1, "m": 1, "s": -2}),
    ("lbf/ft2", LBF / FT**2, {"kg": 1, "m": -1, "s": -2}),
    ("N.m/s", 1.0, {"kg": 1, "m": 2, "s": -3}),
    ("V/A", 1.0, {"kg": 1, "m": 2, "s": -3, "A": -2}),
    ("Pa.ft2", FT**2, {"kg": 1, "m": 1, "s": -2}),
    ("J/N", 1.0, {"m": 1}),
    ("W/Hz", 1.0, {"kg": 1, "m": 2, "s": -2}),
    ("K.mol.cd", 1.0, {"K": 1, "mol": 1, "cd": 1}),
    ("deg", 0.017453292519943295, {"rad": 1}),
    ("ft.s-2", FT, {"m": 1, "s": -2}),
    ("slug.ft^2/s^3", SLUG * FT**2, {"kg": 1, "m": 2, "s": -3}),
    ("ft.s^-2", FT, {"m": 1, "s": -2}),
])
def test_factor_and_exponents(unit, factor, exponents):
    found = si_base(unit)
    assert found[0] == pytest.approx(factor, rel=1e-15) and found[1] == exponents


@pytest.mark.parametrize("text", ["", "furlong", "1/furlong", "ft/", "/ft", "ft//s", "ft s", "ft^", "ft^1.5", "ft**2",
                                  "2", "(ft)", "m1.5", "sqrt(ft2)", "ft\n", "ft2s"])
def test_what_is_no_unit_is_refused_with_the_rule(text):
    with pytest.raises(ValueError, match=r"is not known; a unit is 1 or made of kg, .* such as slug\.ft/s\^2 or 1/s$"):
        si_base(text)


@pytest.mark.parametrize(("unit", "factor"), [
    ("mm", 1e-3), ("kPa", 1e3), ("km/h", 1 / 3.6), ("MW", 1e6), ("uF", 1e-6), ("mA.h", 3.6), ("L/min", 1e-3 / 60),
    ("Mg", 1e3), ("cd", 1.0), ("min", 60.0), ("h", 3600.0), ("d", 86400.0), ("t", 1e3), ("rpm", 0.10471975511965977),
    ("psi", 6894.757293168362), ("hp", 745.6998715822702), ("knot", 1852 / 3600), ("mph", 0.44704), ("atm", 101325.0)])
def test_prefixes_and_further_units(unit, factor):
    assert si_base(unit)[0] == pytest.approx(factor, rel=1e-14)


@pytest.mark.parametrize("text", ["mmin", "kkg", "mkg", "kft", "kmm", "degC"])
def test_a_prefix_stands_once_and_before_metric_units_only(text):
    with pytest.raises(ValueError, match="is not known"):
        si_base(text)


def test_a_model_has_units_of_its_own():
    own = {"furlong": (220, "yd"), "fortnight": (14, "d")}
    assert si_base("furlong/fortnight", own) == (pytest.approx(201.168 / 1209600, rel=1e-15), {"m": 1, "s": -1})
    with pytest.raises(ValueError, match="'furlong' is not known"):
        si_base("furlong")


def test_every_symbol_is_a_unit():
    assert all(si_base(symbol) for symbol in SYMBOLS)


@pytest.mark.parametrize("unit, rate", [
    ("1", "1/s"), ("ft", "ft/s"), ("ft/s", "ft/s^2"), ("slug.ft/s^2", "slug.ft/s^3"), ("rad/s3", "rad/s^4"),
    ("1/s", "1/s^2"), ("lbf/slug", "lbf/slug/s"), ("rad.s", "rad"), ("s", "1")])
def test_the_unit_of_a_rate_is_the_units_per_second(unit, rate):
    assert per_second(unit) == rate
    (size, base), (rate_size, rate_base) = si_base(unit), si_base(rate)
    assert rate_size == pytest.approx(size, rel=1e-15)
    assert {**rate_base, "s": rate_base.get("s", 0) + 1} == {**base, "s": base.get("s", 0)}


def test_a_temperature_with_a_zero_elsewhere_is_refused():
    with pytest.raises(ValueError, match="'degC' is not known, for its zero is not that of K; give temperatures in K"):
        si_base("W/degC")
