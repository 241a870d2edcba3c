"""Time, internal steps and hidden states, as both flavours give them to a model."""
import math

import clock_model
import pytest
from fmpy.fmi1 import FMICallException
from native_loop import Loaded

from fmus.builder import build

SHOWN = ("now", "steps", "times", "length")


@pytest.fixture(scope="module", params=["native", "python"])
def clock(request, tmp_path_factory):
    with Loaded(build(clock_model, request.param, tmp_path_factory.mktemp("clock"))) as member:
        member.native = request.param == "native"
        member.fresh = member.slave.getFMUState()
        yield member


def begun(clock, start=0.0, stop=None, **values):
    clock.slave.setFMUState(clock.fresh)
    clock.slave.setupExperiment(startTime=start, stopTime=stop)
    clock.slave.enterInitializationMode()
    clock.set(**values)
    clock.slave.exitInitializationMode()


def test_outputs_are_those_of_the_start_time_and_then_of_the_end_of_the_step(clock):
    begun(clock, start=3.0)
    assert clock.get(*SHOWN) == [3.0, 0.0, 0.0, 0.0]
    clock.slave.doStep(3.0, 0.1)
    assert clock.get(*SHOWN) == [3.1, 1.0, 3.0, 0.1]


def test_internal_steps_are_equal_begin_in_the_step_and_are_no_longer_than_allowed(clock):
    begun(clock)
    clock.slave.doStep(2.0, 0.25)
    assert clock.get(*SHOWN) == pytest.approx([2.25, 3.0, 6.25, 0.25 / 3], rel=1e-15)


@pytest.mark.parametrize("step, count", [(0.1, 1), (0.1 * (1 + 1e-10), 1), (0.1 * (1 + 1e-8), 2), (0.3, 3), (0.05, 1),
                                         (0.7, 7), (0.1 + 0.2, 3)])
def test_a_step_is_divided_as_far_as_needed_and_rounding_is_no_need(clock, step, count):
    begun(clock)
    clock.slave.doStep(0.0, step)
    assert clock.get("steps", "length") == [count, pytest.approx(step / count, rel=1e-15)]


def test_the_most_internal_steps_are_ten_million(clock):
    begun(clock, internal_step=1e-6)
    with pytest.raises(FMICallException):
        clock.slave.doStep(0.0, 10.001)
    assert clock.get(*SHOWN) == [0.0] * 4
    if clock.native:  # Python takes seconds for them
        clock.slave.doStep(0.0, 10.0)
        assert clock.get("steps") == [10_000_000.0]


def test_steps_of_another_length_are_prepared_anew(clock):
    begun(clock)
    for k, step in enumerate((0.1, 0.05, 0.1, 0.2)):
        clock.slave.doStep(float(k), step)
        assert clock.get("length") == [min(step, 0.1)]


def test_the_stop_time_may_be_reached_with_the_rounding_of_summed_steps_and_no_more(clock):
    begun(clock, stop=1.0)
    clock.slave.doStep(0.9, 0.1 + 0.9e-7)
    with pytest.raises(FMICallException):
        clock.slave.doStep(0.9, 0.1 + 1.2e-7)
    begun(clock)
    clock.slave.doStep(1e6, 0.1)
    begun(clock, start=1.0, stop=1.0)


def test_outputs_that_were_read_before_the_start_time_was_known_are_those_of_the_start_time_after(clock):
    clock.slave.setFMUState(clock.fresh)
    assert clock.get("now") == [0.0]
    clock.slave.setupExperiment(startTime=3.0)
    assert clock.get("now") == [3.0]
    clock.set(hidden_start=2.0)
    clock.slave.enterInitializationMode()
    clock.slave.exitInitializationMode()
    assert clock.get("now") == [3.0]


def test_a_parameter_may_be_at_either_limit(clock):
    for longest in (1e-6, 1.0):
        begun(clock, internal_step=longest)
        assert clock.get("internal_step") == [longest]


def test_an_experiment_that_is_not_set_up_begins_at_0_and_has_no_end(clock):
    clock.slave.setFMUState(clock.fresh)
    clock.slave.enterInitializationMode()
    clock.slave.exitInitializationMode()
    assert clock.get("now") == [0.0]
    clock.slave.doStep(1e6, 0.1)


@pytest.mark.parametrize("hidden, growth", [(1e308, 10.0), (-1e308, 10.0), (1e308, -10.0)])
def test_a_hidden_state_that_is_no_number_is_no_state(clock, hidden, growth):
    begun(clock, hidden_start=hidden, growth=growth)
    before = clock.get(*SHOWN)
    with pytest.raises(FMICallException):
        clock.slave.doStep(0.0, 0.1)
    assert clock.get(*SHOWN) == before
    clock.set(growth=0.1)
    clock.slave.doStep(0.0, 0.1)
    assert clock.get("steps") == [1.0]


@pytest.mark.parametrize("time", [-1e9 - 1.0, 1e9 + 1.0])
def test_an_output_beyond_either_limit_refuses_step_and_start(clock, time):
    begun(clock)
    with pytest.raises(FMICallException):
        clock.slave.doStep(time, 0.1)
    assert clock.get(*SHOWN) == [0.0] * 4
    with pytest.raises(FMICallException):
        begun(clock, start=time)


def test_an_output_may_reach_its_limit(clock):
    begun(clock, start=-1e9)
    clock.slave.doStep(1e9 - 1.0, 1.0)
    assert clock.get("now") == [1e9]


def test_booleans_are_passed_on(clock):
    begun(clock)
    on, is_on = clock.references(["on"]), clock.references(["is_on"])
    for k, value in enumerate((True, False, True)):
        clock.slave.setBoolean(on, [value])
        clock.slave.doStep(float(k), 0.1)
        assert clock.slave.getBoolean([*on, *is_on]) == [value, value]


def test_an_output_follows_an_input_at_once_only_until_initialisation_ends(clock):
    begun(clock)
    on, is_on = clock.references(["on"]), clock.references(["is_on"])
    clock.slave.doStep(0.0, 0.1)
    clock.slave.setBoolean(on, [True])
    assert clock.slave.getBoolean(is_on) == [False] and clock.get("steps") == [1.0]


def test_a_state_put_back_continues_to_the_last_bit(clock):
    begun(clock, growth=1.5)
    clock.slave.doStep(0.0, 0.25)
    state = clock.slave.getFMUState()
    clock.slave.doStep(0.25, 0.1)
    later = clock.get(*SHOWN)
    clock.slave.setFMUState(state)
    clock.slave.doStep(0.25, 0.1)
    assert clock.get(*SHOWN) == later
    clock.slave.freeFMUState(state)


def test_a_start_that_is_not_finite_is_told(clock):
    with pytest.raises(FMICallException):
        begun(clock, growth=math.inf)
