"""Loops of small FMUs linearised, against matrices that are known; and what has no linearisation."""
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg
import small

from cosim.analysis import linearize
from cosim.analysis.pulses import Answers, Rest
from cosim.analysis.realise import realise
from cosim.analysis.report import check_limits
from cosim.errors import RunError, UsageError
from cosim.master.loaded import open_files
from cosim.master.system import Component, Connection, System

STEP = 0.01
SPRING = {"a21": -4.0, "a22": -0.3, "x1": 1.0}                              # s^2 + 0.3 s + 4
PI = {"a12": 0.0, "a21": 0.0, "b1": 1.0, "b2": 0.0, "c1": 0.5, "d": 0.4}    # 0.4 + 0.5 / s


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("small")


def loop(plant: Path, controller: Path, spring: dict | None = None, law: dict | None = None) -> System:
    parts = (Component("law", controller, {**PI, **(law or {})}),
             Component("spring", plant, {**SPRING, **(spring or {})}))
    return System(parts, (Connection("spring.y", "law.u", -1.0), Connection("law.y", "spring.u")))


def linear(system: System, **given) -> dict:
    return linearize(system, ["law.y"], ["spring.y"], STEP, 600.0, **given)


def held(A, B):
    """exp of [[A, B], [0, 0]] over a step: what a held input makes of a state."""
    n = len(A)
    both = scipy.linalg.expm(STEP * np.block([[A, B], [np.zeros((1, n + 1))]]))
    return both[:n, :n], both[:n, n:]


def by_hand(law_first: bool, gain: float = 1.0) -> np.ndarray:
    """A of the loop as it flies; states: spring (2), integral, and what is held from the last tick."""
    A, B = held(np.array([[0.0, 1.0], [-4.0, -0.3]]), np.array([[0.0], [1.0]]))
    x, integral, last = np.eye(4)[:2], np.eye(4)[2:3], np.eye(4)[3:]
    if law_first:  # it reads last tick's y; the spring its output
        y = last
        later = integral - STEP * y
        x = A @ x + B @ (gain * (0.5 * later - 0.4 * y))
        return np.vstack([x, later, x[:1]])
    x = A @ x + B @ last
    later = integral - STEP * x[:1]
    return np.vstack([x, later, gain * (0.5 * later - 0.4 * x[:1])])


def rates(A) -> np.ndarray:
    values = np.linalg.eigvals(A).astype(complex)
    return np.log(values[np.abs(values) > 1e-4]) / STEP


def complex_numbers(found: list[dict]) -> np.ndarray:
    return np.array([root["real"] + 1j * root["imag"] for root in found])


def agree(found, expected, tolerance):
    assert len(found) == len(expected)
    for value in expected:
        assert np.abs(found - value).min() <= tolerance * abs(value), (value, found)


@pytest.mark.parametrize("states", [True, False], ids=["states can be saved", "flown again"])
@pytest.mark.parametrize("direct", [True, False], ids=["spring first", "law first"])
def test_a_spring_under_a_pi_law_has_its_poles_and_margins(folder, direct, states):
    found = linear(loop(small.build(folder, states=states), small.build(folder, direct, states=states)))
    agree(complex_numbers(found["open_loop"]["poles"]), np.roots([1, 0.3, 4]), 1e-7)
    agree(complex_numbers(found["closed_loop"]["poles"]), rates(by_hand(law_first=not direct)), 1e-6)
    assert found["closed_loop"]["stable"] and found["open_loop"]["step_s"] == 0
    at_actuator, at_sensor = found["margins"].values()
    assert list(found["margins"]) == ["law.y", "spring.y"]
    assert at_actuator["gain_down"] is None and at_sensor["gain_down"] is None
    for key in ("gain_up", "phase_deg", "delay_s", "crossover"):  # one loop, cut in two places
        assert at_actuator[key] == pytest.approx(at_sensor[key], rel=1e-6)
    for share, stable in ((0.999, True), (1.001, False)):
        A = by_hand(not direct, share * at_actuator["gain_up"])
        assert (np.abs(np.linalg.eigvals(A)).max() < 1) == stable


