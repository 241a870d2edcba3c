"""A campaign of rare failures: flown by levels, the same whoever flies what; its report; what its file may not say."""
import json
import os
import re
import shlex
import signal
import subprocess
import sys
import time
import zipfile

import numpy as np
import pyarrow.parquet as pq
import pytest
import yaml
from campaigns import load
from fmpy import read_model_description
from places import AHV, ROOT
from scipy.stats import norm

import fmus
from cosim.campaign.campaign import reported
from cosim.campaign.rare_flights import fly, replayed
from cosim.campaign.resume import prepare
from cosim.campaign.store import Store
from cosim.campaign.worker import JOBS, LOADED, LoadedSystems, fly_batch, keep
from cosim.cli.campaign import table
from cosim.errors import RunError, UsageError

FILE = {"name": "rare", "scenario": "hold", "stop": 0.1, "seed": 3,
        "dispersions": {"plant.h_start": {"distribution": "normal", "mean": 85000, "std": 3},
                        "plant.mass": {"distribution": "normal", "mean": 300, "std": 3}},
        "success": {"low": "max(plant.h) < 85006"},
        "rare": {"failure": "low", "runs_per_level": 100, "most_levels": 6}}
SPRING = {"name": "spring", "system": "Spring.fmu", "stop": 1.0, "step": 0.05, "seed": 1,
          "dispersions": {"Spring.mass": {"distribution": "normal", "mean": 2, "std": 0.2},
                          "Spring.stiffness": {"distribution": "log-normal", "median": 50, "sigma": 0.1},
                          "Spring.damping": {"distribution": "uniform", "low": 2, "high": 6},
                          "Spring.position_start": {"distribution": "normal", "mean": 0.1, "std": 0.02}},
          "correlations": [{"draws": ["Spring.mass", "Spring.stiffness"], "coefficient": 0.4}],
          "metrics": {"swing": "-min(Spring.position)"}, "success": {"small": "swing < 0.11"},
          "rare": {"failure": "small"}}


def written(folder, **changes):
    """A campaign file in `folder`; a field that is None is left out."""
    folder.mkdir(exist_ok=True)
    content = {name: value for name, value in {**FILE, **changes}.items() if value is not None}
    (folder / "campaign.yaml").write_text(yaml.dump(content, sort_keys=False))
    return folder / "campaign.yaml"


class Here:
    """Flies batches in this process; as an engine does, in any order."""

    def __init__(self, store, folder):
        self.store, self.job, self.flown = store, store.plan.job, 0
        JOBS[self.job.key] = self.job
        for stored, path in store.plan.fmus.items():
            keep(folder, stored, path.read_bytes())
        self.systems = LoadedSystems(self.job, folder)

    def run(self, batches):
        LOADED[:] = [self.systems]
        try:
            for batch in reversed(batches):
                flown = fly_batch(self.job.key, batch.first, batch.last, None, batch.points)
                batch.outcomes.update(enumerate(flown))
                self.store.add(batch.first, flown)
                self.flown += len(flown)
        finally:
            LOADED.clear()


def flown(file, out, fmu_folder, stop_after=None):
    """(store, runs flown now) of the campaign in `file`, continued; cut off after so many runs."""
    store = Store(out, load(file))
    out.mkdir(exist_ok=True)
    prepare(store, True, file.read_text())
    engine = Here(store, fmu_folder)
    if stop_after:
        run = engine.run

        def cut(batches):
            if engine.flown >= stop_after:
                raise KeyboardInterrupt
            run(batches)
        engine.run = cut
    try:
        fly(engine, store.plan, store)
    finally:
        engine.systems.close()
    store.finish()
    return store, engine.flown


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """(file, folder, report) of a campaign flown at once."""
    folder = tmp_path_factory.mktemp("rare")
    file = written(folder)
    store, _ = flown(file, folder / "out", folder / "fmus")
    return file, folder / "out", reported(store), folder / "fmus"


