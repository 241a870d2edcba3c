"""What is known before a step is taken out of it, and the numbers stay what they were."""
from dataclasses import replace

import casadi
import numpy as np
import pytest

from fmus.hoist import entries, hoist, hoisted
from fmus.trace import Trace

t, h = casadi.SX.sym("t"), casadi.SX.sym("h")
x, u, p, c = (casadi.SX.sym(name, n) for name, n in (("x", 2), ("u", 2), ("p", 3), ("c", 1)))


@pytest.fixture(scope="module")
def trace():
    """A model with parts that parameters, the step, or inputs decide, and divisions by them."""
    decay = casadi.if_else(p[0] > 0, casadi.exp(-p[0] * h), 1.0)
    later = casadi.vertcat(x[0] * decay + c[0] * casadi.sin(u[0]) / p[1], x[1] + h * x[0] * casadi.sqrt(p[2]) / u[1])
    y = casadi.vertcat(later[0] * 0 + x[0] / p[1], casadi.cos(x[1]) + casadi.log(p[2]), t)
    names = {"p": p, "h": h, "t": t, "x": x, "u": u, "c": c}

    def function(name, of, result):
        return casadi.Function(name, [names[key] for key in of], [result], list(of), ["result"])

    return Trace(function("prepare", "ph", p[0] / h), function("start", "up", casadi.vertcat(u[0], p[1])),
                 function("advance", "thxupc", later), function("outputs", "txup", y),
                 function("derivative", "txup", casadi.vertcat(x[1] / p[1], casadi.exp(p[0]) * u[0])))


def words(function):
    return str(function.expand().call(function.sx_in()) if function.n_instructions() else "")


def equal(found, expected):
    assert np.array(found) == pytest.approx(np.array(expected), rel=1e-14, abs=1e-14)


def test_the_numbers_are_those_of_the_trace(trace):
    own, random = hoisted(trace, trace.derivative), np.random.default_rng(3)
    for _ in range(50):
        at, step, end = random.uniform(0.1, 2, 3)
        X, U, P = random.uniform(-2, 2, 2), random.uniform(0.5, 2, 2), random.uniform(0.5, 2, 3)
        k = own.constants(P)
        prepared = own.prepare(P, step, k)
        before = (at, step, X, U, P, k, prepared, own.hold(step, U, P, k, prepared))
        later = trace.advance(at, step, X, U, P, trace.prepare(P, step))
        found, y = own.finish(*before, end)
        equal(own.advance(*before), later)
        equal(found, later)
        equal(y, trace.outputs(end, later, U, P))
        equal(own.outputs(at, X, U, P, k), trace.outputs(at, X, U, P))
        equal(own.derivative(at, X, U, P, k), trace.derivative(at, X, U, P))


def test_nothing_that_is_known_before_a_step_is_computed_in_it(trace):
    own = hoisted(trace, trace.derivative)
    in_step = words(own.advance) + words(own.finish)
    assert not any(word in in_step for word in ("exp", "sqrt", "log", "sin", "/", "?"))
    assert "cos" in in_step and "exp" not in words(own.derivative)
    assert "sin" in words(own.hold) and "exp" in words(own.prepare) and "sqrt" in words(own.constants)


def test_what_is_known_is_taken_out_once_and_divisions_become_products():
    results, symbols, parts = hoist([casadi.vertcat(x[0] / p[0], x[1] / p[0], x[0] / 4, p[1]),
                                     casadi.exp(p[1]) * x[0] + casadi.exp(p[1])], entries(p), "k")
    assert str(parts) == "[(1./p_0), exp(p_1)]" and symbols.numel() == 2
    assert str(results[0]) == "[(x_0*k0), (x_1*k0), (0.25*x_0), p_1]"
    assert str(results[1]) == "((k1*x_0)+k1)"


def test_outputs_are_taken_along_where_they_cost_next_to_nothing(trace):
    assert hoisted(trace, trace.derivative).advances_apart
    state = x
    for _ in range(50):
        state = casadi.sin(state)
    long = casadi.Function("advance", [t, h, x, u, p, c], [state])
    shown = casadi.Function("outputs", [t, x, u, p], [x])
    assert not hoisted(replace(trace, advance=long, outputs=shown), trace.derivative).advances_apart
