"""The oracle of `ahv linearize` against difference quotients, flights and hand calculation; margins of loops."""
from importlib import import_module

import numpy as np
import pytest
from evidence import fly
from exact_linear import GROUPS, NoTrim, linear_loop, linear_vehicle, values_of, vehicle_trim

from ahv_ctrl_fmu import neural_model
from ahv_plant_fmu import model as plant
from ahv_plant_fmu.equations import derivative
from ahv_plant_fmu.trim import NOMINAL
from cosim.analysis.margins import frequencies, margins, margins_at, response
from cosim.vehicle.registry import LAWS
from fmus import floats


def gains_of(law):
    """A law of the registry: its module, and the gains of its own preset."""
    module = import_module(LAWS[law].module)
    return module, module.PRESETS[LAWS[law].preset]



def test_the_vehicles_matrices_are_those_of_difference_quotients():
    p = values_of(plant, {"psi_1": -363.5, "psi_2": 328.8})
    found = linear_vehicle(plant, 8200, 90000, psi_1=-363.5, psi_2=328.8)
    x, u = vehicle_trim(plant, 8200, 90000, [1.0] * 5, p)

    def rate(x, u):
        return np.array(derivative(floats, list(x), *u, NOMINAL, p))

    for i, size in enumerate((1.0, 1.0, *[1e-4] * 3, *[1e-2] * 4)):
        step = size * np.eye(9)[i]
        assert np.allclose(found.A[:, i], (rate(x + step, u) - rate(x - step, u)) / (2 * size), rtol=1e-5, atol=1e-6)
    for i in range(2):
        step = 1e-4 * np.eye(2)[i]
        assert np.allclose(found.B[:, i], (rate(x, u + step) - rate(x, u - step)) / 2e-4, rtol=1e-5, atol=1e-6)


def test_a_scaled_vehicle_has_its_own_trim():
    p = values_of(plant, {})
    for scale in (0.6, 1.4):
        x, u = vehicle_trim(plant, 7700, 85000, [scale] * 5, p)
        groups = type(NOMINAL)(**dict.fromkeys(GROUPS, scale))
        assert np.abs(derivative(floats, list(x), *u, groups, p)).max() < 1e-8


@pytest.mark.parametrize("law", LAWS)
def test_the_closed_loop_answers_a_small_command_as_the_flight_does(law):
    command = 0.01  # ft: small enough for lines to be straight
    flown = [fly("hold", law, LAWS[law].preset, values={"scenario": {"h_command_step": step}}, stop=20)["plant.h"]
             for step in (0.0, command)]  # the neural law moves a little by itself, until its estimates have settled
    loop = linear_loop(plant, *gains_of(law), 7700, 85000)
    system = loop.cut()
    x = np.zeros(len(system.A))
    h = [0.0]
    for _ in range(2000):
        x = system.A @ x + system.B @ [0.0, command]
        h.append(float(x[1]))
    assert np.allclose(flown[1] - flown[0], h, rtol=0, atol=2e-3 * command)


@pytest.mark.parametrize("law", LAWS)
def test_a_loop_is_stable_just_inside_its_gain_margins_and_unstable_just_outside(law):
    loop = linear_loop(plant, *gains_of(law), 7700, 85000)
    checked = 0
    for name, cut in loop.cuts().items():
        found = margins_at(cut)

        def radius(gain, cut=cut):
            closed = cut.A + cut.B @ cut.C * gain / (1 - cut.D[0, 0] * gain)
            return np.abs(np.linalg.eigvals(closed)).max()

        for gain, inside, outside in ((found.gain_up, 0.99, 1.01), (found.gain_down, 1.01, 0.99)):
            if gain is not None:
                checked += 1
                assert radius(gain * inside) < 1 < radius(gain * outside), name
    assert checked >= 8


def test_margins_of_a_loop_known_by_hand():
    # 2 / (s (s + 1)^2) with a sample every 0.1 ms: gain margin 1, reached at 1 rad/s; here with gain 1, so 2.
    h = 1e-4
    A = np.eye(3) + h * np.array([[0, 1, 0], [0, -1, 1], [0, 0, -1]])
    B, C, D = h * np.array([[0.0], [0], [1]]), np.array([[1.0, 0, 0]]), np.zeros((1, 1))
    omega = frequencies(h)
    found = margins(omega, response(A, B, C, D, omega, h)[:, 0, 0])
    crossover = 0.6823278  # |jw (jw + 1)^2| = w (1 + w^2) = 1
    phase = np.pi / 2 - 2 * np.arctan(crossover)
    assert found.gain_up == pytest.approx(2, rel=1e-3) and found.gain_down is None
    assert found.crossover == pytest.approx(crossover, rel=1e-3)
    assert found.phase_deg == pytest.approx(np.degrees(phase), rel=2e-3)
    assert found.delay_s == pytest.approx(phase / crossover, rel=2e-3)


def test_where_there_is_no_equilibrium_it_is_said():
    gains = neural_model.PRESETS["calibrated"]
    with pytest.raises(NoTrim, match="equilibrium"):
        linear_loop(plant, neural_model, gains, 7500, 105000)
    with pytest.raises(ValueError, match="no parameter wings"):
        linear_vehicle(plant, 7700, 85000, wings=2.0)


def test_the_angle_of_attack_is_an_output_of_the_vehicle():
    found = linear_vehicle(plant, 7700, 85000)
    assert np.array_equal(found.C @ np.arange(1.0, 10), [*range(1, 10), 4 - 3]) and found.outputs[-1] == "alpha"


@pytest.mark.parametrize("law", LAWS)
def test_memories_are_no_states_of_a_loop(law):
    loop = linear_loop(plant, *gains_of(law), 7700, 85000)
    system = loop.cut()
    reachable = np.hstack([system.A - np.eye(len(system.A)), system.B])
    assert np.abs(reachable).max(axis=1).min() > 0                       # each state changes
    assert np.abs(np.vstack([loop.Az, loop.Cy])).max(axis=0).min() > 0   # and is read
    assert np.abs(system.poles).min() > 0.05


@pytest.mark.parametrize("limit,actuator", [("fuel_ratio_max", 0), ("fuel_ratio_min", 0), ("elevator_max", 1),
                                            ("elevator_min", 1)])
def test_a_trim_with_an_actuator_at_its_limit_is_none(limit, actuator):
    module, gains = gains_of("neural")
    needed = linear_loop(plant, module, gains, 7700, 85000).y[actuator]
    with pytest.raises(NoTrim, match=r"an actuator is at its limit: fuel ratio 0\.267, elevator 12\.51 deg"):
        linear_loop(plant, module, {**gains, limit: needed}, 7700, 85000)
