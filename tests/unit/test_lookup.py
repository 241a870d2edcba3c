"""m.interpolate: exact at the points, straight in between, the same doubles on floats and on symbols."""
import math
import random

import casadi
import numpy as np
import pytest

from fmus import floats, symbols

POINTS, VALUES = [-1.0, 0.5, 2.0, 2.25], [3.0, -1.0, 4.0, 0.3]


@pytest.fixture(params=[False, True])
def extrapolate(request):
    return request.param


def traced(extrapolate):
    x, y = casadi.SX.sym("x"), casadi.SX.sym("y", len(VALUES))
    result = symbols.interpolate(x, POINTS, casadi.vertsplit(y), extrapolate)
    return casadi.Function("table", [x, y], [result, casadi.jacobian(result, x)])


def test_points_are_met_exactly(extrapolate):
    assert [floats.interpolate(x, POINTS, VALUES, extrapolate) for x in POINTS[:-1]] == VALUES[:-1]
    assert floats.interpolate(POINTS[-1], POINTS, VALUES, extrapolate) == pytest.approx(VALUES[-1], rel=1e-15)
    assert floats.interpolate(POINTS[-1], POINTS, VALUES) == VALUES[-1]


def test_between_points_it_is_numpys():
    for x in np.linspace(-3, 4, 501):
        found = floats.interpolate(x, POINTS, VALUES)
        assert found == pytest.approx(np.interp(x, POINTS, VALUES), rel=1e-13, abs=1e-14)


def test_beyond_the_ends_it_is_held_or_goes_on_straight():
    assert floats.interpolate(-5.0, POINTS, VALUES) == 3.0 and floats.interpolate(9.0, POINTS, VALUES) == 0.3
    assert floats.interpolate(-2.5, POINTS, VALUES, extrapolate=True) == pytest.approx(7.0)
    assert floats.interpolate(2.5, POINTS, VALUES, extrapolate=True) == pytest.approx(-3.4)


def test_symbols_give_the_very_doubles(extrapolate):
    table, rng = traced(extrapolate), random.Random(1)
    for x in [*POINTS, *(rng.uniform(-2, 3) for _ in range(300))]:
        assert float(table(x, VALUES)[0]) == floats.interpolate(x, POINTS, VALUES, extrapolate)
    assert math.isnan(floats.interpolate(math.nan, POINTS, VALUES)) and math.isnan(float(table(math.nan, VALUES)[0]))


def test_its_slope_is_that_of_the_line(extrapolate):
    table = traced(extrapolate)
    assert [float(table(x, VALUES)[1]) for x in (0.0, 1.0, 2.1)] == pytest.approx([-8 / 3, 10 / 3, -14.8])
    assert float(table(5.0, VALUES)[1]) == pytest.approx(-14.8 if extrapolate else 0.0)


@pytest.mark.parametrize("points, values, told", [
    ([0.0, 0.0], [1.0, 2.0], r"the points of a lookup table are numbers that increase, not \[0.0, 0.0\]"),
    ([1.0, 0.0], [1.0, 2.0], "numbers that increase"),
    ([casadi.SX.sym("p"), 1.0], [1.0, 2.0], "numbers that increase"),
    ([0.0], [1.0], "at least two points and a value for each, not 1 and 1"),
    ([0.0, 1.0], [1.0], "at least two points and a value for each, not 2 and 1")])
def test_what_is_no_table_is_refused(points, values, told):
    for backend in (floats, symbols):
        with pytest.raises(ValueError, match=told):
            backend.interpolate(0.5, points, values)
