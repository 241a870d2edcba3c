"""The fixed-step methods have the order that they are named by, on floats and on symbols, and for rates that change
with time."""
from math import exp, log2, sin

import casadi
import pytest

from fmus import floats, symbols
from fmus.integrators import METHODS, integrate


def rate(m):
    """x' = -x cos t with a second state; x(t) = exp(-sin t) x(0)."""
    return lambda t, x: [-x[0] * m.cos(t), m.cos(t) * m.exp(-m.sin(t))]


def error(order, steps):
    x, h = [1.0, 0.0], 1.5 / steps
    for k in range(steps):
        x = integrate(rate(floats), k * h, x, h, order)
    return abs(x[0] - exp(-sin(1.5))) + abs(x[1] - (1 - exp(-sin(1.5))))


@pytest.mark.parametrize("order", METHODS)
def test_a_method_has_its_order_also_in_time(order):
    found = log2(error(order, 20) / error(order, 40))
    assert found == pytest.approx(order, abs=0.35)


@pytest.mark.parametrize("order", METHODS)
def test_nodes_and_weights_agree(order):
    stages, weights = METHODS[order]
    assert sum(weights) == pytest.approx(1, rel=1e-15)
    for node, earlier in stages:
        assert sum(earlier) == pytest.approx(node, abs=1e-15)


@pytest.mark.parametrize("order", METHODS)
def test_symbols_give_the_very_numbers_of_floats(order):
    t, h, x = casadi.SX.sym("t"), casadi.SX.sym("h"), casadi.SX.sym("x", 2)
    function = casadi.Function("step", [t, x, h], [casadi.vertcat(
        *integrate(rate(symbols), t, [x[0], x[1]], h, order))])
    assert [float(a) for a in casadi.vertsplit(function(0.3, [0.7, -0.2], 0.11))] == \
        integrate(rate(floats), 0.3, [0.7, -0.2], 0.11, order)
