"""Parameters found from measured flights: right values, intervals, several flights, inputs, departures, the folder."""
import json
import shlex

import numpy as np
import pyarrow.parquet
import pytest
import small
from fitting import NOISE, TRUE, measured, one
from wrong_use import ended

import cosim
from cosim.errors import RunError
from cosim.fitting.flown import Plan, Plans, flying
from cosim.master.table import Table, read_table

FREE = ["a.a21=-4:-9:-1", "a.a22=-0.3"]


@pytest.fixture(scope="module")
def fmu(tmp_path_factory):
    return small.build(tmp_path_factory.mktemp("small"))


def fit(system, data, parameters=FREE, **options):
    return cosim.fit(system, data, parameters, **{"progress": False, **options})


def test_parameters_are_found_with_the_intervals_of_their_noise(fmu, tmp_path):
    found = fit(one(fmu), [measured(tmp_path / "f.csv", fmu, prefix="a.")])
    for name, true in TRUE.items():
        low, high = found.intervals_95[f"a.{name}"]
        assert low < true < high and high - low < 0.06, name
    for name, size in NOISE.items():
        signal = found.summary["signals"][f"a.{name}"]
        assert signal["noise"] == pytest.approx(size, rel=0.35) and signal["noise_from"] == "residuals"
        assert signal["rms_after"] < 0.5 * signal["rms_before"]
    assert found.finished and found.summary["settled"] and found.summary["warnings"] == []
    assert found.summary["reduced_chi_square"] == pytest.approx(1.0, rel=1e-6)


def test_the_interval_is_that_of_linear_regression(fmu, tmp_path):
    """What shows c1 times a known course has a regression's own formulas."""
    path = measured(tmp_path / "f.csv", fmu, prefix="a.", c1=1.5)
    found = fit(one(fmu, **TRUE), [path], ["a.c1"], signals=["a.y"])
    table = read_table(path)
    course = np.asarray(cosim.fly(one(fmu, **TRUE), 0.02, 4.0, progress=False)["a.y"])[::5]
    y = table.values["a.y"]
    value = course @ y / (course @ course)
    error = np.sqrt(((y - value * course) ** 2).sum() / (len(y) - 1) / (course @ course))
    told = found.summary["parameters"]["a.c1"]
    assert told["value"] == pytest.approx(value, rel=1e-6)
    assert told["standard_error"] == pytest.approx(error, rel=2e-3)
    assert (told["interval_95"][1] - value) / error == pytest.approx(2.021, abs=0.01)  # Student's t of 40


def test_flights_with_starts_of_their_own_and_gaps_share_parameters(fmu, tmp_path):
    data = {measured(tmp_path / f"{k}.csv", fmu, seed=k, gaps=0.2, prefix="a.", x1=x1): {"a.x1": x1}
            for k, x1 in enumerate((1.0, -0.5, 2.0))}
    found = fit(one(fmu), data)
    assert found.values["a.a21"] == pytest.approx(-5.0, abs=0.03)
    rows = sum(one["rows"] for one in found.summary["flights"])
    assert found.summary["degrees_of_freedom"] == found.table.num_rows - 2 < 2 * rows - 2
    assert [s.components[0].values["x1"] for s in found.systems] == [1.0, -0.5, 2.0]
    assert found.systems[0].components[0].values["a21"] == found.values["a.a21"]


def test_a_start_value_of_one_flight_can_be_found(fmu, tmp_path):
    data = [measured(tmp_path / f"{k}.csv", fmu, seed=k, prefix="a.", x1=x1) for k, x1 in enumerate((1.0, -0.5))]
    found = fit(one(fmu), data, [*FREE, "1.csv:a.x1=0.5"])
    assert found.values[f"{data[1]}:a.x1"] == pytest.approx(-0.5, abs=0.05)


def test_columns_that_are_inputs_drive_the_flight(fmu, tmp_path):
    pushed = Table(tmp_path / "u.csv", np.array([0.0, 1.0, 2.0, 4.0]), {"u": np.array([0.0, 3.0, -3.0, 1.0])})
    path = measured(tmp_path / "f.csv", fmu, prefix="a.", inputs=pushed)
    found = fit(one(fmu), [path])
    assert found.values["a.a21"] == pytest.approx(-5.0, abs=0.05)
    assert found.summary["flights"][0]["inputs"] == ["a.u"] and "a.u" not in found.summary["signals"]


def test_noise_that_is_given_weighs(fmu, tmp_path):
    path = measured(tmp_path / "f.csv", fmu, prefix="a.")
    found = fit(one(fmu), [path], signals={f"a.{name}": size for name, size in NOISE.items()})
    assert 0.5 < found.summary["reduced_chi_square"] < 1.6
    assert found.summary["signals"]["a.y"]["noise_from"] == "given"
    small_noise = fit(one(fmu), [path], signals={"a.y": 0.002})
    assert any("times as large as the noise that you gave" in text for text in small_noise.summary["warnings"])


