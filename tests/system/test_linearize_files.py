"""Our closed loops linearised from their FMU files, against the matrices of the models behind them (`exact_loop`)."""
import json
import subprocess
import sys
from functools import cache
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
import scipy.io
import scipy.optimize
from command import ahv
from exact_loop import exact

from cosim.analysis import linearize, report
from cosim.errors import RunError
from cosim.master.system import Component, Connection, System
from cosim.vehicle import scenarios
from cosim.vehicle.closed_loop import assignments, closed_loop
from cosim.vehicle.linearize import linearize as linearize_loop
from cosim.vehicle.registry import LAWS

ACTUATORS = ["controller.fuel_ratio", "controller.elevator"]
SENSORS = [f"plant.{name}" for name in ("V", "h", "gamma", "theta", "Q")]
COMMANDS = ["scenario.V_command", "scenario.h_command"]
STEP = 0.01
EVERY_DAY = [("neural", "calibrated"), ("backstepping", "calibrated"), ("resilient", "quiet")]
OTHERS = [(law, preset) for law in LAWS for preset in import_module(LAWS[law].module).PRESETS
          if (law, preset) not in EVERY_DAY and preset != "printed"]


def files(law: str, preset: str = "calibrated", words: tuple[str, ...] = (), plant: str = "ideal") -> dict:
    loop = closed_loop(scenarios.load("hold"), law, plant, presets={"controller": preset}, values=assignments(words))
    return linearize(loop.system, ACTUATORS, SENSORS, STEP, 60.0, COMMANDS)


@cache
def found_of(law: str, preset: str) -> dict:
    return linearize_loop(law, preset)


def numbers(found: list[dict]) -> np.ndarray:
    return np.array([root["real"] + 1j * root["imag"] for root in found])


def agree(found, expected, relative, absolute=1e-6):
    for value in expected:
        assert np.abs(found - value).min() <= relative * abs(value) + absolute, value


@pytest.fixture(params=[*EVERY_DAY, *(pytest.param(loop, marks=pytest.mark.slow) for loop in OTHERS)], ids=" ".join)
def loop(request, native_fmus):
    return found_of(*request.param), exact(*request.param)


def test_the_vehicle_has_its_matrices_poles_and_zeros(loop):
    found, expected = loop
    alone = found["open_loop"]
    assert alone["step_s"] == 0 and alone["states"][:2] == ["V", "h"]
    for name in ("A", "B"):
        assert np.allclose(alone[name], expected[name], rtol=1e-9, atol=1e-12)
    poles = numbers(alone["poles"])
    assert len(poles) == 9
    agree(poles, expected["open_loop"], 1e-9, 1e-9)
    for name, zeros in expected["zeros"].items():
        found = numbers(alone["zeros"][name])
        assert len(found) == len(zeros), name
        agree(found, zeros, 1e-6)


def test_the_closed_loop_has_the_poles_that_an_input_moves_and_an_output_shows(loop):
    found, expected = numbers(loop[0]["closed_loop"]["poles"]), loop[1]["closed_loop"]
    assert loop[0]["closed_loop"]["stable"]
    agree(expected, found, 1e-4)  # none that is not there
    missing = [value for value in expected if np.abs(found - value).min() > 1e-4 * abs(value) + 1e-6]
    assert len(missing) == len(expected) - len(found) <= 5
    assert all(value.real < -0.5 for value in missing)


def test_margins_are_those_of_the_models(loop):
    found, expected = (one["margins"] for one in loop)
    assert list(found) == list(expected)
    for place in expected:
        for key, value in expected[place].items():
            assert found[place][key] == (value if value is None else pytest.approx(value, rel=1e-6)), (place, key)


def test_the_equilibrium_is_told(loop):
    found, expected = loop
    assert found["settled_at_s"] is not None and found["solved"] == "as flown"
    for key in ("fuel_ratio", "elevator_deg", "theta_deg"):
        assert found[key] == pytest.approx(expected[key], rel=1e-9)


def test_the_loop_is_about_the_papers_trim(native_fmus):
    found = found_of("neural", "calibrated")
    assert found["theta_deg"] == pytest.approx(1.6325, abs=5e-5)
    assert found["altitude_offset_ft"] == pytest.approx(0, abs=1e-6)
    assert found["elevator_deg"] == pytest.approx(12.511, abs=5e-4)
    assert found["fuel_ratio"] == pytest.approx(0.26703, abs=5e-6)
    assert -0.2 < found["closed_loop"]["abscissa"] < 0
    assert set(found["margins"]) == {"fuel_ratio", "elevator", "V", "h", "gamma", "theta", "Q"}