def test_the_estimate_fits_the_exact_probability_and_its_rows(whole):
    _, out, report, _ = whole
    found = report["rare"]
    assert found["interval_95"][0] < norm.sf(2) < found["interval_95"][1]  # the flight of 0.1 s hardly climbs
    rows = pq.read_table(out / "runs.parquet")
    assert found["runs"] == rows.num_rows == 100 * len(found["levels"]) and 200 <= found["runs"] <= 600
    margins, success = rows["margin"].to_numpy(), rows["success.low"].to_numpy()
    assert ((margins > 0) == success).all() and not success.all()
    levels = pq.read_table(out / "levels.parquet")
    assert levels["level"].to_pylist() == [k // 100 + 1 for k in range(rows.num_rows)]
    assert levels["margin"].to_pylist() == margins.tolist() and levels["weight"].null_count == rows.num_rows
    assert next(iter(found["drivers"])) == "plant.h_start" and found["drivers"]["plant.h_start"] > 1.8


def test_the_report_says_how_many_plain_runs_that_is_and_repeats_a_failure(whole, tmp_path):
    _, out, report, _ = whole
    assert json.loads((out / "report.json").read_text()) == {k: v for k, v in report.items() if k != "report"}
    text = re.sub("<script.*?</script>", "", (out / "report.html").read_text(), flags=re.DOTALL)
    assert f"{report['rare']['plain_runs']:,.0f}" in text and "has the margins of each level" in text
    line = text.split('<pre tabindex="0">')[1].split("</pre>")[0].replace("&#x27;", "'")
    said = subprocess.run([AHV, *shlex.split(line)[1:], "--record", "plant.h", "--out", tmp_path / "run"],
                          capture_output=True, text=True, cwd=ROOT)
    assert said.returncode == 0, said.stderr
    lines = table({**report, "wall_s": 1.0})
    assert f"{report['rare']['probability']:.3g}" in lines["failure of low"]
    assert f"as many as {report['rare']['plain_runs']:,.0f} plain runs" in lines["runs"]


def test_cut_off_and_continued_with_other_tasks_it_gives_the_same_bytes(whole, tmp_path):
    file, out, _, fmu_folder = whole
    with pytest.raises(KeyboardInterrupt):
        flown(file, tmp_path / "out", fmu_folder, stop_after=120)
    other = written(tmp_path / "other", runs_per_task=3)
    store, now = flown(other, tmp_path / "out", fmu_folder)
    reported(store)
    assert 0 < now < pq.read_metadata(out / "runs.parquet").num_rows
    for name in ("runs.parquet", "levels.parquet", "report.json"):
        assert (tmp_path / "out" / name).read_bytes() == (out / name).read_bytes(), name


def test_a_complete_campaign_is_not_flown_again(whole):
    file, out, _, _ = whole
    store = Store(out, load(file))
    assert prepare(store, True, file.read_text()) == [] and store.complete


def test_rows_of_other_points_are_refused(whole):
    file, out, _, _ = whole
    rows = pq.read_table(out / "runs.parquet")
    store = Store(out, load(written(out.parent / "other", seed=4)))
    with pytest.raises(RunError, match=r"does not have the run 0 that this campaign asks for"):
        replayed(store, rows)
    with pytest.raises(RunError, match=r"does not have the run \d+ that this campaign asks for"):
        replayed(Store(out, load(file)), rows.slice(0, rows.num_rows - 100))


def test_by_cross_entropy_the_last_level_has_weights(tmp_path):
    file = written(tmp_path, rare={"method": "cross-entropy", "runs_per_level": 100, "most_levels": 6})
    store, _ = flown(file, tmp_path / "out", tmp_path / "fmus")
    found = reported(store)["rare"]
    levels = pq.read_table(store.folder / "levels.parquet").to_pylist()
    last = [row for row in levels if row["weight"] is not None]
    assert {row["level"] for row in last} == {len(found["levels"])} and len(last) == 100
    assert sum(row["weight"] for row in last if row["margin"] <= 0) / 100 == pytest.approx(found["probability"])
    assert 0.2 < found["probability"] / norm.sf(2) < 5


def test_without_a_failure_the_reason_is_told(tmp_path):
    file = written(tmp_path, success={"low": "max(plant.h) < 99000"}, rare={"runs_per_level": 100, "most_levels": 1})
    store, _ = flown(file, tmp_path / "out", tmp_path / "fmus")
    report = reported(store)
    assert report["rare"]["probability"] is None and report["rare"]["interval_95"] == [0, 1]
    reason = "no failure was reached within most_levels = 1"
    assert table({**report, "wall_s": 1.0})["failure of low"] == f"no estimate: {reason}"
    assert f"There is no estimate: {reason}" in (store.folder / "report.html").read_text()


CHOICE = {"distribution": "choice", "values": [290, 300, 310]}
WRONG = {
    "a criterion that there is not": ({"rare": {"failure": "lwo"}},
                                      "rare.failure: there is no lwo in success; did you mean low?"),
    "a method that there is not": ({"rare": {"method": "magic"}}, "rare.method: Input should be 'subset-simulation'"),
    "a field that there is not": ({"rare": {"runs": 5}}, "rare.runs: there is no such field"),
    "few runs": ({"rare": {"runs_per_level": 50}}, "rare.runs_per_level: Input should be greater than or equal to 100"),
    "runs that have no tenth": ({"rare": {"runs_per_level": 105}}, "runs_per_level: Input should be a multiple of 10"),
    "no levels": ({"rare": {"most_levels": 0}}, "rare.most_levels: Input should be greater than or equal to 1"),
    "a number": ({"rare": 5}, "rare: "),
    "runs": ({"runs": 5000}, "runs: rare flies 100 runs_per_level and 6 most_levels: leave runs out"),
    "sampling": ({"sampling": "sobol"}, "sampling: rare chooses its own points: sobol does not belong here"),
    "a rule to stop": ({"stop_when": {"half_width": 0.1}}, "stop_when: rare ends by itself"),
    "two laws": ({"controllers": ["neural", "backstepping"]},
                 "rare: it flies one system at a time, not neural, backstepping: write a file for each"),
    "a choice": ({"dispersions": {**FILE["dispersions"], "plant.mass": CHOICE}},
                 "dispersions: rare needs continuous distributions, and plant.mass has steps"),
    "a comparison without a margin": ({"success": {"low": "max(plant.h) == 85006"}},
                                      "success.low: max(plant.h) == 85006 is met or not, with nothing between"),
    "a metric called margin": ({"metrics": {"margin": "max(plant.h)"}}, "metrics.margin: there is a column"),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_a_file_of_rare_failures_may_not_say(case, tmp_path):
    changes, sentence = WRONG[case]
    with pytest.raises(UsageError) as caught:
        load(written(tmp_path, **changes))
    assert sentence in str(caught.value) and "campaign.yaml, line " in str(caught.value)


def spring(folder):
    """A campaign of the example's spring, in `folder`."""
    made = fmus.build(ROOT / "docs" / "examples" / "spring_model.py", "native", folder / "built")
    made.rename(folder / "Spring.fmu")
    (folder / "spring.yaml").write_text(yaml.dump(SPRING, sort_keys=False))
    return folder / "spring.yaml"


def plain_runs(folder):
    """A function that flies Spring.fmu in `folder` at values (runs, 4): how far it swings back, m, shape (runs,)."""
    program, place = folder / "plain_runs", folder / "unpacked"
    subprocess.run([sys.executable, "-m", "ziglang", "cc", "-O2", f"-I{ROOT / 'fmus' / 'headers'}",
                    ROOT / "tests" / "system" / "plain_runs.c", "-o", program, "-ldl"], check=True)
    with zipfile.ZipFile(folder / "Spring.fmu") as archive:
        archive.extractall(place)
    known = read_model_description(str(folder / "Spring.fmu"))
    references = {v.name: str(v.valueReference) for v in known.modelVariables}
    words = [program, place / "binaries" / "linux64" / "Spring.so", known.guid, (place / "resources").as_uri(), "20",
             "0.05", *(references[name] for name in ("position", "mass", "stiffness", "damping", "position_start"))]

    def swings(values):
        done = subprocess.run(words, input=values.tobytes(), capture_output=True, check=True)
        return -np.frombuffer(done.stdout)

    return swings


@pytest.mark.slow
def test_a_million_plain_runs_of_a_spring_confirm_the_estimate(tmp_path):
    file = spring(tmp_path)
    out = tmp_path / "out"
    subprocess.run([AHV, "campaign", file, "--out", out, "--workers", "2"], check=True, capture_output=True)
    found = json.loads((out / "report.json").read_text())["rare"]
    rows, swings = pq.read_table(out / "runs.parquet").to_pydict(), plain_runs(tmp_path)
    assert swings(np.column_stack([rows[name] for name in SPRING["dispersions"]])).tolist() == rows["swing"]
    plan, failures, total = load(file), 0, 1_000_000
    for first in range(0, total, 50_000):
        points = plan.job.sampler.points(first, first + 50_000)
        drawn = np.array([[d.value(float(u)) for d, u in zip(plan.draws["Spring"], point)] for point in points])
        failures += int((swings(drawn) >= 0.11).sum())
    plain, (low, high) = failures / total, found["interval_95"]
    print(f"plain: {failures} of {total}; {found['method']}: {found['probability']:.3g} ({low:.3g} to {high:.3g}), "
          f"{found['runs']} runs, as {found['plain_runs']:.0f} plain ones")
    assert low < plain < high
    assert abs(found["probability"] / plain - 1) < 3 * found["coefficient_of_variation"]
    assert found["plain_runs"] > 5 * found["runs"]


@pytest.mark.slow
def test_killed_and_resumed_with_another_number_of_workers_it_gives_the_same_bytes(tmp_path):
    file = spring(tmp_path)
    words = [AHV, "campaign", file, "--workers"]
    subprocess.run([*words, "2", "--out", tmp_path / "whole"], check=True, capture_output=True)
    out = tmp_path / "killed"
    flying = subprocess.Popen([*words, "2", "--out", out], start_new_session=True, stderr=subprocess.DEVNULL)
    while len(list(out.glob("parts/receipt-*"))) < 150:
        assert flying.poll() is None
        time.sleep(0.05)
    os.killpg(flying.pid, signal.SIGKILL)
    flying.wait()
    subprocess.run([*words, "1", "--out", out, "--resume"], check=True, capture_output=True)
    for name in ("runs.parquet", "levels.parquet", "report.json", "campaign.json"):
        assert (out / name).read_bytes() == (tmp_path / "whole" / name).read_bytes(), name