def test_parameters_that_the_signals_do_not_show_are_named(fmu, tmp_path):
    path = measured(tmp_path / "f.csv", fmu, prefix="a.")
    found = fit(one(fmu), [path], ["a.a21", "a.b1"])
    assert found.intervals_95["a.b1"] is None and found.intervals_95["a.a21"] is not None
    assert found.summary["warnings"][0] == "a.b1 cannot be identified: no signal depends on it."
    both = fit(one(fmu), [path], ["a.c1", "a.x1", "a.x2"], signals=["a.y"])  # c1 x1 and c1 x2 are all that is shown
    assert set(both.intervals_95.values()) == {None} or both.intervals_95["a.x2"] is None
    assert both.intervals_95["a.c1"] is both.intervals_95["a.x1"] is None
    assert any("the signals do not tell it from" in text for text in both.summary["warnings"])


def test_a_value_at_its_bound_has_no_interval(fmu, tmp_path):
    found = fit(one(fmu), [measured(tmp_path / "f.csv", fmu, prefix="a.")], ["a.a21=-4:-4.5:-3", "a.a22=-0.3"])
    assert found.values["a.a21"] == -4.5 and found.intervals_95["a.a21"] is None
    assert any("a.a21 is at its lower bound -4.5" in text for text in found.summary["warnings"])
    assert any("are not noise" in text for text in found.summary["warnings"])


def test_trial_values_that_depart_are_a_penalty_and_are_told(fmu, tmp_path):
    """The oscillator runs out of all numbers where a22 is large."""
    path = measured(tmp_path / "f.csv", fmu, prefix="a.")
    found = fit(one(fmu), [path], ["a.a21", "a.a22=-0.3:-1e4:1e4"], starts=3)
    assert found.values["a.a22"] == pytest.approx(-0.4, abs=0.05) and found.finished
    assert found.summary["lost"] > 0 and any("did not come to their end" in x for x in found.summary["warnings"])


def test_a_flight_that_ends_early_with_all_values_is_told(fmu, tmp_path):
    path = measured(tmp_path / "f.csv", fmu, prefix="a.")
    late = fit(one(fmu, fault=small.FAULTS.index("error"), fault_time=3.0), [path])
    assert not late.finished and "at t = 3" in late.message
    assert late.values["a.a21"] == pytest.approx(-5.0, abs=0.1)
    with pytest.raises(RunError, match="answered Error"):
        fit(one(fmu, fault=small.FAULTS.index("refuse_init")), [path])


def test_of_several_starts_the_best_end_counts(fmu, tmp_path):
    """Frequencies far apart have valleys of their own."""
    path = measured(tmp_path / "f.csv", fmu, prefix="a.", stop=8.0)
    alone = fit(one(fmu), [path], ["a.a21=-15:-20:-1"], signals=["a.y"])
    found = fit(one(fmu), [path], ["a.a21=-15:-20:-1"], signals=["a.y"], starts=4)
    assert alone.values["a.a21"] < -10 and found.values["a.a21"] == pytest.approx(-5.0, abs=0.1)
    assert len(found.summary["starts"]) == 4
    assert min(one["cost"] for one in found.summary["starts"]) < alone.summary["starts"][0]["cost"]


@pytest.mark.parametrize("fault,limit", [("crash", None), pytest.param("hang", 1.0, marks=pytest.mark.slow)])
def test_a_trial_that_ends_its_process_counts_as_lost(fmu, fault, limit):
    """In a process of its own; the other flights are not lost with it."""
    wanted = {"a.y": np.array([0.0, 1.0])}
    plans = Plans([Plan(one(fmu), 50, wanted, None),
                   Plan(one(fmu, fault=small.FAULTS.index(fault), fault_time=0.5), 50, wanted, None)],
                  "gauss-seidel", 0.02, 0.0, None, limit)
    with flying(plans, 2) as fly:
        good, bad, again = fly([(0, {}), (1, {}), (0, {"a.a21": -5.0})])
    assert np.isfinite(good.values).all() and np.isfinite(again.values).all()
    assert np.isnan(bad.values).all() and bad.message.startswith("An FMU ended its process")


def test_the_command_writes_a_folder_and_a_command_that_flies_the_fit(fmu, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    pushed = Table(tmp_path / "u.csv", np.array([0.0, 1.0, 4.0]), {"u": np.array([0.0, 3.0, 1.0])})
    measured(tmp_path / "f.csv", fmu, inputs=pushed)
    values = [word for name, x in small.oscillator().items() if name != "x1" for word in ("--set", f"{name}={x}")]
    assert ended(["fit", str(fmu), "f.csv", "--parameter", "a21", "--parameter", "a22", *values, "--set", "f.csv:x1=1",
                  "--step", "0.02", "--json", "--workers", "1"]) == 0
    told = json.loads(capfd.readouterr().out)
    folder = tmp_path / "results" / "fit" / "small_indirect"
    assert json.loads((folder / "fit.json").read_text())["parameters"] == told["parameters"]
    assert set(told["parameters"]) == {"small_indirect.a21", "small_indirect.a22"}
    assert {path.name for path in folder.iterdir()} == {".ahv", "fit.json", "fit.parquet", "fit.png", "inputs_1.csv"}
    rows = pyarrow.parquet.read_table(folder / "fit.parquet")
    assert rows.column_names == ["flight", "time", "signal", "measured", "before", "after"] and rows.num_rows == 82
    assert ended(shlex.split(told["flights"][0]["command"])[1:]) == 0
    flown = pyarrow.parquet.read_table(tmp_path / "results" / "simulate" / "small_indirect" / "signals.parquet")
    y = flown["small_indirect.y"].to_numpy()[::5]
    assert y == pytest.approx(rows["after"].to_numpy()[:41], abs=1e-9)
