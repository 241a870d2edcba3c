"""Exact steps of the linear parts of the control law."""
from decimal import Decimal, localcontext
from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from oracle import starts
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from ahv_ctrl_fmu import backstepping_model, neural_model
from ahv_ctrl_fmu.differentiator import (
    differentiator_rate,
    differentiator_step,
    differentiator_transition,
    filter_rate,
    filter_step,
    filter_transition,
)
from ahv_ctrl_fmu.linear import exponential
from fmus import floats

PRINTED, STABLE = (0.5, 0.1, 0.5, 0.1), (1.0, 4.0, 6.0, 4.0)


@given(st.lists(st.floats(-20, 20), min_size=16, max_size=16))
def test_exponential_equals_scipys(entries):
    a = np.array(entries).reshape(4, 4)
    expected = expm(a)
    assert np.allclose(exponential(floats, a.tolist()), expected, rtol=1e-9, atol=1e-11 * np.abs(expected).max())


def exact(a):
    """exp(a) by scaling, series and squaring in 90 digits."""
    with localcontext() as context:
        context.prec = 90
        n, squarings = len(a), 40
        scaled = [[Decimal(float(entry)) / 2**squarings for entry in row] for row in a]

        def times(left, right):
            return [[sum(x * y for x, y in zip(row, column)) for column in zip(*right)] for row in left]

        result = [[Decimal(int(i == j)) for j in range(n)] for i in range(n)]
        term = result
        for k in range(1, 12):
            term = [[entry / k for entry in row] for row in times(term, scaled)]
            result = [[x + y for x, y in zip(*rows)] for rows in zip(result, term)]
        for _ in range(squarings):
            result = times(result, result)
        return np.array(result, dtype=float)


def companion(k, a1, a2, a3, a4):
    return [[0, k, 0, 0], [0, 0, k, 0], [0, 0, 0, k], [-a1 * k, -a2 * k, -a3 * k, -a4 * k]]


@pytest.mark.parametrize("a", [
    *([[0, k], [-k, -2 * damping * k]] for k in (1e-9, 0.3, 900, 1000) for damping in (0, 0.7, 1)),
    *(companion(k, *a) for k in (1e-9, 0.7, 12, 50, 100) for a in (PRINTED, STABLE)),
    *(companion(100, *a) for a in product((1e-6, 100), (0, 100), (0, 100), (0, 100))),
], ids=str)
def test_exponential_is_as_exact_as_it_says(a):
    expected = exact(a)
    assert np.abs(exponential(floats, a) - expected).max() < 1e-12 * max(1, np.abs(expected).max())


@pytest.mark.parametrize("model", [neural_model, backstepping_model], ids=lambda model: model.NAME)
def test_transitions_are_finite_at_the_ends_of_the_table(model):
    """Every parameter of a filter at its least or largest, and the internal step too."""
    start = starts(model, "parameter")
    filters = [row for row in model.VARIABLES
               if row[0] in {"R", "R_d", "a1", "a2", "a3", "a4", "elevator_bandwidth", "elevator_damping",
                             "reference_omega", "reference_zeta", "R_gamma", "R_theta", "R_Q", "internal_step"}]
    assert len(filters) >= 6
    for ends in product((4, 5), repeat=len(filters)):
        for row, end in zip(filters, ends):
            setattr(start, row[0], row[end])
        assert np.isfinite(model.prepare(floats, start, start.internal_step)).all(), vars(start)


@pytest.mark.parametrize("a", [PRINTED, STABLE])
@pytest.mark.parametrize("R", [0.05, 10.0, 60.0])
def test_differentiator_step_is_exact_behind_a_ramp(R, a):
    chi, h, first, last = [0.3, -0.2, 5.0, 1.0], 0.05, 0.1, 0.4
    stepped = differentiator_step(differentiator_transition(floats, R, a, h), chi, first, last, h, R, a)
    exact = solve_ivp(lambda t, x: differentiator_rate(x, first + (last - first) * t / h, R, a), (0, h), chi,
                      method="DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
    scale = np.array([1, R, R**2, R**3]) + np.abs(exact)
    assert np.max(np.abs(stepped - exact) / scale) < 1e-11


@pytest.mark.parametrize("R", [300.0, 1000.0])
def test_a_stable_differentiator_stays_stable_at_steps_far_beyond_its_time_constant(R):
    h, chi = 0.05, [1.0, 0.0, 0.0, 0.0]
    transition = differentiator_transition(floats, R, STABLE, h)
    for _ in range(100):
        chi = differentiator_step(transition, chi, 0.0, 0.0, h, R, STABLE)
    assert np.max(np.abs(chi)) < 1e-12


def test_filter_step_is_exact_behind_a_ramp():
    r, h, first, last = [1.0, -2.0], 0.5, 3.0, 4.0
    stepped = filter_step(filter_transition(floats, 4.8, 0.7, h), r, first, last, h, 4.8, 0.7)
    exact = solve_ivp(lambda t, x: filter_rate(x, first + (last - first) * t / h, 4.8, 0.7), (0, h), r,
                      method="DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
    assert np.allclose(stepped, exact, rtol=1e-11, atol=1e-12)