def test_an_unstable_plant_is_seen_through_its_stable_loop(folder):
    found = linear(loop(small.build(folder), small.build(folder), {"a21": 1.0, "a22": -2.0, "c2": 0.1},
                        {"d": 3.0, "c1": 1.0}))
    agree(complex_numbers(found["open_loop"]["poles"]), np.roots([1, 2, -1]), 1e-6)
    assert found["closed_loop"]["stable"]
    agree(complex_numbers(found["open_loop"]["zeros"]["law.y to spring.y"]), np.array([-10.0]), 1e-5)


def test_signals_go_by_their_variables_where_these_differ(folder):
    fmu = small.build(folder)
    system = System((Component("law", fmu, PI), Component("spring", fmu, SPRING)),
                    (Connection("spring.y1", "law.u", -1.0), Connection("law.y", "spring.u")))
    found = linearize(system, ["law.y"], ["spring.y1"], STEP, 600.0)
    assert list(found["margins"]) == ["y", "y1"] and list(found["open_loop"]["zeros"]) == ["y to y1"]
    assert found["equilibrium"] == pytest.approx({"law.y": 0.0, "spring.y1": 0.0}, abs=1e-6)


def test_states_are_counted_by_what_errors_leave_to_be_told():
    k = np.arange(600)
    strong, weak = 0.99**k, 0.8**k
    for error, count in ((1e-12, 2), (1e-3, 1)):
        answers = Answers(["u"], ["y"], (strong + 1e-4 * weak)[:, None, None], np.full((600, 1, 1), error))
        found = realise("part", answers, STEP)
        assert len(found.A) == count
        assert np.linalg.eigvals(found.A).real.max() == pytest.approx(0.99, rel=1e-9 if count == 2 else 1e-3)


def test_what_cannot_be_linearised_is_said_in_one_sentence(folder):
    fmu = small.build(folder)
    with pytest.raises(RunError, match=r"does not settle within 20 s: (spring|law)\.y = .* still moves by"):
        linearize(loop(fmu, fmu), ["law.y"], ["spring.y"], STEP, 20.0)
    with pytest.raises(RunError, match=r"departs before it is at rest: spring .* at t = 3"):
        linear(loop(fmu, fmu, {"fault_time": 3.0, "fault": 2}))
    with pytest.raises(RunError, match=r"the actuator law\.y = 0 does not answer any input of law"):
        linear(loop(fmu, fmu, law={"d": 0.0, "c1": 0.0}))
    with pytest.raises(UsageError, match=r"spring\.whole_out is not a continuous Real output that is connected"):
        linearize(loop(fmu, fmu), ["law.y"], ["spring.whole_out"], STEP)
    with pytest.raises(UsageError, match=r"The sensor law\.y shows nothing that an actuator drives"):
        linearize(loop(fmu, fmu), ["law.y"], ["spring.y", "law.y"], STEP)
    with pytest.raises(UsageError, match="at least one actuator"):
        linearize(loop(fmu, fmu), [], ["spring.y"], STEP)
    with pytest.raises(UsageError, match="step = -1 s"):
        linearize(loop(fmu, fmu), ["law.y"], ["spring.y"], -1.0)


def test_an_actuator_at_a_declared_limit_is_named(folder):
    system = loop(small.build(folder), small.build(folder))
    with open_files(system) as files:
        files["spring"].variable("u").own["max"] = "2.0"
        for value, at_limit in ((2.0, True), (1.999, False)):
            rest = Rest(system, files, STEP, 1, 1.0, {"law.y": value}, {"law.y": 1.0})
            if at_limit:
                with pytest.raises(RunError, match=r"the actuator spring\.u = 2 is at its maximum"):
                    check_limits(rest, "law.y", system.connections)
            else:
                check_limits(rest, "law.y", system.connections)
