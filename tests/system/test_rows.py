"""A row is not a tick: Case 1 is reported the same whatever its rows are."""
import json

import numpy as np
import pyarrow.parquet
import pytest
from evidence import system

from cosim.campaign.worker import errors_over_time
from cosim.master.fly import fly
from cosim.vehicle.metrics import OVER_TIME, measured
from cosim.vehicle.run import run
from cosim.vehicle.signals import course, reference

STOP = 20.0


def flown(algorithm, step, stop=STOP):
    return fly(system("case1", "neural", "calibrated", "ideal"), step, stop, algorithm)


@pytest.fixture(scope="module")
def even():
    return flown("gauss-seidel", 0.001)


@pytest.fixture(scope="module")
def uneven():
    return flown("variable,tolerance=1e-5", 0.01)


@pytest.fixture(scope="module")
def slow():
    return flown("multi-rate,controller=50", 0.001)


def test_variable_steps_report_what_fixed_steps_do(even, uneven):
    assert np.ptp(np.diff(uneven.time)) > 2e-4 and len(uneven.time) != len(even.time)
    expected, found = measured(even), measured(uneven)
    for name in ("altitude_error_ft.max_abs", "altitude_error_ft.rms", "velocity_error_fps.max_abs",
                 "velocity_error_fps.rms", "elevator_deg.travel"):
        assert found[name] == pytest.approx(expected[name], rel=0.02), name


def courses(flight):
    return {name: course(flight, expression) for name, (_, expression) in OVER_TIME.items()}


def test_errors_over_time_of_variable_steps_are_those_of_fixed_steps_and_reach_the_end(even, uneven):
    expected, found = errors_over_time(courses(even), 0.001, 20_000), errors_over_time(courses(uneven), 0.01, 2000)
    assert np.array_equal(expected["time"], even.time[::200]) and np.array_equal(found["time"], expected["time"])
    assert np.array_equal(expected["altitude_error_ft"],
                          (even["plant.h"] - even["controller.h_reference"])[::200].astype(np.float32))
    for name, limit in (("altitude_error_ft", 0.05), ("velocity_error_fps", 0.02)):
        assert np.abs(found[name] - expected[name]).max() < limit


def test_what_a_slow_controller_shows_is_recorded_when_it_is_due(slow):
    """Its reference is the filtered command, which can be computed without it."""
    expected = reference(slow.time, np.asarray(slow["scenario.h_command"]), float(slow["plant.h"][0]))
    at = {t: int(np.argmin(np.abs(slow.time - t))) for t in (1.2, 1.234, 1.25)}
    shown = slow["controller.h_reference"]
    assert shown[at[1.234]] == shown[at[1.2]] == pytest.approx(expected[at[1.2]], abs=1e-2)
    assert shown[at[1.25]] == pytest.approx(expected[at[1.25]], abs=1e-2)
    assert expected[at[1.25]] > expected[at[1.2]] + 0.3


def test_a_slow_controller_is_judged_by_the_reference_of_the_same_time(slow):
    expected = reference(slow.time, np.asarray(slow["scenario.h_command"]), float(slow["plant.h"][0]))
    error = slow["plant.h"] - expected
    found = measured(slow)
    assert found["altitude_error_ft.rms"] == pytest.approx(np.sqrt(np.mean(error**2)), rel=1e-3)
    assert found["altitude_error_ft.max_abs"] == pytest.approx(np.abs(error).max(), rel=1e-2)


def test_a_streamed_run_whose_last_rows_memory_does_not_keep_leaves_its_record(tmp_path, monkeypatch):
    """1,508 rows, each by itself, of which memory keeps every 16th by the end."""
    monkeypatch.setattr("cosim.master.recording.KEPT_ROWS", 50)
    done = run("case1", stream=True, step=0.001, stop=1.507, algorithm="iterated", out=tmp_path)
    assert len(done.flight.time) < 102 and done.flight.time[-1] == pytest.approx(1.507)
    assert json.loads((tmp_path / "run.json").read_text())["ticks"] == 1507
    assert done.notes == [f"metrics and figures are computed from {len(done.flight.time)} of 1508 rows: those that "
                          f"--stream keeps in memory."]
    assert pyarrow.parquet.read_table(tmp_path / "signals.parquet").num_rows == 1508
