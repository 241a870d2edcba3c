"""The two laws side by side, as `ahv compare` shows them; the rival is a reconstruction."""
import json

import numpy as np
import pytest
from command import ahv

from cosim.vehicle.compare import settling


@pytest.fixture(scope="module", params=["case1", "case2"])
def compared(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("compare")
    found = json.loads(ahv("compare", request.param, "--json", "--out", folder))
    return found, folder


def test_both_laws_fly_the_case_and_the_table_is_complete(compared):
    found, folder = compared
    assert list(found["controllers"]) == ["neural", "neural, robust", "resilient", "backstepping"]
    for row in found["controllers"].values():
        assert row["finished"] and row["departed_at_s"] is None
        assert 40 < row["altitude_settling_s"] < 60 and 40 < row["velocity_settling_s"] < 60
        assert row["states"] > 10 and row["parameters"] > row["preset_parameters"] > 10
    assert len(list(folder.glob("compare_*.png"))) == 5


def test_the_neural_law_tracks_altitude_better_the_rival_velocity(compared):
    neural, robust, _, rival = compared[0]["controllers"].values()
    for key in ("max_abs", "rms"):
        assert neural["altitude_error_ft"][key] < 0.8 * rival["altitude_error_ft"][key]
    for law in (neural, robust):
        assert rival["velocity_error_fps"]["max_abs"] < 0.9 * law["velocity_error_fps"]["max_abs"]
    assert "neural has the smallest maximum altitude error" in compared[0]["verdict"]


def test_with_the_same_cost_and_budget_the_two_laws_are_close_in_altitude(compared):
    _, robust, _, rival = compared[0]["controllers"].values()
    for key in ("max_abs", "rms"):
        assert robust["altitude_error_ft"][key] == pytest.approx(rival["altitude_error_ft"][key], rel=0.25)
    assert robust["elevator_deg"]["travel"] < rival["elevator_deg"]["travel"]


def test_the_neural_law_costs_more_per_step(compared):
    neural, _, _, rival = compared[0]["controllers"].values()
    assert neural["cost_per_step_us"] > rival["cost_per_step_us"]
    assert neural["states"] > rival["states"]


def test_settling_is_the_longest_of_all_steps_and_none_where_there_is_none():
    time = np.arange(0, 10, 0.1)
    command = np.where(time < 4.95, 1.0, 3.0)
    found = np.where(time < 4.95, 1 - np.exp(-2 * time), 3 - 2 * np.exp(-2 * (time - 5)))
    assert settling(time, command, found) == pytest.approx(np.log(50) / 2, abs=0.11)
    assert settling(time, np.ones(100), np.ones(100)) is None
    assert settling(time, command, 0 * time) is None
