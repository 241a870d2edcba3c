"""The paper's two cases, flown by the FMU files through the command line."""
import json
import subprocess

import numpy as np
import pyarrow.parquet
import pytest
from evidence import fly
from places import AHV

from cosim.vehicle.metrics import metrics


def ahv(*words, cwd=None, status=0):
    """Standard output of `ahv`, which must end with `status`; standard error if that is not 0."""
    done = subprocess.run([AHV, *map(str, words)], capture_output=True, text=True, cwd=cwd)
    assert done.returncode == status, done.stderr
    return done.stdout if status == 0 else done.stderr


def flown(tmp_path, *words):
    return json.loads(ahv("run", *words, "--json", "--out", tmp_path / "out"))


LIMITS = {"case1": (2.8, 1.1, 0.8, 80), "case2": (5.3, 2.0, 0.9, 180)}
FIGURES = (("altitude_error_ft", "max_abs"), ("altitude_error_ft", "rms"),
           ("velocity_error_fps", "max_abs"), ("elevator_deg", "travel"))


@pytest.mark.parametrize("case,flavour", [  # test_native_twins flies both flavours of both cases and finds them equal
    ("case1", "python"), ("case1", "native"), ("case2", "native"),
    pytest.param("case2", "python", marks=pytest.mark.slow)])
def test_the_calibrated_controller_flies_the_case_within_its_limits(case, flavour, tmp_path):
    found = flown(tmp_path, case, "--flavour", flavour)
    assert found["finished"] and found["departed_at_s"] is None
    for (group, key), limit in zip(FIGURES, LIMITS[case]):
        assert found[group][key] <= limit, (group, key)
    assert found["elevator_deg"]["min"] >= -20 and found["elevator_deg"]["max"] <= 20


@pytest.mark.parametrize("case", ["case1", "case2"])
def test_figures_stay_within_ten_per_cent_from_1_to_20_ms_and_50_ms_still_flies(case):
    reference = metrics(fly(case))
    for step in (0.001, 0.005, 0.02):
        found = metrics(fly(case, step=step))
        for group, key in FIGURES:
            assert found[group][key] == pytest.approx(reference[group][key], rel=0.1), (step, group, key)
    slow = fly(case, step=0.05)
    assert slow.finished and metrics(slow)["altitude_error_ft"]["max_abs"] < 20


def test_a_run_leaves_signals_with_units_a_record_and_figures(tmp_path):
    found = flown(tmp_path, "case1", "--stop", 5, "--decimate", 10)
    out = tmp_path / "out"
    table = pyarrow.parquet.read_table(out / "signals.parquet")
    assert table.num_rows == 51
    assert table.schema.field("plant.V").metadata[b"unit"] == b"ft/s"
    rows = np.genfromtxt(out / "signals.csv", delimiter=",", names=True, deletechars="")
    assert rows.dtype.names == tuple(name.replace(" ", "_") for name in table.column_names)
    assert np.array_equal(rows["plant.h"], table["plant.h"].to_numpy())
    record = json.loads((out / "run.json").read_text())
    assert {**record, **found} == record
    assert record["parameters"]["controller"]["kV"] > 12.4 and record["parameters"]["plant"]["gravity"] == 32.0
    assert all(len(fmu["sha256"]) == 64 for fmu in record["fmus"].values())
    figures = [p.name[:9] for p in sorted((out / "figures").iterdir())]
    assert figures == ["coefficie", *(f"figure_{n:02d}" for n in range(2, 8))]


def test_the_printed_controller_departs_and_what_was_flown_is_kept(tmp_path):
    message = ahv("run", "case1", "--preset", "printed", "--out", tmp_path / "out", status=1)
    warning, message = message.strip().splitlines()
    assert warning.startswith("ahv: At a limit: the fuel ratio for 18.")
    assert "theta" in message and "at t = 19." in message
    record = json.loads((tmp_path / "out" / "run.json").read_text())
    assert not record["finished"]
    table = pyarrow.parquet.read_table(tmp_path / "out" / "signals.parquet")
    assert table["time"][-1].as_py() == pytest.approx(record["departed_at_s"])
    assert np.isfinite(table["plant.theta"].to_numpy()).all()
    assert len(list((tmp_path / "out" / "figures").iterdir())) == 7


def test_trim_reproduces_table_1(tmp_path):
    found = json.loads(ahv("trim", "--V", 7700, "--h", 85000, "--json"))
    assert list(found) == ["V_fps", "h_ft", "theta_deg", "eta1", "eta2", "fuel_ratio", "elevator_deg", "residual"]
    assert (round(found["theta_deg"], 4), round(found["eta1"], 4), round(found["eta2"], 4)) == (1.6325, 0.97, 0.7967)
    assert (round(found["fuel_ratio"], 5), round(found["elevator_deg"], 3)) == (0.26703, 12.511)
    assert found["residual"] < 1e-9


def test_a_paced_run_reports_its_lateness_and_the_factor_may_be_left_out(tmp_path):
    found = flown(tmp_path, "case1", "--stop", 0.5, "--real-time", "--algorithm", "jacobi")
    assert set(found["lateness"]) >= {"mean_s", "p99_s", "worst_s"}
    assert found["real_time_factor"] < 2
