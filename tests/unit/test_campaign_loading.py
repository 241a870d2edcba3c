"""What a worker does with a task, without FMUs: which runs it flies, what it keeps, how a run is said to have ended."""
import hashlib
import os
import time
from types import SimpleNamespace

import pytest

from cosim.campaign import worker
from cosim.campaign.distributions import Uniform
from cosim.campaign.sampling import Draw, Sampler, keeps_signals
from cosim.campaign.worker import LoadedSystems, Outcome, Request, keep, requests
from cosim.errors import RunError, UsageError

UNIT = Uniform(distribution="uniform", low=0, high=1)
ONE = Request(7, "law", {}, {}, False, False)


def job(**changes):
    sampler = Sampler("random", 3, 5000, 2)
    draws = {law: (Draw("plant.x", ("plant.x", "plant.y"), UNIT, factor), Draw("plant.z", ("plant.z",), UNIT))
             for law, factor in (("one", None), ("two", 10.0))}
    return SimpleNamespace(**{"sampler": sampler, "keep_share": 0.3, "systems": {"one": None, "two": None},
                              "draws": draws, "algorithm": "jacobi", "step": 0.1, "ticks": 5, "start": 2.0,
                              "timeout_s": 60.0, **changes})


def test_all_laws_fly_the_same_draws_each_with_its_own_nominal_values():
    asked = list(requests(job(), 3, 6))
    assert [(r.run, r.law) for r in asked] == [(k, law) for k in (3, 4, 5) for law in ("one", "two")]
    for one, two in zip(asked[::2], asked[1::2]):
        x, z = job().sampler.uniforms(one.run)
        assert one.drawn == {"plant.x": x, "plant.z": z} and two.drawn == {"plant.x": 10 * x, "plant.z": z}
        assert two.values == {"plant.x": 10 * x, "plant.y": 10 * x, "plant.z": z}


def test_signals_are_kept_of_a_share_and_errors_over_time_of_the_first_runs():
    asked = list(requests(job(), 1990, 2010))
    assert [r.keep for r in asked[::2]] == [keeps_signals(3, k, 0.3) for k in range(1990, 2010)]
    assert {r.keep for r in asked} == {True, False}
    assert [r.run for r in asked[::2] if r.envelope] == list(range(1990, 2000))


@pytest.mark.parametrize("status,success,succeeded", [
    ("finished", {"a": True, "b": True}, True), ("finished", {"a": True, "b": False}, False),
    ("departed", {"a": True}, False), ("timed-out", {"a": True}, False), ("error", {}, False), ("crashed", {}, False),
])
def test_a_success_reaches_the_end_and_meets_every_criterion(status, success, succeeded):
    assert Outcome(ONE, status, success=success).succeeded is succeeded


def test_an_fmu_is_kept_once_and_only_with_the_content_that_its_name_says(tmp_path):
    stored = f"{hashlib.sha256(b'content').hexdigest()}/X.fmu"
    keep(tmp_path, stored, b"content")
    before = (tmp_path / stored).stat().st_mtime_ns
    keep(tmp_path, stored, b"content")
    assert (tmp_path / stored).read_bytes() == b"content" and (tmp_path / stored).stat().st_mtime_ns == before
    with pytest.raises(RunError, match="arrived with another content"):
        keep(tmp_path, stored, b"other")


# --- how a run ended ----------------------------------------------------------------------------------------------


class Instance:
    """An FMU's instance."""

    def __init__(self, alive=True):
        self.alive = alive


class Systems(LoadedSystems):
    """Systems without FMUs: `flown` is what flying does."""

    def __init__(self, flown, **changes):
        super().__init__(job(**changes), None)
        self.flown = flown
        self.master = SimpleNamespace(instances=[Instance(), Instance()], columns=[])
        self.kept.kept["law"] = self.loaded = SimpleNamespace(master=self.master, close=self.unload)

    def unload(self):
        self.loaded.master = None

    def ready(self, law, values):
        return self.master

    @property
    def dropped(self):
        return [] if self.loaded.master else ["law"]

    def outcome(self, request, flight, status):
        return Outcome(request, status, flight.message)


def ended(monkeypatch, flown, **changes):
    """(the outcome of a run, which systems were unloaded)."""
    systems = Systems(flown, **changes)
    monkeypatch.setattr(worker, "fly_loaded",
                        lambda master, method, step, ticks, progress, recorder, start: flown(master, progress))
    return systems.fly(ONE), systems.dropped


def flight(message=""):
    return SimpleNamespace(finished=not message, message=message)


def late(master, progress):
    try:
        progress(1.0)
    except RunError as error:
        return flight(str(error))
    return flight()


def dead(master, progress):
    master.instances[1].alive = False
    raise RunError("answered Fatal")


def fails(error):
    def flown(master, progress):
        raise error
    return flown


@pytest.mark.parametrize("flown,status,message,dropped", [
    (lambda master, progress: flight(), "finished", "", []),
    (lambda master, progress: flight("answered Discard"), "departed", "answered Discard", []),
    (late, "finished", "", []),
    (fails(RunError("does not start")), "error", "does not start", []),
    (fails(UsageError("is not allowed")), "error", "is not allowed", []),
    (fails(ValueError("odd")), "error", "ValueError: odd", ["law"]),
    (dead, "error", "answered Fatal", ["law"]),
])
def test_how_a_run_ended(monkeypatch, flown, status, message, dropped):
    outcome, unloaded = ended(monkeypatch, flown)
    assert (outcome.status, outcome.message, unloaded) == (status, message, dropped) and outcome.request is ONE


def test_a_run_that_takes_too_long(monkeypatch):
    outcome, _ = ended(monkeypatch, late, timeout_s=-1.0)
    assert (outcome.status, outcome.message) == ("timed-out", "Took longer than timeout_s = -1 s.")


def test_the_nominal_flight_has_nothing_drawn_and_no_signals(monkeypatch):
    asked = []

    class Nominal:
        job = SimpleNamespace(timeout_s=60.0)

        def fly(self, request):
            asked.append(request)
            return Outcome(request, "finished", metrics={"a": 1.0}, signals={"time": None})

    monkeypatch.setattr(worker, "loaded", lambda key: Nominal())
    outcome = worker.fly_nominal("key", "law")
    assert asked == [Request(-1, "law", {}, {}, False, False)]
    assert (outcome.status, outcome.metrics, outcome.signals) == ("finished", {"a": 1.0}, None)


def test_a_call_that_does_not_return_ends_the_process():
    hangs = SimpleNamespace(job=SimpleNamespace(timeout_s=0.2 - worker.PATIENCE_S), fly=lambda request: time.sleep(20))
    child = os.fork()
    if child == 0:
        worker.guarded(hangs, ONE)
        os._exit(0)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 1


def test_a_call_that_returns_ends_nothing_later():
    quick = SimpleNamespace(job=SimpleNamespace(timeout_s=0.2 - worker.PATIENCE_S), fly=lambda request: "flown")
    child = os.fork()
    if child == 0:
        flown = worker.guarded(quick, ONE)
        time.sleep(0.5)
        os._exit(7 if flown == "flown" else 8)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7
