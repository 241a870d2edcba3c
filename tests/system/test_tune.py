"""`ahv tune`: the same gains again, a smaller cost, one sentence for what cannot be tuned; the experimental laws."""
import json
import os
import signal
import subprocess

import numpy as np
import psutil
import pytest
from command import ahv
from evidence import Loaded, summary
from law_studies import flights, independent
from network_laws import IN_THEIR_PLACE
from network_laws import MODEL as NETWORK
from places import AHV
from protected_laws import MODELS

from cosim.vehicle.registry import LAWS
from cosim.vehicle.tune import tune
from cosim.vehicle.tune_flights import SETS, vehicles
from fmus.builder import build

SHORT = {"evaluations": 24, "draws": 3, "seed": 1}
REFUSED = {
    "an unknown law": (["pid"], "there are neural, resilient, backstepping"),
    "an unknown preset": (["neural", "--preset", "best"], "AhvController.fmu has no preset best; it has calibrated"),
    "unknown flights": (["neural", "--flights", "all"], "--flights all is not known; there are independent, together"),
    "an unknown gain": (["neural", "--gain", "k_gama"], "AhvController.fmu has no variable k_gama; did you mean k_ga"),
    "an output": (["neural", "--gain", "elevator"], "--gain elevator cannot be tuned: it is no real parameter of"),
    "a truth": (["neural", "--gain", "solve_trim"], "--gain solve_trim cannot be tuned: it is no real parameter of"),
    "a gain that is 0": (["resilient", "--preset", "lean"], "--gain filter_h cannot be tuned from 0, which it is"),
    "no first step": (["neural", "--sigma", "0"], "--sigma 0 is not allowed: it must be a positive number"),
    "no such file": (["mine=mine.fmu"], "There is no FMU at mine.fmu"),
}


@pytest.fixture(scope="module")
def short(native_fmus, tmp_path_factory):
    """A short tuning and its folder."""
    out = tmp_path_factory.mktemp("tune")
    return tune("backstepping", workers=1, out=out, **SHORT), out


@pytest.fixture(scope="module")
def experimental(tmp_path_factory):
    """The experimental laws as words of --controller."""
    folder = tmp_path_factory.mktemp("laws")
    models = {**MODELS, "network": NETWORK}
    return {name: f"{name}={build(model, 'native', folder)}" for name, model in models.items()}


def test_the_cost_falls_and_what_was_found_is_on_disk(short):
    found, out = short
    assert found["training_cost"] < 0.9 * found["start"]["training_cost"]
    assert found["test_cost"] <= found["start"]["test_cost"]
    assert found["evaluations"] == 22 and found["status"] == "finished"
    kept = json.loads((out / "tune.json").read_text())
    assert {**kept, "out": str(out)} == json.loads(json.dumps(found))


def test_the_same_arguments_give_the_same_gains_with_any_number_of_workers(short, tmp_path):
    found, _ = short
    again = tune("backstepping", workers=2, out=tmp_path, **SHORT)
    assert {**again, "out": found["out"]} == found
    other = tune("backstepping", workers=2, out=tmp_path, **{**SHORT, "seed": 4})
    assert other["start"]["training_cost"] != found["start"]["training_cost"]


def test_training_test_and_fresh_draws_are_apart(short):
    drawn = short[0]["draws"]
    assert {use: row["count"] for use, row in drawn.items()} == {"training": 3, "test": 6, "fresh": 12}
    phases = [vehicle.values["scenario"]["scale_lift_sine_phase"] for row in drawn.values()
              for vehicle in vehicles(SETS["independent"], row["count"], row["seed"])]
    assert len(set(phases)) == 21
    assert set(short[0]["fresh"]) == {"start", "tuned"}


@pytest.mark.parametrize("law", LAWS)
def test_the_registry_names_gains_that_can_be_tuned(law, native_fmus, tmp_path):
    found = tune(law, flights="independent", evaluations=1, draws=1, workers=1, out=tmp_path)
    assert list(found["start"]["gains"]) == list(LAWS[law].gains)


