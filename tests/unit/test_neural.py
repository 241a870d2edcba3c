"""The neural law: its start, its step, and the equations it must keep."""
from decimal import Decimal, localcontext
from math import radians
from types import SimpleNamespace

import casadi
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oracle import starts
from scipy.integrate import solve_ivp

import ahv_ctrl_fmu.neural as law
import ahv_ctrl_fmu.neural_model as controller
from fmus import floats, symbols

AWAKE = {"lambda_1": 5.0, "lambda_2": 1e5, "net1_Phi0_min": -3.0, "net1_Phi0_max": 27.0,
         "net1_Phi0_width": 7.0, "net1_V_width": 230.0, "net2_gamma_width": 0.01, "net2_theta_width": 0.02,
         "net2_Q_width": 0.04, "net2_delta0_width": 0.08}

UNLIMITED = {"elevator_min": -1.5, "elevator_max": 1.5, "fuel_ratio_min": -9.0, "fuel_ratio_max": 9.0}
LEVEL = radians(1.6325)


def measured(V=7700.0, h=85000.0, gamma=0.0, theta=LEVEL, Q=0.0, V_command=7900.0, h_command=85800.0):
    return SimpleNamespace(V=V, h=h, gamma=gamma, theta=theta, Q=Q, V_command=V_command, h_command=h_command)


@given(V=st.floats(7500, 10000), h=st.floats(80000, 100000), gamma=st.floats(-0.05, 0.05),
       theta=st.floats(-0.1, 0.1), Q=st.floats(-0.1, 0.1), preset=st.sampled_from(sorted(controller.PRESETS)))
def test_starts_bumpless_wherever_it_is_engaged(V, h, gamma, theta, Q, preset):
    p = starts(controller, "parameter", solve_trim=False, fuel_ratio_trim=0.3, elevator_trim=0.2,
               **controller.PRESETS[preset])
    u = measured(V, h, gamma, theta, Q)
    sent = law.outputs(floats, 0.0, law.start(floats, u, p), u, p)
    assert sent["fuel_ratio"] == pytest.approx(0.3, rel=1e-9)
    assert sent["elevator"] == pytest.approx(0.2, rel=1e-6)


