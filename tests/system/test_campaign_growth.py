"""A campaign that grows, keeps the signals of its first failures, and ends when its interval is narrow enough: byte for
byte the same however it was flown. What the runs show is made up here, but for one test."""
import json
import signal
import subprocess
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pyarrow.parquet as pq
import pytest
from campaigns import load, tables, written
from places import AHV
from test_campaign import begun as client_begun
from test_campaign import deadly
from test_cases import ahv

from cosim.campaign import cluster, engine, report
from cosim.campaign import store as stores
from cosim.campaign.receipt import Receipt
from cosim.campaign.resume import prepare
from cosim.campaign.sampling import keeps_signals
from cosim.campaign.sequential import Sequence
from cosim.campaign.store import KINDS, Store
from cosim.campaign.worker import Outcome, first_failures, requests
from cosim.errors import UsageError

FEW, MORE = {"runs": 7, "runs_per_task": 3}, {"runs": 20, "runs_per_task": 4}
RULE = {"sampling": "random", "stop_when": {"probability": "altitude", "half_width": 0.22, "confidence": 0.9},
        "success": {"altitude": "altitude_error_ft.max_abs < 2", "elevator": "elevator_deg.max < 90"}}


@cache
def planned(changes):
    with TemporaryDirectory() as folder:
        return load(written(Path(folder), **json.loads(changes)))


def made_up(plan, request):
    """What a run might show; the same for a run whenever it is asked for."""
    random = np.random.default_rng([request.run, len(request.law)])
    status = random.choice(["finished", "finished", "departed", "error"])
    outcome = Outcome(request, str(status), "", 200, None, dict.fromkeys(plan.metrics, random.random()),
                      {name: bool(random.random() < 0.7) for name in plan.campaign.success})
    time = np.arange(4.0)
    if request.envelope:
        outcome.errors = {"time": time, **{name: random.random(4).astype(np.float32) for name in plan.job.over_time}}
    if status != "error" and (request.keep or (plan.job.most_failures and not outcome.succeeded)):
        outcome.signals = {"time": time, **{name: random.random(4) for name in plan.job.record[request.law]}}
    return outcome


def fly(store, tasks=None, order=1):
    """Fly so many of the missing tasks, or all, in this order."""
    plan = store.plan
    for first, last in list(store.missing())[:tasks][::order]:
        if store.front.stopped is None:
            outcomes = (made_up(plan, request) for request in requests(plan.job, first, last))
            store.add(first, list(first_failures(outcomes, plan.job.most_failures)))


@pytest.fixture(autouse=True)
def small_groups(monkeypatch):
    monkeypatch.setattr(stores, "GROUP_ROWS", 11)


def begun(folder, resume=True, **changes):
    """The store of a campaign that is begun or continued with these fields, and what was said."""
    folder.mkdir(parents=True, exist_ok=True)
    store = Store(folder, planned(json.dumps({"stop": 2, **changes})))
    return store, prepare(store, resume, "")


def flown(folder, **changes):
    """The store of a campaign that is flown to its end."""
    store, _ = begun(folder, **changes)
    fly(store)
    store.finish()
    return store


def content(store):
    """The bytes of all that does not depend on when it was drawn."""
    return [*tables(store.folder), store.head.read_bytes(), store.receipt.read_bytes()]


