"""The algorithm `variable`: its estimate of the error beside the error, and the steps that follow from it."""
from contextlib import closing, contextmanager
from functools import partial

import numpy as np
import pytest
import small

from cosim.master.algorithms.base import Experiment
from cosim.master.algorithms.variable import Variable
from cosim.master.fly import fly
from cosim.master.loaded import Master, open_files
from cosim.master.recording import Recorder
from cosim.master.system import Component, Connection, System


@pytest.fixture(scope="module")
def build(tmp_path_factory):
    return partial(small.build, tmp_path_factory.mktemp("small"))


@contextmanager
def variable(system, tolerance=1e-6, step=0.05, stop=2.0, **options):
    """The algorithm, some small steps after the start: the inputs have a slope."""
    with open_files(system) as files, closing(Master(system, files)) as master:
        master.initialise(0.0, stop)
        chosen = {"tolerance": tolerance, "hold": True, "order": None, **options}
        algorithm = Variable(master, chosen, Experiment(0.0, step, round(stop / step), Recorder(master.columns)))
        master.run(algorithm.ops, 0, 50, 0.0, 1e-3)
        algorithm.time = 0.05
        yield algorithm


def beside(algorithm, step):
    """(estimated, true) error of the step's halves at each watched signal, over what is allowed."""
    master, w = algorithm.master, algorithm.master.wiring
    begun = master.snapshot()
    master.run(algorithm.save, 0, 1, algorithm.time, 0.0)
    estimated = algorithm.error(step, begun)
    halves = w.signals[algorithm.slots]
    master.run(algorithm.restore, 0, 1, algorithm.time, 0.0)
    master.put_back(begun)
    assert algorithm.attempt(4096, step / 4096)
    true = np.abs(halves - w.signals[algorithm.slots])
    allowed = algorithm.tolerance * np.maximum(np.abs(halves), w.nominal[algorithm.slots])
    return estimated, float(np.max(true / allowed))


@pytest.mark.parametrize("hold,close", [(True, 0.15), (False, 0.3)])
@pytest.mark.parametrize("step", [0.02, 0.01])
def test_the_estimate_is_the_error_of_the_result(build, hold, close, step):
    with variable(small.pair(build()), hold=hold) as algorithm:
        estimated, true = beside(algorithm, step)
    assert estimated == pytest.approx(true, rel=close)


def test_the_error_is_relative_to_the_tolerance(build):
    found = []
    for tolerance in (1e-6, 1e-4):
        with variable(small.pair(build()), tolerance) as algorithm:
            found.append(beside(algorithm, 0.02)[0])
    assert found[0] == pytest.approx(100 * found[1])


@pytest.mark.parametrize("hold", ["linear", "constant"])
def test_the_number_of_steps_grows_with_the_cubic_root_of_the_tolerance(build, hold):
    """The error of a step is of its third order: also of one with held inputs, which push and do not move."""
    ticks = [fly(small.pair(build()), 0.002, 4.0, f"variable,tolerance={tolerance},hold={hold}").ticks
             for tolerance in (1e-7, 1e-9)]
    assert ticks[1] / ticks[0] == pytest.approx(100 ** (1 / 3), rel=0.1)


def mixed(direct, indirect):
    """left's y depends directly on its input, right's does not."""
    left, right = small.oscillator(d=0.3), small.oscillator(a21=-9.0)
    return System((Component("left", direct, left), Component("right", indirect, right)),
                  (Connection("left.y", "right.u"), Connection("right.y", "left.u", 0.8)))


def test_outputs_that_depend_directly_on_inputs_are_left_out_if_there_are_others(build):
    with variable(mixed(build(direct=True), build())) as algorithm:
        assert [algorithm.master.wiring.slots[s] for s in algorithm.slots] == ["right.y"]
        assert algorithm.power == 1 / 2  # left.y lags behind: of the first order, whatever the inputs follow
    with variable(small.pair(build(direct=True))) as algorithm:
        assert [algorithm.master.wiring.slots[s] for s in algorithm.slots] == ["left.y", "right.y"]
    with variable(small.pair(build())) as algorithm:
        assert [algorithm.master.wiring.slots[s] for s in algorithm.slots] == ["left.y", "right.y"]
        assert algorithm.power == 1 / 3
    with variable(small.pair(build()), hold=False) as algorithm:
        assert algorithm.power == 1 / 2


def test_inputs_that_every_fmu_follows_give_the_second_order_back(build):
    follows = [build(direct=True, interpolates=True), build(interpolates=True)]
    with variable(mixed(*follows)) as algorithm:
        assert algorithm.power == 1 / 3
    with variable(mixed(follows[0], build())) as algorithm:
        assert algorithm.power == 1 / 2


def test_whole_numbers_have_no_error(build):
    parts = (Component("a", build(), small.oscillator()), Component("b", build(), small.oscillator(x1=-0.5)))
    links = (Connection("a.whole_out", "b.whole_in"), Connection("a.y", "b.u"))
    with variable(System(parts, links)) as algorithm:
        assert [algorithm.master.wiring.slots[s] for s in algorithm.slots] == ["a.y"]


@pytest.mark.parametrize("error,taken", [(0.9, True), (1.2, False)])
def test_a_step_is_taken_whose_estimated_error_is_allowed(build, error, taken):
    with variable(small.pair(build())) as algorithm:
        master, before, begun = algorithm.master, algorithm.time, algorithm.master.snapshot()
        master.run(algorithm.save, 0, 1, before, 0.0)
        algorithm.tolerance *= algorithm.error(0.02, begun) / error
        master.run(algorithm.restore, 0, 1, before, 0.0)
        master.put_back(begun)
        algorithm.step = 0.02
        algorithm.take()
    step = algorithm.time - before
    assert step == pytest.approx(0.02) if taken else 0 < step < 0.0199
