"""The compiled loop equals the plain one, to the last bit: every algorithm, every kind of FMU."""
import numpy as np
import pytest
import small

from cosim.master.fly import fly
from cosim.master.fmu import FmuFile
from cosim.master.system import Component
from cosim.vehicle.closed_loop import wired

ALGORITHMS = ["gauss-seidel", "jacobi", "jacobi,hold=linear", "gauss-seidel,hold=linear", "multi-rate,{slow}=5",
              "multi-rate,{slow}=2,hold=linear", "iterated", "variable,tolerance=1e-4"]


def component(name, path, preset):
    file = FmuFile.open(path)
    try:
        return Component(name, path, file.preset(preset))
    finally:
        file.close()


def loop(fmus, case):
    return wired(component("scenario", fmus["AhvScenario"], case),
                       component("controller", fmus["AhvController"], "calibrated"),
                       Component("plant", fmus["AhvPlant"]))


def same(system, step, stop, algorithm, **options):
    compiled = fly(system, step, stop, algorithm, **options)
    plain = fly(system, step, stop, algorithm, plain=True, **options)
    assert compiled.finished and plain.finished, compiled.message or plain.message
    assert compiled.time.tobytes() == plain.time.tobytes()
    assert compiled.signals.tobytes() == plain.signals.tobytes()
    return compiled


@pytest.mark.parametrize("case", ["case1", "case2", "hold"])
@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_native_flavour(native_fmus, algorithm, case):
    same(loop(native_fmus, case), 0.01, 1.0 if algorithm.startswith("variable") else 3.0,
         algorithm.format(slow="controller"))


@pytest.mark.parametrize("case", ["case1", "case2", "hold"])
@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_python_flavour(python_fmus, algorithm, case):
    same(loop(python_fmus, case), 0.01, 0.04 if algorithm.startswith("variable") else 0.2,
         algorithm.format(slow="controller"))


@pytest.mark.parametrize("variant", [{}, {"direct": None}, {"direct": True, "interpolates": True}])
@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_small_fmus(tmp_path, algorithm, variant):
    system = small.pair(small.build(tmp_path, **variant), small.build(tmp_path))
    same(system, 0.01, 1.0, algorithm.format(slow="right"))


def test_a_flight_that_ends_between_two_rows_says_when(tmp_path):
    system = small.pair(small.build(tmp_path), fault=1, fault_time=0.5)
    for options in ({"decimate": 20}, {"decimate": 20, "plain": True}, {}, {"algorithm": "iterated", "decimate": 20}):
        flight = fly(system, 0.01, 1.0, **options)
        assert (flight.ticks, flight.time[-1]) == (50, 0.4 if "decimate" in options else 0.5)
        assert flight.reached == 0.5 and "to 0.5 s in 50 steps" in flight.outcome


def test_decimated_and_picked(native_fmus):
    system = loop(native_fmus, "case1")
    full = same(system, 0.01, 1.0, "gauss-seidel")
    part = same(system, 0.01, 1.0, "gauss-seidel", record=["plant.V", "*.elevator", "plant.mass"], decimate=7)
    assert [c.name for c in part.columns] == ["controller.elevator", "plant.elevator", "plant.V", "plant.mass"]
    kept = [*range(0, 101, 7), 100]
    assert np.array_equal(part.time, full.time[kept])
    assert np.array_equal(part["plant.V"], full["plant.V"][kept])
    assert np.array_equal(part["controller.elevator"], full["controller.elevator"][kept])
    assert np.all(part["plant.mass"] == 300)
