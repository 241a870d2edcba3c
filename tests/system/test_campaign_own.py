"""Samples of one's own, grids and sweeps: what flies, and one sentence for what is wrong."""
import json
import re

import pyarrow.parquet as pq
import pytest
import yaml
from campaigns import fly_here, load

from cosim.campaign.dispersions import all_draws, all_mixings, opened, run_count, with_measured
from cosim.campaign.plan import read
from cosim.campaign.report import introduction
from cosim.campaign.resume import prepare
from cosim.campaign.store import Store
from cosim.campaign.sweep import sweep
from cosim.campaign.worker import requests
from cosim.errors import UsageError
from cosim.master.loaded import open_files
from cosim.vehicle import scenarios
from cosim.vehicle.campaigns import Laws
from cosim.vehicle.closed_loop import closed_loop
from cosim.yaml_file import Source

ROWS = "plant.mass,scenario.scale_lift,controller.k_gamma\n290,1,0.30000000000000004\n300.125,0.9,0.4\n310,1.1,0.5\n"
BASE = {"name": "own", "scenario": "case1", "controllers": ["neural"], "stop": 0.5, "correlations": [], "signals": {},
        "success": {"altitude": "altitude_error_ft.max_abs < 20"}, "runs_per_task": 2}
GRID = {"controller.k_gamma": {"low": 0.2, "high": 0.6, "points": 3}, "plant.mass": {"values": [280, 300]}}


def own(folder, rows=ROWS, **changes):
    """A campaign file with samples beside it."""
    (folder / "draws.csv").write_text(rows)
    said = {**BASE, "samples": "draws.csv", **changes}
    (folder / "campaign.yaml").write_text(yaml.dump(said, sort_keys=False))
    return folder / "campaign.yaml"


def grid(folder, dispersions=GRID, **changes):
    """A campaign file of a grid."""
    said = {**BASE, "sampling": "grid", "dispersions": dispersions, **changes}
    (folder / "campaign.yaml").write_text(yaml.dump(said, sort_keys=False))
    return folder / "campaign.yaml"


def flown(path, out):
    """The rows of a campaign that is flown in this process."""
    out.mkdir()
    store = Store(out, load(path))
    prepare(store, False, path.read_text())
    fly_here(store, out / "work")
    store.finish()
    return pq.read_table(out / "runs.parquet").to_pylist()


@pytest.fixture(scope="module")
def files():
    """The FMUs of the neural law on Case 1, opened once."""
    system = closed_loop(scenarios.load("case1"), "neural", "ideal", "native", {}, {}).system
    with open_files(system) as opened_files:
        yield system, opened_files


def uncertain(path, files):
    """What a campaign file draws, and in how many runs: all that `load` does about it, on FMUs that are open."""
    source, (system, known) = Source(path, "campaign file"), files
    campaign, _ = with_measured(source, read(source, Laws)[0])
    samples = opened(source, campaign, known)
    draws = all_draws(source, campaign, system, known, {}, samples)
    return draws, run_count(source, campaign, samples, draws), all_mixings(source, campaign, draws)


def test_rows_fly_as_they_stand_in_the_file_beside_what_is_drawn(tmp_path):
    disp = {"plant.CM_alpha": {"distribution": "triangular", "low": 0.5, "mode": 1, "high": 1.5, "relative": True}}
    rows = flown(own(tmp_path, dispersions=disp, seed=3), tmp_path / "out")
    assert [(r["plant.mass"], r["scenario.scale_lift_base"], r["controller.k_gamma"]) for r in rows] == [
        (290.0, 1.0, 0.30000000000000004), (300.125, 0.9, 0.4), (310.0, 1.1, 0.5)]
    assert {r["status"] for r in rows} == {"finished"} and len({r["plant.CM_alpha"] for r in rows}) == 3
    assert len({r["altitude_error_ft.rms"] for r in rows}) == 3


def test_the_report_names_the_samples_and_a_seed_only_of_what_is_drawn(tmp_path):
    assert ", samples draws.csv, flavour native" in introduction(load(own(tmp_path)))
    disp = {"plant.CM_alpha": {"distribution": "uniform", "low": 0.9, "high": 1.1, "relative": True}}
    both = introduction(load(own(tmp_path, dispersions=disp, seed=3)))
    assert ", samples draws.csv, seed 3, sampling random, flavour native" in both


def test_another_file_is_another_campaign(tmp_path):
    first, path = load(own(tmp_path)), tmp_path / "draws.csv"
    assert set(json.loads(first.described)["files"]) == {"draws.csv"}
    path.write_text(ROWS.replace("310", "311"))
    again = load(tmp_path / "campaign.yaml")
    assert again.job.key != first.job.key and again.campaign.runs == 3
    path.write_text(ROWS)
    fewer = load(own(tmp_path, runs=2))
    assert fewer.job.key == first.job.key and fewer.campaign.runs == 2  # which grows with --resume