@settings(max_examples=10, deadline=None)
@given(V=st.floats(-3, 3), h=st.floats(-5, 5), gamma=st.floats(-0.002, 0.002), Q=st.floats(-0.005, 0.005))
def test_the_step_converges_to_the_law_in_continuous_time(V, h, gamma, Q):
    p = starts(controller, "parameter", elevator_bandwidth=5.0, **AWAKE, **UNLIMITED)
    start = law.start(floats, measured(), p)
    u = measured(7700 + V, 85000 + h, gamma, LEVEL + gamma, Q)
    exact = solve_ivp(lambda t, x: [*law.derivative(floats, t, list(x), u, p), 0.0], (0, 0.04), start,
                      method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
    errors = []
    for count in (32, 128):
        length = 0.04 / count
        c, x = law.prepare(floats, p, length), start
        for _ in range(count):
            x = law.advance(floats, 0.0, length, x, u, p, c)
        errors.append(np.abs(np.array(x) - exact) / (1e-3 + np.abs(exact)))
    assert errors[1].max() < 1e-3
    assert errors[1].max() < errors[0].max() / 8 + 1e-9  # second order: a sixteenth


def test_the_integrals_freeze_while_their_channel_saturates():
    p = starts(controller, "parameter")
    x = law.start(floats, measured(), p)
    u = measured(V=7000.0, h=80000.0)
    rate = law.unpack([*law.derivative(floats, 0.0, x, u, p), 0.0])
    sent = law.outputs(floats, 0.0, x, u, p)
    assert sent["fuel_ratio_saturated"] and sent["fuel_ratio"] == p.fuel_ratio_max and rate.V_integral == 0
    assert sent["elevator_saturated"] and abs(sent["elevator"]) == p.elevator_max and rate.e_integral == 0


def test_printed_preset_is_the_papers():
    p = starts(controller, "parameter", **controller.PRESETS["printed"])
    assert (p.kV, p.kV1, p.kV2, p.k_gamma, p.kh, p.kh1, p.mu) == (0.9, 0.2, 0.8, 2, 0.9, 50, 7)
    assert (p.lambda_1, p.lambda_2, p.R, p.R_d, p.a1, p.a2, p.a3, p.a4) == (0.05, 0.05, 0.05, 0.05, 0.5, 0.1, 0.5, 0.1)
    assert (p.net1_V_min, p.net1_V_max, p.net1_V_width) == (7700, 8700, 33.33)
    assert (p.net2_delta0_min, p.net2_delta0_max, p.net2_delta0_width) == (0, 0.35, 0.0117)
    assert p.elevator_bandwidth == 0 and p.direction == 1 and p.c_theta == p.c_Q == 0


@given(value=st.floats(-2, 2), other=st.floats(-2, 2))
def test_activation_is_the_sum_over_twenty_nodes_on_the_diagonal(value, other):
    centres = np.linspace([-1, 0], [1, 2], 20)
    h = np.exp(-(((value - centres[:, 0]) / 0.3)**2 + ((other - centres[:, 1]) / 0.4)**2) / 2)       # (10), (11)
    found = law.activation(floats, ((value, -1, 1, 0.3), (other, 0, 2, 0.4)))
    assert found == pytest.approx(h @ h, rel=1e-9, abs=1e-12)


def summed(dimensions):
    """`activation` node by node, to 40 digits."""
    with localcontext() as context:
        context.prec = 40
        exact = [[Decimal(number) for number in row] for row in dimensions]
        squares = [sum(((value - low - j * (high - low) / (law.NODES - 1)) / width)**2
                       for value, low, high, width in exact) for j in range(law.NODES)]
        return sum((-square).exp() for square in squares)


@pytest.fixture(scope="module")
def traced_activation():
    row = casadi.SX.sym("row", 4, 2)
    dimensions = [casadi.vertsplit(row[:, i]) for i in (0, 1)]
    return casadi.Function("activation", [row], [law.activation(symbols, dimensions)])


ROW = st.tuples(st.floats(-1, 1), st.sampled_from([0.0, 1e-6, 1e-3, 0.3, 1.0, 30.0, -1.0, 1e6]), st.floats(-0.6, 1.6),
                st.floats(-4, 4), st.sampled_from([1e-3, 0.03, 1.0, 300.0]))


@settings(max_examples=300, deadline=None)
@given(rows=st.tuples(ROW, ROW))
def test_activation_is_as_exact_as_its_offsets_wherever_the_input_is(traced_activation, rows):
    """Its relative error is 1e-14, where nodes and input are no more than a few widths apart; further apart the
    squared distance itself, rounded, has a larger one."""
    dimensions = [(low + place * span + beside * width, low, low + span, width)
                  for low, span, place, beside, width in rows]
    reach = max(max(abs(value - low), abs(high - low)) / width for value, low, high, width in dimensions)
    exact = float(summed(dimensions))
    for found in (law.activation(floats, dimensions), float(traced_activation(np.transpose(dimensions)))):
        assert found == pytest.approx(exact, rel=1e-14 + 1e-15 * (reach * reach + reach), abs=1e-290)


@given(value=st.floats(allow_nan=False, allow_infinity=False), other=st.floats(allow_nan=False, allow_infinity=False),
       width=st.floats(1e-6, 1e6), span=st.floats(-1e6, 1e6))
def test_activation_is_a_number_for_every_number(traced_activation, value, other, width, span):
    dimensions = ((value, 0.0, span, width), (other, -1.0, 1.0, width))
    for found in (law.activation(floats, dimensions), float(traced_activation(np.transpose(dimensions)))):
        assert 0 <= found <= law.NODES
