"""benchmarks/bound.py: the best flight that exists of a draw is flown by the FMUs, and no law flies a better one."""
import sys
from pathlib import Path

import numpy as np
import pytest
from evidence import fly

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))

import bound
import bound_problem

from fmus import floats

DRAW = 3  # little lift and little moment at the start: a hard one
FLOWN_APART = 0.01  # ft, between what is found and what the FMUs fly with its inputs


@pytest.fixture(scope="module")
def draws(native_fmus):
    return bound.Draws("case1")


@pytest.fixture(scope="module")
def windows(draws):
    return {mode: bound_problem.window(draws.values(DRAW), draws.reference, 0.0, blind)
            for mode, blind in ((bound.KNOWN, None), ("0.3", 0.3))}


@pytest.fixture(scope="module")
def flights(windows):
    """What the optimiser finds for each kind of controller."""
    return {mode: bound_problem.best(window) for mode, window in windows.items()}


@pytest.mark.parametrize("mode", [bound.KNOWN, "0.3"])
def test_the_fmus_fly_what_was_found(draws, windows, flights, mode):
    assert flights[mode].found
    with bound.Forward() as forward:
        flown, apart = bound.compared(draws, forward, DRAW, windows[mode], flights[mode])
    assert apart < FLOWN_APART
    assert flown == pytest.approx(flights[mode].bound, abs=FLOWN_APART)


def test_knowing_is_better_than_being_blind_and_that_better_than_the_law(draws, flights):
    law = fly("case1", "resilient", values={"scenario": draws.values(DRAW)}, stop=20)
    error = np.abs(law["plant.h"] - law["controller.h_reference"]).max()
    assert 1 < flights[bound.KNOWN].bound < flights["0.3"].bound
    assert flights[bound.KNOWN].bound < error


def test_what_is_found_keeps_to_the_limits_and_is_blind_as_long_as_it_says(windows, flights):
    trim = windows["0.3"].inputs
    assert np.degrees(trim[1]) == pytest.approx(12.511, abs=1e-3)
    assert np.allclose(flights["0.3"].inputs[:, :30], trim[:, None], atol=1e-7)
    for found in flights.values():
        assert np.abs(np.degrees(found.inputs[1])).max() < 20 + 1e-5
        assert found.inputs[0].min() > 0.05 - 1e-6 and found.inputs[0].max() < 1.5 + 1e-6
        assert np.abs(found.inputs[:, 30] - trim).max() > 0.01, "it does something as soon as it may"


def test_the_references_are_those_of_the_laws(draws):
    law = fly("case1", "neural", stop=20)
    for name, row in (("V", 0), ("h", 1)):
        assert np.abs(law[f"controller.{name}_reference"] - draws.reference[row, 0, :2001]).max() < 1e-6
    assert np.gradient(draws.reference[:, 0], bound_problem.TICK, axis=1)[:, 1:-1] == pytest.approx(
        draws.reference[:, 1, 1:-1], abs=1e-3)


def test_before_a_later_jump_the_vehicle_is_on_its_references_and_stays_there(native_fmus):
    case2 = bound.Draws("case2")
    assert case2.jumps == [50, 100, 150, 200, 250]
    values, dt = case2.values(0), bound_problem.TICK
    (before, _), (state, inputs) = (bound_problem.slow_motion(values, case2.reference, t) for t in (90 - dt, 90))
    now = bound_problem.places(np.array([90.0]))[0]
    scales = bound_problem.scales_at(values, np.array([90.0]))[:, 0]
    rates = bound_problem.rate(floats, state.tolist(), inputs.tolist(), scales.tolist())
    assert state[:2] == pytest.approx(case2.reference[:, 0, now], abs=1e-9)
    assert rates[:2] == pytest.approx(case2.reference[:, 1, now], abs=1e-6)
    assert rates == pytest.approx((state - before) / dt, abs=1e-3, rel=0.02)