def test_measured_numbers_of_a_file_are_drawn(tmp_path):
    (tmp_path / "scales.csv").write_text("scale,day\n299,1\n301.5,2\n")
    disp = {"plant.mass": {"distribution": "empirical", "file": "scales.csv", "column": "scale"}}
    plan = load(path := grid(tmp_path, disp, sampling="random", runs=20, seed=1))
    assert {request.values["plant.mass"] for request in requests(plan.job, 0, 20)} == {299.0, 301.5}
    assert "values" not in plan.described.replace('"values": []', "") and "scales.csv" in plan.described
    (tmp_path / "scales.csv").write_text("scale,day\n299,1\n301.25,2\n")
    assert load(path).job.key != plan.job.key


LIMITS = "must be between 0.3 and 300000 slug/ft"
WRONG_ROWS = {
    "a variable that is not there": (ROWS.replace("mass", "maas"), "draws.csv: column plant.maas: AhvPlant.fmu has no "
                                                                   "variable maas; did you mean mass?"),
    "a component that is not there": (ROWS.replace("plant.", "plnt."), "column plnt.mass: there is no component plnt"),
    "a component alone": (ROWS.replace("plant.mass", "plant"), "draws.csv: column plant: it is not of the form "
                                                               "COMPONENT.VARIABLE."),
    "an output": (ROWS.replace("plant.mass", "plant.V"), "row 1: plant.V is an output and cannot be set"),
    "a value outside the limits": (ROWS.replace("310,", "-310,"), "draws.csv: column plant.mass, row 3: plant.mass = "
                                                                  "-310.0 is not allowed: it must be between 0.3"),
    "a number of Python's": (ROWS.replace("310,", "3_10,"), "plant.mass in row 3 is 3_10; it must be a finite number"),
    "a value that is missing": (ROWS.replace("310,", ","), "plant.mass in row 3 is empty; it must be a finite number"),
    "no number": (ROWS.replace("310,", "heavy,"), "plant.mass in row 3 is heavy; it must be a finite number"),
    "a column twice": (ROWS.replace("controller.k_gamma", "plant.mass"), "has two columns called plant.mass"),
    "one variable by two names": (ROWS.replace("controller.k_gamma", "scenario.scale_lift_base"),
                                  "scenario.scale_lift_base is set by two columns"),
}


@pytest.mark.parametrize("case", WRONG_ROWS)
def test_wrong_samples_are_refused(tmp_path, files, case):
    rows, reason = WRONG_ROWS[case]
    with pytest.raises(UsageError) as caught:
        uncertain(own(tmp_path, rows), files)
    assert f"{tmp_path / 'campaign.yaml'}, line 11: samples: " in str(caught.value) and reason in str(caught.value)


NORMAL = {"distribution": "normal", "mean": 300, "std": 1}
WRONG_FILES = {
    "more runs than rows": (own, {"runs": 4}, "line 12: runs: draws.csv has only 3 rows"),
    "a variable that a dispersion sets as well": (own, {"seed": 1, "dispersions": {"plant.mass": NORMAL}},
                                                  "plant.mass is set by the samples already"),
    "a seed that is missing": (own, {"dispersions": {"plant.Iyy": NORMAL}}, "seed is missing"),
    "nothing uncertain": (own, {"samples": None}, "runs is missing"),
    "a way of sampling where nothing is drawn": (own, {"sampling": "sobol"}, "line 12: sampling: samples without "
                                                 "dispersions draw nothing: leave sampling out."),
    "a whole number that no double is": (grid, {"set": {"plant.mass": 2**53 + 1}}, "set.plant.mass: 9007199254740993 "
                                                                                  "is no number that a double holds"),
    "a level that no double is": (grid, {"dispersions": {"plant.mass": {"values": [1, 2**53 + 1]}}},
                                  "9007199254740993 is no number that a double holds exactly."),
    "a grid of samples": (own, {"sampling": "grid"}, "a grid takes no samples"),
    "no such file": (own, {"samples": "drwas.csv"}, "There is no file"),
    "correlated columns": (own, {"correlations": [{"draws": ["plant.mass", "controller.k_gamma"], "coefficient": 0.5}]},
                           "correlations.0: plant.mass is not drawn"),
    "a grid of a normal one": (grid, {"dispersions": {"plant.mass": NORMAL}},
                               "dispersions.plant.mass: a grid takes values, or low, high and points"),
    "a grid without points": (grid, {"dispersions": {"plant.mass": {"low": 280, "high": 300}}}, "points is missing"),
    "a grid beyond the limits": (grid, {"dispersions": {"plant.mass": {"values": [280, -1]}}}, LIMITS),
    "points without a grid": (grid, {"sampling": "sobol", "runs": 4, "seed": 1, "dispersions": {
        "plant.mass": {"distribution": "uniform", "low": 280, "high": 300, "points": 3}}},
        "points is for sampling: grid"),
    "a grid that is correlated": (grid, {"correlations": [{"draws": list(GRID), "coefficient": 0.5}]},
                                  "a grid takes no correlations"),
    "more runs than points": (grid, {"runs": 7}, "runs: the grid has only 6 points"),
    "no column": (grid, {"sampling": "random", "runs": 4, "seed": 1, "dispersions": {"plant.mass": {
        "distribution": "empirical", "file": "campaign.csv", "column": "x"}}}, "There is no file"),
    "a normal truth": (grid, {"sampling": "random", "runs": 4, "seed": 1, "dispersions": {"plant.start_at_trim": {
        "distribution": "scipy", "name": "norm"}}}, "takes the distribution choice or integer, not scipy"),
}


