"""Exact steps of the linear parts of the control law."""
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from ahv_ctrl_fmu.differentiator import (
    differentiator_rate,
    differentiator_step,
    differentiator_transition,
    filter_rate,
    filter_step,
    filter_transition,
)
from ahv_ctrl_fmu.linear import exponential

PRINTED, STABLE = (0.5, 0.1, 0.5, 0.1), (1.0, 4.0, 6.0, 4.0)


@given(st.lists(st.floats(-20, 20), min_size=16, max_size=16))
def test_exponential_equals_scipys(entries):
    a = np.array(entries).reshape(4, 4)
    expected = expm(a)
    assert np.allclose(exponential(a.tolist()), expected, rtol=1e-9, atol=1e-11 * np.abs(expected).max())


@pytest.mark.parametrize("a", [PRINTED, STABLE])
@pytest.mark.parametrize("R", [0.05, 10.0, 60.0])
def test_differentiator_step_is_exact_behind_a_ramp(R, a):
    chi, h, first, last = [0.3, -0.2, 5.0, 1.0], 0.05, 0.1, 0.4
    stepped = differentiator_step(differentiator_transition(R, a, h), chi, first, last, h, R, a)
    exact = solve_ivp(lambda t, x: differentiator_rate(x, first + (last - first) * t / h, R, a), (0, h), chi,
                      method="DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
    scale = np.array([1, R, R**2, R**3]) + np.abs(exact)
    assert np.max(np.abs(stepped - exact) / scale) < 1e-11


@pytest.mark.parametrize("R", [300.0, 1000.0])
def test_a_stable_differentiator_stays_stable_at_steps_far_beyond_its_time_constant(R):
    h, chi = 0.05, [1.0, 0.0, 0.0, 0.0]
    transition = differentiator_transition(R, STABLE, h)
    for _ in range(100):
        chi = differentiator_step(transition, chi, 0.0, 0.0, h, R, STABLE)
    assert np.max(np.abs(chi)) < 1e-12


def test_filter_step_is_exact_behind_a_ramp():
    r, h, first, last = [1.0, -2.0], 0.5, 3.0, 4.0
    stepped = filter_step(filter_transition(4.8, 0.7, h), r, first, last, h, 4.8, 0.7)
    exact = solve_ivp(lambda t, x: filter_rate(x, first + (last - first) * t / h, 4.8, 0.7), (0, h), r,
                      method="DOP853", rtol=1e-13, atol=1e-13).y[:, -1]
    assert np.allclose(stepped, exact, rtol=1e-11, atol=1e-12)
