"""A campaign flown on Dask: rows that depend on nothing but the file, failures as rows, kills survived."""
import base64
import json
import os
import re
import shlex
import signal
import subprocess
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from campaigns import TABLES, load, tables, written
from command import ahv as here
from places import AHV
from test_cases import ahv
from test_pages import data_in

from cosim.campaign import cluster, engine
from cosim.campaign.resume import prepare
from cosim.campaign.store import Store
from cosim.campaign.worker import JOBS, fly_batch, requests


def fly(file, out, *words, status=0):
    """What is printed; what is refused needs no process."""
    carry_out = here if status == 2 else ahv
    return carry_out("campaign", file, "--out", out, "--workers", 2, "--json", *words, status=status)


def rows(out):
    return pq.read_table(out / "runs.parquet").to_pylist()


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The campaign flown without interruption: (file, folder, what it printed)."""
    folder = tmp_path_factory.mktemp("whole")
    file = written(folder)
    return file, folder / "out", json.loads(fly(file, folder / "out"))


def test_there_is_a_row_for_each_run_and_law_and_both_laws_have_the_same_draws(whole):
    found = rows(whole[1])
    assert [(r["run"], r["controller"]) for r in found] == [
        (k, law) for k in range(24) for law in ("neural", "backstepping")]
    drawn = ("plant.mass", "plant.CM_alpha", "scenario.scale_lift_sine_phase")
    assert all([a[n] for n in drawn] == [b[n] for n in drawn] for a, b in zip(found[::2], found[1::2]))
    assert {r["status"] for r in found} == {"finished", "departed"}
    assert all("fmi2DoStep" in r["message"] and r["departed_at_s"] > 0 for r in found if r["status"] == "departed")


def test_what_is_printed_agrees_with_the_rows(whole):
    _, out, printed = whole
    for law, said in printed["controllers"].items():
        mine = [r["success"] for r in rows(out) if r["controller"] == law]
        assert (said["runs"], said["successes"]) == (len(mine), sum(mine))
        assert 0 <= said["interval_95"][0] < said["probability"] < said["interval_95"][1] <= 1
    assert sum(printed["paired"]["neural and backstepping"].values()) == 24


def test_the_report_holds_everything_inside(whole):
    text = without_scripts(whole[1] / "report.html")
    assert all(place.startswith(("data:", "#")) for place in re.findall(r"(?:src|href)=['\"]?([^'\" >]*)", text))
    assert "default-src 'none'" in text and len(list((whole[1] / "figures").glob("*.png"))) >= 5


def test_the_page_has_every_run_and_the_signals_that_were_kept(whole):
    data = data_in((whole[1] / "report.html").read_text())
    laws = [variant["name"] for variant in data["variants"]]
    numbers = np.frombuffer(base64.b64decode(data["numbers"]), "<u4")
    assert laws == ["neural", "backstepping"] and numbers.tolist() == list(range(24))
    table = pq.read_table(whole[1] / "signals.parquet").to_pylist()
    assert {(laws[one["variant"]], int(numbers[one["place"]])) for one in data["curves"]["signals"]} == {
        (row["controller"], row["run"]) for row in table}
    first = data["curves"]["signals"][0]
    low, step, steps, *_ = first["curves"]["plant.h"]
    drawn = low + step * np.frombuffer(base64.b64decode(steps), "<u2")
    flown = [row["plant.h"] for row in table if row["run"] == numbers[first["place"]]
             and row["controller"] == laws[first["variant"]]]
    assert (drawn[0], drawn[-1]) == pytest.approx((flown[0], flown[-1]), abs=step)
    assert (drawn.min(), drawn.max()) == pytest.approx((min(flown), max(flown)), abs=step)
    errors = pq.read_table(whole[1] / "errors.parquet")
    there = [len(np.frombuffer(base64.b64decode(one["runs"]), "<u4")) for one in data["curves"]["errors"]["variants"]]
    assert there == [errors["controller"].to_pylist().count(law) for law in laws]


def without_scripts(page):
    """The text of a page, but for what its scripts are."""
    return re.sub("<script.*?</script>", "", page.read_text(), flags=re.DOTALL)


def test_a_worst_run_s_command_flies_that_very_run(whole, tmp_path):
    _, out, _ = whole
    commands = re.findall(r"<pre[^>]*>(.+?)</pre>", without_scripts(out / "report.html"))
    assert len(commands) == 20
    for line in (commands[0], commands[-1]):
        words = shlex.split(line.replace("&#x27;", "'"))
        said = subprocess.run([AHV, *words[1:], "--json", "--out", tmp_path / "run"], capture_output=True, text=True)
        flown = json.loads(said.stdout)
        same = [r for r in rows(out) if r["altitude_error_ft.max_abs"] == flown["altitude_error_ft"]["max_abs"]
                and r["elevator_deg.travel"] == flown["elevator_deg"]["travel"]
                and r["departed_at_s"] == flown["departed_at_s"] and r["controller"] == flown["controller"]]
        assert len(same) == 1


def test_signals_are_kept_of_the_failures_and_of_the_share(whole):
    out = whole[1]
    kept = {(r["run"], r["controller"]) for r in pq.read_table(out / "signals.parquet").to_pylist()}
    failed = {(r["run"], r["controller"]) for r in rows(out) if not r["success"]}
    shared = {run for run, _ in kept - failed}
    assert failed < kept and 0 < len({run for run, _ in kept} | shared) < 24


def test_kept_signals_have_every_tenth_row_and_the_last(whole):
    times = {}
    for row in pq.read_table(whole[1] / "signals.parquet", columns=["run", "controller", "time"]).to_pylist():
        times.setdefault((row["run"], row["controller"]), []).append(row["time"])
    ends = {(r["run"], r["controller"]): r["departed_at_s"] or 10.0 for r in rows(whole[1])}
    assert any(ends[one] < 10 for one in times)
    for one, found in times.items():
        assert found[-1] == pytest.approx(ends[one], abs=1e-9) and found[:-1] == pytest.approx(
            [0.1 * i for i in range(len(found) - 1)], abs=1e-9) and found[-1] - found[-2] < 0.1 + 1e-9


def test_errors_over_time_are_those_of_the_signals(whole):
    signals = pq.read_table(whole[1] / "signals.parquet").to_pylist()
    ends = {(r["run"], r["controller"]): r["departed_at_s"] or 10.0 for r in rows(whole[1])}
    compared = 0
    for row in pq.read_table(whole[1] / "errors.parquet").to_pylist():
        one = row["run"], row["controller"]
        assert row["time"] == pytest.approx([0.1 * i for i in range(101) if 0.1 * i <= ends[one] + 1e-9], abs=1e-9)
        kept = [s["plant.h"] - s["controller.h_reference"] for s in signals if (s["run"], s["controller"]) == one]
        if kept:
            count = min(len(kept), len(row["time"]))
            assert row["altitude_error_ft"][:count] == pytest.approx(kept[:count], rel=1e-4, abs=1e-3)
            compared += count
    assert compared > 100


def test_only_the_final_files_stay(whole):
    assert not (whole[1] / "parts").exists() and all((whole[1] / name).exists() for name in TABLES)


def test_one_worker_and_another_division_into_tasks_give_the_same_rows(whole, tmp_path):
    file = written(tmp_path, runs_per_task=7)
    ahv("campaign", file, "--out", tmp_path / "out", "--workers", 1)
    assert rows(tmp_path / "out") == rows(whole[1])


def test_a_folder_with_another_campaign_is_left_alone(whole, tmp_path):
    before = tables(whole[1])
    assert "--resume continues it" in fly(whole[0], whole[1], status=2)
    said = fly(written(tmp_path, seed=4), whole[1], "--resume", status=2)
    assert "another campaign" in said and "seed has changed" in said
    began = time.perf_counter()
    printed = json.loads(fly(whole[0], whole[1], "--resume"))
    assert printed["runs_flown_now"] == 0 and 0 < printed["wall_s"] < time.perf_counter() - began
    assert tables(whole[1]) == before


def test_an_expression_without_a_value_on_a_law_s_nominal_flight_is_refused_before_any_run_flies(tmp_path):
    file = written(tmp_path, success={"altitude": "altitude_error_ft.max_abs < 20", "net": "phi_hat.velocity_max < 3"})
    said = fly(file, tmp_path / "out", status=2)
    line = file.read_text().splitlines().index("  net: phi_hat.velocity_max < 3") + 1
    assert said.strip().endswith(f"campaign.yaml, line {line}: success.net: 'phi_hat.velocity_max < 3' has no value on "
                                 "the nominal flight of backstepping: there is no phi_hat.velocity_max.")
    assert parts(tmp_path / "out") == 0 and not (tmp_path / "out" / "runs.parquet").exists()


def test_a_run_that_cannot_start_and_one_that_takes_too_long_are_rows(tmp_path):
    changes = {"runs": 4, "controllers": ["neural"], "flavour": "python", "stop": 100, "timeout_s": 0.3,
               "dispersions": {"plant.mass": {"distribution": "normal", "mean": 300, "std": 900}}, "seed": 1,
               "correlations": []}
    printed = json.loads(fly(written(tmp_path, **changes), tmp_path / "out"))["controllers"]["neural"]
    found = rows(tmp_path / "out")
    assert {r["status"] for r in found} == {"error", "timed-out"}
    assert printed["failures"] == {"law": 0, "machinery": 4} and printed["probability"] is None
    assert (printed["runs"], printed["judged"]) == (4, 0)
    report = without_scripts(tmp_path / "out" / "report.html")
    assert "Failures of the machinery, neural" in report and report.count("--set plant.mass=") == 4
    assert all(not r["success"] and r["message"] for r in found)
    assert any("plant.mass = " in r["message"] for r in found) and any("timeout_s = 0.3" in r["message"] for r in found)


# --- kills --------------------------------------------------------------------------------------------------------


class Cluster:
    """A scheduler and two workers by hand: processes of their own, each with a work folder of its own."""

    def __init__(self, folder):
        folder.mkdir()
        self.folder, self.processes = folder, []
        file = folder / "scheduler.json"
        self.scheduler = self.spawn("scheduler", "--port", 0, "--no-dashboard", "--scheduler-file", file)
        until(lambda: file.exists() and file.read_text().strip().endswith("}"))
        self.address = json.loads(file.read_text())["address"]
        self.workers = [self.spawn("worker", self.address, "--nthreads", 1, "--no-dashboard", "--local-directory",
                                   folder / f"host{i}") for i in range(2)]

    def spawn(self, *words):
        self.processes.append(subprocess.Popen(
            [AHV.parent / "dask", *map(str, words)], cwd=self.folder, stderr=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL, start_new_session=True))
        return self.processes[-1]

    def stop(self):
        for process in self.processes:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)  # with the processes that it started
            process.wait()


def until(true, limit=60.0):
    end = time.monotonic() + limit
    while not true():
        assert time.monotonic() < end
        time.sleep(0.02)


def children(pid):
    return [int(p) for p in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def parts(out):
    return len(list((out / "parts").glob("receipt-*"))) if (out / "parts").exists() else 0


def begun(file, out, *words):
    """A client in the middle of a campaign."""
    before = parts(out)
    client = subprocess.Popen([AHV, "campaign", file, "--out", out, *words], stderr=subprocess.PIPE,
                              stdout=subprocess.DEVNULL, text=True)
    until(lambda: parts(out) >= before + 5 or client.poll() is not None)
    assert client.poll() is None, client.stderr.read()
    return client


@pytest.fixture
def clusters(tmp_path):
    made = []
    yield lambda: made.append(Cluster(tmp_path / f"cluster{len(made)}")) or made[-1]
    for one in made:
        one.stop()


@pytest.mark.slow
def test_a_killed_worker_then_scheduler_then_client_leave_the_same_tables(clusters, tmp_path):
    file, out = written(tmp_path, runs=128, stop=40, runs_per_task=1), tmp_path / "out"
    fly(file, tmp_path / "expected")

    first = clusters()
    client = begun(file, out, "--scheduler", first.address)
    assert all(list(path.rglob("AhvController.fmu")) for path in first.folder.glob("host*"))  # each has its own
    for pid in children(first.workers[0].pid):
        os.kill(pid, signal.SIGKILL)
    seen = parts(out)
    until(lambda: parts(out) > seen + 5)
    first.scheduler.kill()
    assert client.wait(60) == 1
    said = client.stderr.read()
    assert "scheduler is gone" in said and "--resume" in said and len(said.strip().splitlines()) == 1

    client = begun(file, out, "--resume", "--workers", "2")
    workers = children(client.pid)
    client.kill()
    client.wait()
    seen = parts(out)
    until(lambda: not any(Path(f"/proc/{pid}").exists() for pid in workers))

    again = json.loads(ahv("campaign", file, "--out", out, "--scheduler", clusters().address, "--resume", "--json"))
    assert again["runs_flown_now"] == 256 - 2 * seen < 256
    assert tables(out) == tables(tmp_path / "expected")


def test_a_run_that_kills_its_worker_is_a_row_and_costs_no_other(tmp_path, monkeypatch):
    plan = load(written(tmp_path, runs=12, runs_per_task=4, controllers=["neural"], stop=1))
    monkeypatch.setattr(engine, "fly_batch", deadly)
    store = Store(tmp_path / "out", plan)
    store.folder.mkdir()
    prepare(store, False, "")
    with cluster.local(store.folder.parent / "work", 2, False) as client:
        engine.send(client, plan)
        engine.Engine(client, plan, store, lambda more, good: None).run()
    store.finish()
    assert [r["run"] for r in rows(tmp_path / "out") if r["status"] == "crashed"] == [5]
    assert len(rows(tmp_path / "out")) == 12


def deadly(key, first, last, positions=None, points=None):
    asked = list(requests(JOBS[key], first, last))
    if any(asked[i].run == 5 for i in positions or range(len(asked))):
        os.abort()
    return fly_batch(key, first, last, positions, points)
