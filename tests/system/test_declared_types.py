"""What an FMU says of a variable by its declared type counts as what it says at the variable."""
import pytest
import small
from altered import redescribed

import cosim
from cosim.errors import RunError, UsageError
from cosim.master.fly import fly
from cosim.master.system import Component, Connection, System

UNITS = ('<UnitDefinitions><Unit name="K"><BaseUnit K="1"/><DisplayUnit name="degC" offset="-273.15"/></Unit>'
         '<Unit name="degF"><BaseUnit K="1" factor="0.5555555555555556" offset="255.3722222222222"/></Unit>'
         '</UnitDefinitions>')
UNKNOWN = '<Unknown index="16" dependencies="'
LIMITS = 'unit="K" displayUnit="degC" min="-2" max="2"'


@pytest.fixture(scope="module")
def altered(tmp_path_factory):
    """small.fmu, with attributes for the Reals a21 and y; either their own or those of a declared type."""
    folder = tmp_path_factory.mktemp("small")
    plain = small.build(folder)

    def made(name, attributes, typed, direct=False):
        types = f'<TypeDefinitions><SimpleType name="T"><Real {attributes}/></SimpleType></TypeDefinitions>'
        own = 'declaredType="T"' if typed else attributes
        output = 'name="y" valueReference="15" causality="output" variability="continuous" initial="calculated"><Real'
        swaps = [("<ModelVariables>", f"{UNITS}{types if typed else ''}<ModelVariables>"),
                 ('<Real start="-1.0"/>', f'<Real start="-1.0" {own}/>'), (output, f"{output} {own}"),
                 *([(f"{UNKNOWN}\"", f"{UNKNOWN}15\"")] if direct else [])]
        return redescribed(plain, folder / f"{name}_{typed}_{direct}.fmu", *swaps)
    return made


@pytest.mark.parametrize("typed", [False, True])
def test_values_out_of_range_are_refused(altered, typed):
    fmu = altered("limits", LIMITS, typed)
    for allowed in (-2.0, 2.0):
        assert fly(System((Component("a", fmu, {"a21": allowed}),)), 0.1, 0.5).finished
    for value, shown in ((-2.5, "-2.5"), (2.01, "2.01"), ("30 K", "30.0")):
        with pytest.raises(UsageError, match=rf"a\.a21 = {shown} is not allowed: it must be between -2 and 2 K\."):
            fly(System((Component("a", fmu, {"a21": value}),)), 0.1, 0.5)


@pytest.mark.parametrize("algorithm,direct", [("variable,tolerance=1e-4", False), ("iterated,tolerance=1e-6", True)])
def test_tolerances_are_those_of_the_nominal_value(altered, algorithm, direct):
    def flown(fmu):
        left, right = (small.oscillator(x1=x1, a21=-1.0, d=direct * d) for x1, d in ((1.0, 0.5), (-0.5, -0.4)))
        links = Connection("left.y", "right.u"), Connection("right.y", "left.u", 0.8)
        return fly(System((Component("left", fmu, left), Component("right", fmu, right)), links), 0.05, 5.0, algorithm)

    own, typed = (flown(altered("coarse", 'nominal="1000"', by_type, direct)) for by_type in (False, True))
    none = flown(altered("none", LIMITS, False, direct))
    assert own.finished and own.signals.tobytes() == typed.signals.tobytes() != none.signals.tobytes()
    assert direct or own.ticks < none.ticks


def test_initial_values_settle_to_the_nominal_value(altered):
    """A loop whose values swing between 1 and -1: of no account where 1e14 is usual."""
    def loop(fmu):
        parts = Component("a", fmu, {"d": 1.0, "x1": 1.0}), Component("b", fmu, {"d": -1.0})
        return System(parts, (Connection("a.y", "b.u"), Connection("b.y", "a.u")))

    assert fly(loop(altered("huge", 'nominal="1e14"', True, True)), 0.1, 0.5).finished
    with pytest.raises(RunError, match=r"The initial values do not settle: a\.y, b\.y"):
        fly(loop(altered("none", LIMITS, True, True)), 0.1, 0.5)


@pytest.mark.parametrize("typed", [False, True])
@pytest.mark.parametrize("relative,value,offset", [(' relativeQuantity="true"', 10 / 1.8, 0.0),
                                                   ("", 10 / 1.8 + 255.3722222222222, -273.15)])
def test_of_a_difference_offsets_of_units_do_not_count(altered, typed, relative, value, offset):
    fmu = altered(f"warm{bool(relative)}", f'unit="K" displayUnit="degC"{relative}', typed)
    flight = fly(System((Component("a", fmu, {"a21": "10 degF"}),)), 0.1, 0.2)
    assert flight.parameters["a"]["a21"] == pytest.approx(value)
    column = next(c for c in flight.columns if c.name == "a.y")
    assert (column.unit, column.display_unit) == ("K", "degC")
    assert (column.display_factor, column.display_offset) == (1.0, offset)


def test_info_and_check_read_the_same(altered):
    own, typed = (cosim.info(altered("limits", LIMITS, t))["a21"] for t in (False, True))
    assert own == typed and (typed.unit, typed.display_unit, typed.min, typed.max) == ("K", "degC", -2.0, 2.0)
    bad = redescribed(altered("limits", LIMITS, True), altered("limits", LIMITS, True).with_name("bad.fmu"),
                      ('min="-2"', 'min="-0.5"'))
    found = [f for f in cosim.check(bad, dynamic=False).findings if f.rule == "variable.start-range"]
    assert [(f.variable, f.found) for f in found] == [("a21", "start -1")]
    with pytest.raises(UsageError, match=r"must be between -0\.5 and 2 K"):
        fly(System((Component("a", bad, {"a21": -1.0}),)), 0.1, 0.5)