@pytest.mark.parametrize("case", WRONG_FILES)
def test_a_wrong_campaign_of_samples_or_a_grid_is_refused(tmp_path, files, case):
    make, changes, reason = WRONG_FILES[case]
    with pytest.raises(UsageError) as caught:
        uncertain(make(tmp_path, **changes), files)
    assert reason in str(caught.value), caught.value


def test_a_sweep_writes_a_campaign_that_flies_again_and_draws_it(tmp_path):
    metric = "climb=final(plant.h) - min(plant.h)"
    words = ["controller.k_gamma=0.2:0.6:3", "plant.mass=280,300"]
    summary = sweep({"name": "two", "scenario": "case1", "stop": 0.5}, words, [metric], ["climb < 0"], tmp_path / "out",
                    workers=1, subjects=[Laws])
    least, greatest = summary["grid"]["neural"]["climb"].values()
    rows = pq.read_table(tmp_path / "out" / "runs.parquet").to_pylist()
    assert [(r["controller.k_gamma"], r["plant.mass"]) for r in rows] == [
        (k, m) for k in (0.2, 0.4, 0.6) for m in (280.0, 300.0)]
    assert summary["runs"] == 6 and summary["controllers"]["neural"]["successes"] == 0
    assert greatest["value"] > least["value"] >= 0 and set(least["at"]) == {"controller.k_gamma", "plant.mass"}
    assert (tmp_path / "out" / "figures" / "sweep_climb.png").stat().st_size > 10_000
    page = re.sub("<script.*?</script>", "", (tmp_path / "out" / "report.html").read_text(), flags=re.DOTALL)
    assert 'id="sweep"' in page and "Least and greatest" in page and "95 % interval" not in page
    again = load(tmp_path / "out" / "campaign.yaml")
    assert json.loads(again.described) == json.loads((tmp_path / "out" / "campaign.json").read_text())


WRONG_WORDS = {
    "controller.k_gama=1,2": "controller.k_gama: AhvController.fmu has no variable k_gama; did you mean k_gamma?",
    "k_gamma=1,2": "k_gamma=1,2 is not of the form COMPONENT.VARIABLE=A:B:N or COMPONENT.VARIABLE=V1,V2,...",
    "controller.k_gamma=": "controller.k_gamma= is not of the form",
    "controller.k_gamma=1:2": "controller.k_gamma=1:2: 1:2 is neither a value nor A:B:N.",
    "controller.k_gamma=1,,2": "controller.k_gamma=1,,2: a value is missing.",
    "controller.k_gamma=1:2:0": "0 must be how many values there are from 1 to 2, 2 or more.",
    "controller.k_gamma=1:2:2.5": "2.5 must be how many values",
    "controller.k_gamma=2:1:3": "2 must be below 1.",
    "controller.k_gamma=a:1:3": "a and 1 must be numbers.",
    "controller.k_gamma=1,a": "controller.k_gamma: values must be all numbers, all truths or all words.",
    "controller.k_gamma=0.2,-1": "controller.k_gamma = -1.0 is not allowed: it must be between 0 and inf 1/s.",
    "controller.k_gamma=\ud800": "This is no sweep: half of a pair of code units",
    "controller.k_gamma=1,1": "controller.k_gamma: a value is given twice.",
}


@pytest.mark.parametrize("word", WRONG_WORDS)
def test_a_wrong_word_of_a_sweep_is_refused_by_its_name(tmp_path, word):
    with pytest.raises(UsageError) as caught:
        sweep({"scenario": "case1"}, [word], out=tmp_path / "out", subjects=[Laws])
    assert WRONG_WORDS[word] in str(caught.value) and "line" not in str(caught.value)


@pytest.mark.parametrize("options,reason", [
    ({"variables": ["plant.mass=1,2", "plant.mass=3,4"]}, "plant.mass is given twice."),
    ({"metrics": ["a"]}, "--metric a is not of the form NAME=EXPRESSION."),
    ({"metrics": ["a=max(plant.hh)"]}, "--metric a: 'max(plant.hh)': there is no metric or signal plant.hh"),
    ({"success": ["foo < 3"]}, "--success 1: 'foo < 3': there is no"),
    ({"success": ["low=foo < 3"]}, "--success low: "),
])
def test_wrong_options_of_a_sweep_are_refused_by_their_names(tmp_path, options, reason):
    with pytest.raises(UsageError) as caught:
        sweep({"scenario": "case1"}, **{"variables": ["plant.mass=290,300"], **options}, out=tmp_path / "out",
              subjects=[Laws])
    assert str(caught.value).startswith(reason)