@pytest.mark.parametrize("words,sentence", REFUSED.values(), ids=REFUSED)
def test_what_cannot_be_tuned_is_refused(words, sentence, native_fmus, tmp_path):
    said = ahv("tune", *words, cwd=tmp_path, status=2)
    assert sentence in said and len(said.strip().splitlines()) == 1
    assert not list(tmp_path.rglob("tune.json"))


def test_ctrl_c_keeps_the_best_so_far(native_fmus, tmp_path):
    file = tmp_path / "tune.json"
    running = subprocess.Popen([AHV, "tune", "backstepping", "--draws", "3", "--out", tmp_path], text=True,
                               stderr=subprocess.PIPE, start_new_session=True)
    assert running.stderr
    for line in running.stderr:
        if line.startswith("11 of"):
            break
    os.killpg(running.pid, signal.SIGINT)
    said = running.stderr.read()
    assert running.wait() == 1 and f"Interrupted; the best gains so far are in {file}." in said
    kept = json.loads(file.read_text())
    assert kept["status"] == "interrupted" and kept["evaluations"] >= 11 and set(kept["gains"]) == set(
        LAWS["backstepping"].gains)


@pytest.mark.parametrize("number, status", [(signal.SIGTERM, 143), (signal.SIGINT, 1), (signal.SIGKILL, -9)])
def test_workers_that_do_not_answer_end_with_the_search(number, status, native_fmus, tmp_path):
    running = subprocess.Popen([AHV, "tune", "backstepping", "--draws", "3", "--out", tmp_path], text=True,
                               stderr=subprocess.PIPE,
                               preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
    assert running.stderr and running.stderr.readline().startswith("0 of")
    started = psutil.Process(running.pid).children(recursive=True)
    worker = next(process for process in started if "spawn_main" in " ".join(process.cmdline()))
    worker.suspend()  # as one whose FMU hangs
    running.send_signal(number)
    running.communicate(timeout=60)
    _, alive = psutil.wait_procs(started, 30)
    assert running.returncode == status and alive == []


@pytest.mark.parametrize("law", ["neural", "backstepping"])
def test_the_retuned_presets_lose_fewer_vehicles(law, native_fmus):
    before, after = ([summary(flight) for flight in flights(30, preset, law=law, stop=40)]
                     for preset in ("calibrated", "independent"))
    assert sum(f.survived and f.h < 20 for f in after) >= 2 * sum(f.survived and f.h < 20 for f in before)
    assert 13 <= sum(f.survived for f in after) < 30


@pytest.mark.parametrize("law,draw", [("neural", 4), ("backstepping", 4)])
def test_the_protection_keeps_a_vehicle_that_the_law_loses(law, draw, experimental, native_fmus):
    values = independent(5, draw + 1)[draw]
    with Loaded(law, "independent") as alone, Loaded(experimental[law], "independent") as behind:
        lost, kept = alone.fly("case1", values), behind.fly("case1", values)
        free, same = alone.fly("case1"), behind.fly("case1")
    assert not summary(lost).survived and summary(kept).survived
    alpha, limit = np.degrees(kept["plant.alpha"]), np.degrees(kept["controller.alpha_limit"])
    assert kept["controller.protecting"].any() and (alpha < limit).all()
    assert summary(same).h == pytest.approx(summary(free).h, rel=0.01)  # where nothing is held back
    assert not same["controller.protecting"].any()


def test_the_network_in_resilient_is_silent_at_lambda_0_and_adapts_above(experimental, native_fmus):
    values = independent(5, 1)[0]
    with Loaded("resilient", "quiet") as plain, Loaded(experimental["network"], "quiet") as learning:
        alone = plain.fly("case1", values, stop=20)
        silent, adapting = (learning.fly("case1", {**values, "controller": {**IN_THEIR_PLACE, "lambda_2": gain}},
                                         stop=20) for gain in (0.0, 1e4))
        assert np.array_equal(learning.fly("case1", values, stop=20)["plant.h"], alone["plant.h"])
    assert silent["controller.phi_hat_2"].max() == 0 < adapting["controller.phi_hat_2"].max()