@pytest.fixture(scope="module")
def at_once(tmp_path_factory):
    """The content of a campaign flown at once, by its sampling."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(stores, "GROUP_ROWS", 11)
        return {sampling: content(flown(tmp_path_factory.mktemp(sampling), sampling=sampling, **MORE))
                for sampling in ("random", "sobol")}


def test_the_tables_have_groups_of_rows_that_do_not_depend_on_tasks(tmp_path):
    file = pq.ParquetFile(flown(tmp_path, **MORE).file("runs"))
    assert [file.metadata.row_group(i).num_rows for i in range(file.num_row_groups)] == [11, 11, 11, 7]


@pytest.mark.parametrize("sampling", ["random", "sobol"])
@pytest.mark.parametrize("until", ["complete", "in parts", "killed while it grew"])
def test_grown_is_the_same_as_flown_at_once(until, sampling, at_once, tmp_path):
    if until == "in parts":
        store, _ = begun(tmp_path, sampling=sampling, **FEW)
        fly(store, 2)
    else:
        flown(tmp_path, sampling=sampling, **FEW)
    if until == "killed while it grew":
        store, _ = begun(tmp_path, sampling=sampling, **{**MORE, "runs_per_task": 5})
        assert sorted((r.first, r.last) for r in store.done.values()) == [(0, 7)]
        fly(store, 2)
    store, said = begun(tmp_path, sampling=sampling, **MORE)
    flown_already = {"complete": 7, "in parts": 6, "killed while it grew": 15}[until]
    assert store.counts()[0] == 2 * flown_already and not any("flown again" in text for text in said)
    fly(store)
    store.finish()
    assert content(store) == at_once[sampling] and not store.parts.exists()


@pytest.mark.parametrize("moved", [0, 2, len(KINDS)])
def test_a_kill_while_the_tables_become_a_part_loses_nothing(moved, at_once, tmp_path, monkeypatch):
    flown(tmp_path, **FEW)
    left, replace, unlink = [moved], Path.replace, Path.unlink

    def dies(self, *words, **more):
        if self.suffix == ".parquet" and not self.name.startswith("."):
            left[0] -= 1
            if left[0] < 0:
                raise KeyboardInterrupt
        return replace(self, *words, **more)

    with monkeypatch.context() as patched, pytest.raises(KeyboardInterrupt):
        patched.setattr(Path, "replace", dies)
        patched.setattr(Path, "unlink", lambda self, **more: (_ for _ in ()).throw(KeyboardInterrupt)
                        if self.name == "receipt.json" else unlink(self, **more))
        begun(tmp_path, **MORE)
    store, said = begun(tmp_path, **MORE)
    assert store.counts()[0] == 14 and not any("flown again" in text for text in said)
    fly(store)
    store.finish()
    assert content(store) == at_once["sobol"]


def test_damage_in_what_was_grown_from_is_found_and_flown_again(at_once, tmp_path):
    flown(tmp_path, **FEW)
    begun(tmp_path, **MORE)
    part = tmp_path / "parts" / "runs-0000000000.parquet"
    part.write_bytes(part.read_bytes()[:-9])
    store, said = begun(tmp_path, **MORE)
    assert "runs-0000000000.parquet is damaged" in said[0] and not store.done
    fly(store)
    store.finish()
    assert content(store) == at_once["sobol"]


@pytest.mark.parametrize("tasks", [None, 2])
def test_a_campaign_cannot_shrink(tasks, tmp_path):
    store, _ = begun(tmp_path, **FEW)
    fly(store, tasks)
    if tasks is None:
        store.finish()
    with pytest.raises(UsageError, match=r"has [67] runs already and the file asks for 5: a campaign can grow, not"):
        begun(tmp_path, runs=5)
    assert json.loads(store.head.read_text())["runs"] == 7
    assert not begun(tmp_path, **FEW)[1]


def test_a_latin_hypercube_cannot_grow_and_the_reason_is_said(tmp_path):
    flown(tmp_path, sampling="latin-hypercube", correlations=[], **FEW)
    with pytest.raises(UsageError, match=r"runs has changed since, from 7 to 20\. A Latin hypercube divides each range "
                                         r"into as many strata as there are runs\.$"):
        begun(tmp_path, sampling="latin-hypercube", correlations=[], **MORE)


def test_sobol_s_advice_is_said_once_for_each_number_of_runs(tmp_path):
    advice = "Sobol draws are most even where runs is a power of 2: {} rather than {}."
    assert begun(tmp_path, resume=False, **FEW)[1] == [advice.format("4 or 8", 7)]
    fly(begun(tmp_path, **FEW)[0])
    assert begun(tmp_path, **FEW)[1] == []
    assert begun(tmp_path, **MORE)[1] == [advice.format("16 or 32", 20)]
    assert begun(tmp_path, **MORE)[1] == []


@pytest.mark.parametrize("order", [1, -1])
def test_signals_are_kept_of_the_first_failures_and_of_the_share(order, tmp_path):
    changes = {"signals": {"share": 0.2, "failures": 2}, "success": {"altitude": "altitude_error_ft.max_abs < 2"}}
    store = flown(tmp_path, **changes, **FEW)
    store, _ = begun(tmp_path, **changes, **MORE)

    fly(store, order=order)
    store.finish()
    found = pq.read_table(store.file("runs")).to_pylist()
    kept = {(r["run"], r["controller"]) for r in pq.read_table(store.file("signals")).to_pylist()}
    flew = [r for r in found if r["status"] != "error"]
    failed = {law: [r["run"] for r in flew if r["controller"] == law and not r["success"]] for law in store.plan.laws}
    assert all(len(runs) > 3 for runs in failed.values())
    assert kept == {(run, law) for law, runs in failed.items() for run in runs[:2]} | {
        (r["run"], r["controller"]) for r in flew if keeps_signals(3, r["run"], 0.2)}
    assert content(store) == content(flown(tmp_path / "once", **changes, **MORE))


def test_a_campaign_with_a_rule_ends_at_the_same_run_however_it_is_flown(tmp_path):
    whole = flown(tmp_path / "whole", **RULE, runs=60, runs_per_task=7)
    found = Receipt.read(whole.receipt)
    assert 10 <= found.last < 60 and pq.read_table(whole.file("runs")).num_rows == 2 * found.last
    store, _ = begun(tmp_path, **RULE, runs=9)
    fly(store)
    assert store.front.stopped is None
    store.finish()
    store, _ = begun(tmp_path, **RULE, runs=60, runs_per_task=55)
    fly(store, 1)   # beyond the stop, and killed before the end
    assert store.done[9].last == 55 > found.last
    store, _ = begun(tmp_path, **RULE, runs=60, runs_per_task=7)
    assert store.front.stopped == found.last and not list(store.missing())
    store.finish()
    assert content(store) == content(whole)
    before = tables(store.folder)
    store, _ = begun(tmp_path, **RULE, runs=90, runs_per_task=7)
    assert store.complete and tables(store.folder) == before


def test_the_report_has_the_rule_s_interval_and_why_the_campaign_ended(tmp_path):
    store = flown(tmp_path, **RULE, runs=60, runs_per_task=7)
    summary = report.write(store)
    stopped, law = summary["stopped"], summary["controllers"]["neural"]
    assert stopped["after_runs"] == law["runs"] == Receipt.read(store.receipt).last < summary["runs"] == 60
    assert stopped["why"] == "the interval is narrow enough" and (stopped["probability"], stopped["half_width"],
                                                                  stopped["confidence"]) == ("altitude", 0.22, 0.9)
    low, high = stopped["intervals"]["neural"]
    assert (high - low) / 2 <= 0.22
    assert law["interval_95"] == list(Sequence(0.22).interval(law["successes"], law["judged"]))
    assert "confidence sequence" in summary["interval"]
    page = (store.folder / "report.html").read_text()
    assert f"Ended after {stopped['after_runs']} runs of each law" in page and "At most 60 runs" in page
    assert f"neural: {100 * low:.2f} to {100 * high:.2f} %" in page


WRONG = {
    "no such criterion": ({"stop_when": {"probability": "altitud", "half_width": 0.1}},
                          "stop_when.probability: altitud is no criterion; there are success, altitude"),
    "draws that are not independent": ({"stop_when": {"half_width": 0.1}, "sampling": "sobol"},
                                       "stop_when: it needs sampling: random, not sobol: its confidence is that of"),
    "half a line": ({"stop_when": {"half_width": 0.5}}, "stop_when.half_width: Input should be less than 0.5, not 0.5"),
    "certainty": ({"stop_when": {"half_width": 0.1, "confidence": 1}}, "stop_when.confidence: Input should be less th"),
    "a word": ({"stop_when": {"half_width": "narrow"}}, "stop_when.half_width: Input should be a valid number"),
    "without width": ({"stop_when": {"probability": "success"}}, "stop_when: half_width is missing"),
    "half a failure": ({"signals": {"failures": 2.5}}, "signals.failures: true, false or a whole number is wanted"),
    "fewer than none": ({"signals": {"failures": -1}}, "signals.failures: true, false or a whole number is wanted"),
    "some failures": ({"signals": {"failures": "some"}}, "signals.failures: true, false or a whole number is wanted"),
}


@pytest.mark.parametrize("changes,sentence", WRONG.values(), ids=WRONG)
def test_a_wrong_rule_is_refused_with_line_and_field(changes, sentence, tmp_path):
    with pytest.raises(UsageError) as error:
        load(written(tmp_path, **{"sampling": "random", **changes}))
    assert sentence in str(error.value) and len(str(error.value).splitlines()) == 1


def test_a_rule_that_was_changed_after_results_were_seen_is_refused(tmp_path):
    flown(tmp_path, **RULE, runs=9)
    with pytest.raises(UsageError, match="stop_when has changed since"):
        begun(tmp_path, **{**RULE, "stop_when": None}, runs=9)


@pytest.mark.slow
def test_500_runs_grown_to_2000_by_other_workers_and_killed_meanwhile_equal_2000_at_once(tmp_path):
    changes = {"controllers": ["neural"], "sampling": "random", "signals": {"failures": 20}, "runs_per_task": 20}
    few, more = written(tmp_path / "few", runs=500, **changes), written(
        tmp_path / "more", runs=2000, **{**changes, "runs_per_task": 25})
    out = tmp_path / "out"
    ahv("campaign", few, "--out", out, "--workers", 2)
    client = client_begun(more, out, "--workers", "1", "--resume")
    client.send_signal(signal.SIGKILL)
    client.communicate()
    said = subprocess.run([AHV, "campaign", more, "--out", out, "--workers", "2", "--resume", "--json"], check=True,
                          capture_output=True, text=True)
    assert 0 < json.loads(said.stdout)["runs_flown_now"] < 1500
    ahv("campaign", more, "--out", tmp_path / "once", "--workers", 2)
    names = ("runs.parquet", "signals.parquet", "errors.parquet", "campaign.json", "receipt.json", "report.json")
    assert all((out / name).read_bytes() == (tmp_path / "once" / name).read_bytes() for name in names)


@pytest.mark.slow
def test_a_rule_ends_a_campaign_on_any_number_of_workers_at_the_same_run(tmp_path):
    changes = {"stop": 10, "runs": 3000, "sampling": "random", "stop_when": {"half_width": 0.12},
               "signals": {"failures": 5}}
    found = []
    for workers, size in ((1, 50), (2, 7)):
        out = tmp_path / f"out{workers}"
        file = written(tmp_path / f"file{workers}", **{**changes, "runs_per_task": size})
        printed = json.loads(ahv("campaign", file, "--out", out, "--workers", workers, "--json"))
        assert printed["stopped"]["why"] == "the interval is narrow enough"
        assert printed["runs_flown_now"] >= 2 * printed["stopped"]["after_runs"] > 100
        found.append((tables(out), (out / "receipt.json").read_bytes(), printed["stopped"]))
    assert found[0] == found[1] and 100 < found[0][2]["after_runs"] < 500


@pytest.mark.slow
def test_a_run_that_kills_its_worker_does_not_keep_a_rule_from_ending_the_campaign(tmp_path, monkeypatch):
    file = written(tmp_path, runs=3000, runs_per_task=4, controllers=["neural"], stop=1, sampling="random",
                   stop_when={"half_width": 0.2}, signals={})
    monkeypatch.setattr(engine, "fly_batch", deadly)
    store = Store(tmp_path / "out", load(file))
    store.folder.mkdir()
    prepare(store, False, "")
    with cluster.local(tmp_path / "work", 2, False) as client:
        engine.send(client, store.plan)
        engine.Engine(client, store.plan, store, lambda more, good: None).run()
    store.finish()
    rows = pq.read_table(store.file("runs"))
    assert store.front.stopped == rows.num_rows < 100 and store.counts()[0] < 300
    assert rows["status"].to_pylist()[5] == "crashed"
