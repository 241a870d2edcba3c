"""A run that is saved at its stop and gone on from later is the run that was not interrupted."""
import json
from dataclasses import replace

import numpy as np
import pytest
import small
import small3

import cosim
from cosim.errors import UsageError
from cosim.master.flight import fly
from cosim.master.isolated import fly_isolated
from cosim.master.saved import load
from cosim.master.system import Component, Connection, System
from cosim.vehicle import scenarios
from cosim.vehicle.closed_loop import closed_loop


@pytest.fixture(scope="module")
def system(tmp_path_factory):
    fmu, events = (small3.build(tmp_path_factory.mktemp("saved"), events=events) for events in (False, True))
    parts = Component("a", fmu, {"period": 0.3, "text_in": "words"}), Component("b", events, {"x1": -0.5})
    return System(parts, (Connection("a.y", "b.u"), Connection("b.y", "a.u", 0.5), Connection("a.count", "b.level_in")))


@pytest.mark.parametrize("flown", [fly, fly_isolated, lambda *a, **k: fly(*a, **k, plain=True)])
@pytest.mark.parametrize("algorithm", ["gauss-seidel", "jacobi,hold=linear", "multi-rate,b=2,hold=linear", "iterated"])
def test_the_rest_is_equal_to_the_last_bit(system, tmp_path, algorithm, flown):
    whole = flown(system, 0.1, 2.0, algorithm)
    flown(system, 0.1, 1.2, algorithm, save=tmp_path / "at.state")
    rest = flown(system, 0.1, 2.0, algorithm, restore=tmp_path / "at.state")
    assert rest.finished and rest.ticks == 8 and len(rest.time) == 9
    assert np.array_equal(rest.time, whole.time[-9:]) and np.array_equal(rest.signals, whole.signals[-9:])
    assert rest.parameters["a"]["period"] == 0.3


def test_another_step_an_other_algorithm_and_other_signals_may_follow(system, tmp_path):
    saved = tmp_path / "at.state"
    fly(system, 0.1, 1.0, save=saved, record=["a.y"])
    for algorithm in ("variable", "jacobi"):
        flight = fly(system, 0.025, 2.0, algorithm, restore=saved, record=["b.y", "a.y1"])
        fine = fly(system, 0.025, 2.0)
        assert flight.finished and flight.time[[0, -1]].tolist() == [1.0, 2.0]
        assert flight["b.y"][-1] == pytest.approx(fine["b.y"][-1], abs=0.1)


def test_the_vehicle_flies_on(tmp_path):
    loop = closed_loop(scenarios.load("case1")).system
    whole = cosim.fly(loop, 0.01, 2.0, progress=False)
    cosim.fly(loop, 0.01, 1.0, save=str(tmp_path / "at.state"), progress=False)
    rest = cosim.fly(loop, 0.01, 2.0, restore=str(tmp_path / "at.state"), progress=False)
    assert np.array_equal(rest.signals, whole.signals[100:])


def test_what_cannot_be_saved_or_restored_is_refused(system, tmp_path):
    saved = tmp_path / "at.state"
    assert fly(system, 0.1, 1.0, save=saved).finished
    more = system.components[1].with_values({"x1": 0.0})
    for other, arguments, words in (
            (small.pair(small.build(tmp_path)), {"save": saved}, "left, right cannot give one: the FMU does not claim"),
            (system, {"restore": tmp_path / "none"}, "There is no file .*none"),
            (system, {"restore": saved, "stop": 1.0}, r"--stop 1 s must be after"),
            (system, {"restore": saved, "start": 0.5}, r"--start 0.5 s is not 1 s, where .*at.state was saved"),
            (replace(system, connections=()), {"restore": saved}, "was saved by a system of other connections"),
            (System((system.components[0], replace(more, fmu=system.components[0].fmu)), system.connections),
             {"restore": saved}, "was saved by a system of other FMUs")):
        with pytest.raises(UsageError, match=words):
            fly(other, 0.1, **{"stop": 2.0, **arguments})
    for content in (b"", b"PK\3\4 no archive", json.dumps({"about": 1}).encode()):
        saved.write_bytes(content)
        with pytest.raises(UsageError, match=r"at\.state is no run that was saved here"):
            load(saved)
    np.savez(saved.open("wb"), about=np.array("{}"))
    with pytest.raises(UsageError, match="is no run that was saved here"):
        load(saved)
