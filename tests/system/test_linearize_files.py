"""Our closed loops linearised from their FMU files alone, against the matrices of the models behind them."""
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import scipy.optimize

from cosim.analysis import linearize
from cosim.errors import RunError
from cosim.master.system import Component, Connection, System
from cosim.vehicle import scenarios
from cosim.vehicle.closed_loop import assignments, closed_loop
from cosim.vehicle.linearize import from_models

ACTUATORS = ["controller.fuel_ratio", "controller.elevator"]
SENSORS = [f"plant.{name}" for name in ("V", "h", "gamma", "theta", "Q")]
COMMANDS = ["scenario.V_command", "scenario.h_command"]
STEP = 0.01
LOOPS = [("neural", "calibrated"), ("neural", "steady"), ("backstepping", "calibrated")]


def files(law: str, preset: str = "calibrated", words: tuple[str, ...] = (), plant: str = "ideal") -> dict:
    loop = closed_loop(scenarios.load("hold"), law, plant, presets={"controller": preset}, values=assignments(words))
    return linearize(loop.system, ACTUATORS, SENSORS, STEP, 60.0, COMMANDS)


@cache
def both(law: str, preset: str) -> tuple[dict, dict]:
    """From the files, and from the models."""
    return files(law, preset), from_models(law, preset, 7700, 85000, 1.0, STEP, {})


def numbers(found: list[dict]) -> np.ndarray:
    return np.array([root["real"] + 1j * root["imag"] for root in found])


def agree(found, expected, relative, absolute=1e-6):
    for value in expected:
        assert np.abs(found - value).min() <= relative * abs(value) + absolute, value


@pytest.fixture(params=LOOPS, ids=" ".join)
def loop(request, native_fmus):
    return both(*request.param)


def test_the_vehicle_has_its_poles_and_zeros(loop):
    found, exact = (numbers(one["open_loop"]["poles"]) for one in loop)
    assert len(found) == len(exact) == 9
    agree(found, exact, 1e-4)
    for name, zeros in loop[1]["open_loop"]["zeros"].items():
        found = numbers(loop[0]["open_loop"]["zeros"][name])
        assert len(found) == len(zeros), name
        agree(found, numbers(zeros), 1e-3, 1e-5)


def test_the_closed_loop_has_the_poles_that_an_input_moves_and_an_output_shows(loop):
    found, exact = (numbers(one["closed_loop"]["poles"]) for one in loop)
    assert loop[0]["closed_loop"]["stable"]
    agree(exact, found, 1e-4)  # none that is not there
    missing = [value for value in exact if np.abs(found - value).min() > 1e-4 * abs(value) + 1e-6]
    assert len(missing) == len(exact) - len(found) <= 4
    assert all(value.real < -0.5 for value in missing)


def test_margins_are_those_of_the_models(loop):
    found, exact = (one["margins"] for one in loop)
    assert list(found) == list(exact)
    for place in exact:
        for key, value in exact[place].items():
            assert found[place][key] == (value if value is None else pytest.approx(value, rel=1e-4)), (place, key)


def test_the_equilibrium_is_told(loop):
    found, exact = loop
    assert found["equilibrium"]["controller.fuel_ratio"] == pytest.approx(exact["fuel_ratio"], rel=1e-9)
    assert np.degrees(found["equilibrium"]["controller.elevator"]) == pytest.approx(exact["elevator_deg"], rel=1e-9)
    assert np.degrees(found["equilibrium"]["plant.theta"]) == pytest.approx(exact["theta_deg"], rel=1e-9)


def test_lag_and_delay_of_an_actuator_are_seen(native_fmus):
    """No model of ours is linearised with these: the lag is a pole, and the delay leaves that much less margin."""
    with_lag = files("backstepping", words=("plant.elevator_bandwidth=50",), plant="instrumented")
    assert np.abs(numbers(with_lag["open_loop"]["poles"]) + 50).min() < 1e-4
    delayed = files("backstepping", words=("plant.elevator_delay=0.02",), plant="instrumented")
    margins = both("backstepping", "calibrated")[0]["margins"]
    assert delayed["margins"]["elevator"]["delay_s"] == pytest.approx(margins["elevator"]["delay_s"] - 0.02, rel=1e-3)


@pytest.mark.parametrize("words, plant, message", [
    (("plant.Q_noise=1e-4",), "instrumented", r"does not settle within 60 s: plant\.\w+ = .* still moves by"),
    (("controller.elevator_max=0.2",), "ideal", r"departs before it is at rest: plant .* theta"),
    (("controller.elevator_min=0.2183653",), "ideal", r"controller .* cannot be linearised: its answer to a change"),
], ids=["noise", "no equilibrium", "beside a limit"])
def test_what_has_no_linearisation_is_said_in_one_sentence(native_fmus, words, plant, message):
    with pytest.raises(RunError, match=message):
        files("backstepping", words=words, plant=plant)


def test_fmus_of_stock_pythonfmu_that_save_no_state_are_linearised(tmp_path):
    for source in ("mass.py", "spring.py"):
        subprocess.run([sys.executable, "-m", "pythonfmu", "build", "-f", Path(__file__).parent / "handmade" / source,
                        "-d", tmp_path], check=True, capture_output=True)
    names = ("position", "velocity")
    parts = Component("spring", tmp_path / "Spring.fmu", {"damping": 2.0}), Component("mass", tmp_path / "Mass.fmu")
    system = System(parts, (*(Connection(f"mass.{n}", f"spring.{n}") for n in names),
                            Connection("spring.force", "mass.force")))
    found = linearize(system, ["spring.force"], [f"mass.{n}" for n in names], STEP, 60.0)
    A = np.array([[1, STEP], [0, 1]]) @ np.array([[1, 0], [-10 * STEP, 1 - 2 * STEP]])  # semi-implicit Euler
    poles = numbers(found["closed_loop"]["poles"])
    assert len(poles) == 2
    agree(poles, np.log(np.linalg.eigvals(A)) / STEP, 1e-6)
    assert len(found["open_loop"]["poles"]) == 2 and np.abs(numbers(found["open_loop"]["poles"])).max() < 1e-3
    # the sensors are cut one at a time: without one, what is left is a second-order system
    assert found["margins"]["velocity"]["gain_up"] == pytest.approx(sampled_gain_margin(), rel=1e-3)


def sampled_gain_margin() -> float:
    """Factor on the spring's damping at which the semi-implicit loop reaches z = -1."""
    def radius(factor):
        A = np.array([[1, STEP], [0, 1]]) @ np.array([[1, 0], [-10 * STEP, 1 - 2 * factor * STEP]])
        return np.abs(np.linalg.eigvals(A)).max()
    return float(scipy.optimize.brentq(lambda factor: radius(factor) - 1, 10, 1000))