def test_an_unstable_loop_that_starts_at_rest_is_linearised_as_it_flies(native_fmus):
    found, expected = found_of("neural", "printed"), exact("neural", "printed")
    assert not found["closed_loop"]["stable"] and found["margins"] is None
    assert found["closed_loop"]["abscissa"] == pytest.approx(expected["closed_loop"].real.max(), rel=1e-8)


def test_an_unstable_loop_that_does_not_start_at_rest_is_linearised_from_its_equations(native_fmus, capsys):
    found, expected = linearize_loop("neural", scale=0.6), exact("neural", "calibrated", scale=0.6)
    assert found["settled_at_s"] is None and found["solved"] == "exactly" and not found["closed_loop"]["stable"]
    assert "does not come to rest" in capsys.readouterr().err
    for key in ("fuel_ratio", "elevator_deg", "theta_deg"):
        assert found[key] == pytest.approx(expected[key], rel=1e-8)
    assert found["closed_loop"]["abscissa"] == pytest.approx(expected["closed_loop"].real.max(), rel=1e-5)


def test_pulses_alone_tell_nearly_the_same(native_fmus, monkeypatch):
    """As for files without model exchange."""
    monkeypatch.setattr(report, "equations_at", lambda *_: None)
    found, expected = files("neural"), exact("neural", "calibrated")
    agree(numbers(found["open_loop"]["poles"]), expected["open_loop"], 1e-5, 1e-5)
    for place, margins in expected["margins"].items():
        for key, value in margins.items():
            assert found["margins"][place][key] == (value if value is None else pytest.approx(value, rel=1e-5))


def test_lag_and_delay_of_an_actuator_are_seen(native_fmus):
    """The lag is a pole, and the delay, which no equations have, leaves that much less margin."""
    with_lag = files("backstepping", words=("plant.elevator_bandwidth=50",), plant="instrumented")
    assert np.abs(numbers(with_lag["open_loop"]["poles"]) + 50).min() < 1e-4
    delayed = files("backstepping", words=("plant.elevator_delay=0.02",), plant="instrumented")
    margin = exact("backstepping", "calibrated")["margins"]["elevator"]["delay_s"]
    assert delayed["margins"]["elevator"]["delay_s"] == pytest.approx(margin - 0.02, rel=1e-3)


@pytest.mark.parametrize("words, plant, message", [
    (("plant.Q_noise=1e-4",), "instrumented", r"does not settle within 60 s: plant\.\w+ = .* still moves by"),
    (("controller.elevator_max=0.2",), "ideal", r"departs before it is at rest: plant .* theta"),
    (("controller.elevator_min=0.2183653",), "ideal", r"controller .* cannot be linearised: its answer to a change"),
], ids=["noise", "no equilibrium", "beside a limit"])
def test_what_has_no_linearisation_is_said_in_one_sentence(native_fmus, words, plant, message):
    with pytest.raises(RunError, match=message):
        files("backstepping", words=words, plant=plant)


def test_parts_of_the_loop_and_files_of_what_was_found(native_fmus, tmp_path):
    found = json.loads(ahv("linearize", "--of", "controller", "--out", tmp_path / "law.mat", "--json"))
    assert "closed_loop" not in found and found["law"]["inputs"][:3] == ["V", "h", "gamma"]
    assert found["law"]["outputs"] == ["fuel_ratio", "elevator"] and found["law"]["step_s"] == STEP
    assert "V to elevator" not in found["law"]["zeros"]  # the law has no such path
    law = scipy.io.loadmat(tmp_path / "law.mat", simplify_cells=True)["law"]
    for name in "ABCD":
        assert np.array_equal(law[name], found["law"][name])
    assert np.array_equal(law["poles"], numbers(found["law"]["poles"]))
    shown = ahv("linearize", "--of", "plant", "--out", tmp_path / "plant.json")
    assert "-0.320 +-16.018j" in shown and "+-0.000j" not in shown and "zeros" in shown and "damping" in shown
    assert next(iter(json.loads((tmp_path / "plant.json").read_text())["open_loop"]["zeros"])) == "fuel_ratio to V"


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
