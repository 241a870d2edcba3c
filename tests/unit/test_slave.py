"""The slave of the Python flavour on a model whose numbers can be told by heart, without pythonfmu's binary.

What the binary makes of it is in `tests/conformance/test_contract.py`.
"""
import gc
import json
import math
import sys
from types import SimpleNamespace

import pytest

from fmus.refusal import Refused, refusing
from fmus.slave import ModelSlave

ROWS = [
    ("u", "input", "1", 2.0, None, None, 1.0, "slope"),
    ("on", "input", "", False, None, None, None, "adds 100"),
    ("y", "output", "1", None, -50.0, 1000.0, 1.0, "integral of u, plus 100 if on"),
    ("now", "output", "s", None, None, 2e9, 1.0, "time"),
    ("began", "calculatedParameter", "rad", None, -5.0, None, 1.0, "where it started"),
    ("high", "output", "", None, None, None, None, "whether y > 2"),
    ("x_start", "parameter", "1", 1.0, 0.0, 10.0, None, "start of y"),
    ("angle", "parameter", "rad", 0.1, -1.0, 1.0, None, "nothing"),
    ("sure", "parameter", "", True, None, None, None, "nothing"),
    ("internal_step", "parameter", "s", 0.1, 1e-9, 1.0, None, "longest internal step"),
]
U, ON, Y, NOW, BEGAN, HIGH, X_START, ANGLE, SURE, INTERNAL_STEP = range(len(ROWS))


def made(**changed):
    """A slave, and the list of (t, h, c) with which its model was advanced."""
    calls = []

    def advance(m, t, h, x, u, p, c):
        calls.append((t, h, c))
        return [x[0] + h * u.u, x[1]]

    model = SimpleNamespace(**{
        "NAME": "Tiny", "VARIABLES": ROWS, "advance": advance,
        "start": lambda m, u, p: [p.x_start, p.angle],
        "prepare": lambda m, p, h: [h * p.x_start],
        "outputs": lambda m, t, x, u, p: {"y": x[0] + 100 * u.on, "now": t, "began": x[1], "high": x[0] > 2},
        **changed})
    return type("Tiny", (ModelSlave,), {"model": model})(instance_name="tiny"), calls


def started(start=0.0, stop=None, **changed):
    slave, calls = made(**changed)
    slave.setup_experiment(start, stop)
    slave.enter_initialization_mode()
    slave.exit_initialization_mode()
    return slave, calls


def refused(text, call, *arguments):
    with pytest.raises(Refused) as refusal:
        call(*arguments)
    assert text in str(refusal.value) and repr(refusal.value) == str(refusal.value)


def test_outputs_belong_to_the_end_of_the_step_and_internal_steps_to_their_beginnings():
    slave, calls = started(start=3.0)
    assert slave.get_real([Y, NOW, BEGAN]) == [1.0, 3.0, 0.1] and slave.get_boolean([HIGH]) == [False]
    assert slave.do_step(3.0, 0.25) is True
    assert [t for t, _, _ in calls] == pytest.approx([3.0, 3.0 + 0.25 / 3, 3.0 + 0.5 / 3])
    assert [h for _, h, _ in calls] == [0.25 / 3] * 3 and calls[0][2] == [0.25 / 3]
    assert slave.get_real([Y, NOW]) == pytest.approx([1.5, 3.25]) and slave.time == 3.25
    slave.do_step(3.25, 0.5)
    assert slave.get_boolean([HIGH]) == [True] and slave.get_real([NOW]) == [3.75]


def test_another_step_is_prepared_anew_and_the_same_is_not():
    prepared = []
    slave, calls = started(prepare=lambda m, p, h: prepared.append(h) or [h])
    for k, step in enumerate((0.1, 0.1, 0.05, 0.1)):
        slave.do_step(float(k), step)
    assert prepared == [0.1, 0.05, 0.1] and [c for _, _, c in calls] == [[0.1], [0.1], [0.05], [0.1]]


def test_a_model_without_internal_step_or_prepare_takes_the_step_as_it_is():
    slave, calls = started(VARIABLES=ROWS[:INTERNAL_STEP], prepare=None)
    del slave.model.prepare
    slave.do_step(0.0, 7.0)
    assert calls == [(0.0, 7.0, [])]


def test_the_values_before_the_start_are_those_of_what_is_set_and_of_the_start_time():
    slave, _ = made()
    assert slave.get_real([Y, NOW]) == [1.0, 0.0]
    slave.set_real([X_START], [5.0])
    assert slave.get_real([Y]) == [5.0]
    slave.setup_experiment(2.0)
    assert slave.get_real([NOW]) == [2.0]
    slave.enter_initialization_mode()
    slave.set_boolean([ON], [1])
    assert slave.get_real([Y]) == [105.0]


def test_inputs_show_in_outputs_after_the_next_step():
    slave, _ = started()
    slave.set_boolean([ON], [True])
    assert slave.get_real([Y]) == [1.0] and slave.get_boolean([ON]) == [True]
    slave.do_step(0.0, 0.1)
    assert slave.get_real([Y]) == pytest.approx([101.2])


def test_the_stop_time_may_be_reached_with_the_rounding_of_summed_steps_and_no_more():
    slave, _ = started(stop=1.0)
    slave.do_step(0.9, 0.1 + 0.9e-7)
    refused("a step to t = 1 s would go past the stop time 1 s", slave.do_step, 0.9, 0.1 + 1.2e-7)
    assert slave.time == pytest.approx(1.0)
    endless, _ = started()
    endless.do_step(1e9, 0.1)
    refused("now = 2e+09 s is above its maximum 2e+09 s", endless.do_step, 2e9, 0.1)


@pytest.mark.parametrize("step", [0.0, -0.1, math.nan, math.inf])
def test_a_step_is_a_positive_number(step):
    refused("is not a positive number", started()[0].do_step, 0.0, step)


@pytest.mark.parametrize("time", [math.nan, math.inf, -math.inf])
def test_a_communication_point_is_a_number(time):
    slave, _ = started()
    refused("the communication point is not a finite number", slave.do_step, time, 0.1)
    assert slave.get_real([Y, NOW]) == [1.0, 0.0]


def test_the_most_internal_steps_are_ten_million():
    slave, calls = made()
    slave.set_real([INTERNAL_STEP], [1e-9])
    slave.setup_experiment(0.0)
    slave.enter_initialization_mode()
    slave.exit_initialization_mode()
    refused("takes too many internal steps at t = 0 s", slave.do_step, 0.0, 0.0100001)
    assert slave.prepare(0.01)[1] == 10_000_000 and calls == []


@pytest.mark.parametrize("u, reason", [(-1000.0, "y = -98.8 is below its minimum -50"),
                                       (1e5, "above its maximum 1000")])
def test_a_step_out_of_the_models_range_leaves_all_as_it_was(u, reason):
    slave, _ = started()
    slave.do_step(0.0, 0.1)
    before = json.dumps(slave._get_fmu_state())
    slave.set_real([U], [u])
    refused(reason, slave.do_step, 0.1, 0.1)
    slave.set_real([U], [2.0])
    assert json.dumps(slave._get_fmu_state()) == before
    slave.do_step(0.1, 0.1)


@pytest.mark.parametrize("advance, reason", [
    (lambda *_: [math.inf, 0.0], "y = inf is not a finite number"),
    (lambda *_: [1.0, math.nan], "began = nan is not a finite number"),
    (lambda *_: [1.0, -6.0], "began = -343.775 deg is below its minimum -286.479 deg at t = 0.1 s"),
    (lambda *_: [1.0, 0.0, math.nan], "an internal state is not a finite number"),
    (lambda *_: [1 / 0], "the state cannot be computed (division by zero)"),
    (lambda *_: [math.log(-1)], "the state cannot be computed"),
])
def test_a_state_that_is_none_is_refused(advance, reason):
    slave, _ = started(advance=advance)
    refused(reason, slave.do_step, 0.0, 0.1)
    assert slave.get_real([Y, NOW]) == [1.0, 0.0]


@pytest.mark.parametrize("start", [lambda m, u, p: [2000.0, 0.0], lambda m, u, p: [1 / 0, 0.0]])
def test_a_model_that_cannot_start_says_so(start):
    slave, _ = made(start=start)
    refused("Tiny cannot start: ", slave.get_real, [Y])
    slave.setup_experiment(0.0)
    slave.enter_initialization_mode()
    refused("Tiny cannot start: ", slave.exit_initialization_mode)
    assert slave.get_real([X_START]) == [1.0]


def test_sets_are_all_or_nothing():
    slave, _ = made()
    refused("x_start = 11 is above its maximum 10", slave.set_real, [U, X_START], [3.0, 11.0])
    refused("x_start = -1 is below its minimum 0", slave.set_real, [U, X_START], [3.0, -1.0])
    refused("angle = 114.592 deg is above its maximum 57.2958 deg", slave.set_real, [ANGLE], [2.0])
    refused("y is an output and may not be set", slave.set_real, [U, Y], [3.0, 1.0])
    refused("began is a calculated parameter and may not be set", slave.set_real, [BEGAN], [1.0])
    refused("high is an output", slave.set_boolean, [HIGH], [True])
    assert slave.get_real([U, X_START]) == [2.0, 1.0] and slave.u.u == 2.0 and slave.p.x_start == 1.0
    slave.set_real([U, X_START], [3.0, 10.0])
    slave.set_boolean([SURE], [False])
    assert slave.get_real([U, X_START]) == [3.0, 10.0] and slave.get_boolean([SURE]) == [False]


def test_an_input_that_is_no_number_is_refused_until_it_is_one():
    slave, _ = started()
    slave.do_step(0.0, 0.1)
    refused("u = nan is not a finite number and was refused at t = 0.1 s", slave.set_real, [U], [math.nan])
    refused("u = nan is not a finite number at t = 0.1 s", slave.do_step, 0.1, 0.1)
    assert slave.get_real([U]) == [2.0]
    slave.set_real([U], [4.0])
    slave.do_step(0.1, 0.1)
    assert slave.get_real([Y]) == pytest.approx([1.6])


def test_values_have_a_type_and_a_reference():
    slave, _ = made()
    for call, vrs in ((slave.get_real, [ON]), (slave.get_real, [99]), (slave.get_boolean, [U])):
        refused(f"value reference {vrs[0]} is no {'Boolean' if vrs == [U] else 'Real'} of Tiny", call, vrs)
    refused("value reference 1 is no Real of Tiny", slave.set_real, [ON], [1.0])
    refused("value reference 0 is no Boolean of Tiny", slave.set_boolean, [U], [True])
    for kind in ("integer", "string"):
        assert getattr(slave, f"get_{kind}")([]) == []
        getattr(slave, f"set_{kind}")([], [])
        refused(f"value reference 0 is no {kind.capitalize()} of Tiny", getattr(slave, f"get_{kind}"), [U])
        refused(f"value reference 0 is no {kind.capitalize()} of Tiny", getattr(slave, f"set_{kind}"), [U], [1])


def test_phases_come_in_their_order():
    slave, _ = made()
    refused("initialisation cannot end", slave.exit_initialization_mode)
    refused("can step only between", slave.do_step, 0.0, 0.1)
    refused("can be terminated only after", slave.terminate)
    slave.setup_experiment(0.0, 1.0, 1e-6)
    slave.enter_initialization_mode()
    refused("set up before initialisation only", slave.setup_experiment, 0.0)
    refused("can begin once", slave.enter_initialization_mode)
    slave.exit_initialization_mode()
    refused("x_start is fixed", slave.set_real, [X_START], [2.0])
    refused("initialisation cannot end", slave.exit_initialization_mode)
    slave.terminate()
    refused("u may not be set after termination", slave.set_real, [U], [2.0])
    refused("sure is fixed", slave.set_boolean, [SURE], [True])
    refused("can be terminated only after", slave.terminate)
    assert slave.get_real([Y]) == [1.0]


@pytest.mark.parametrize("start, stop, reason", [
    (math.nan, None, "start time nan s is not a finite number"), (math.inf, None, "start time inf s"),
    (2.0, 1.0, "stop time 1 s is not after start time 2 s"), (0.0, math.nan, "stop time nan s")])
def test_times_of_the_experiment_are_numbers_in_order(start, stop, reason):
    refused(reason, made()[0].setup_experiment, start, stop)
    made()[0].setup_experiment(2.0, 2.0)


def test_a_state_brings_back_everything():
    slave, _ = started(stop=1.0)
    slave.set_real([U], [3.0])
    slave.do_step(0.0, 0.1)
    state = slave._fmu_state_from_bytes(slave._fmu_state_to_bytes(slave._get_fmu_state()))
    with pytest.raises(Refused):
        slave.set_real([U], [math.inf])
    slave.terminate()
    slave._set_fmu_state(state)
    assert slave.prepared is None and slave._get_fmu_state() == state
    slave.do_step(0.1, 0.1)
    assert slave.get_real([Y, U]) == pytest.approx([1.6, 3.0])
    refused("past the stop time 1 s", slave.do_step, 0.95, 0.1)
    state["x"][0] = 77.0
    assert slave.x[0] != 77.0


@pytest.mark.parametrize("data", [b"", b"{", b"[1]", b'"x"', b"{}", b'{"of": "another"}', b"\xff"])
def test_what_is_no_state_of_this_fmu_is_refused_when_it_is_put_back(data):
    slave, _ = started()
    refused("the state given is none of this Tiny", slave._set_fmu_state, slave._fmu_state_from_bytes(data))


def test_each_refusal_keeps_what_pythonfmus_binary_lets_go():
    slave, _ = made()
    kept = (slave, type(slave), slave.log_queue)
    gc.collect()
    before = [sys.getrefcount(thing) for thing in kept]
    for _ in range(50):
        with pytest.raises(Refused):
            slave.terminate()
    gc.collect()
    assert [sys.getrefcount(thing) - n for thing, n in zip(kept, before)] == pytest.approx([50, 50, 50], abs=2)


def test_every_call_of_the_binary_is_guarded():
    called = {"setup_experiment", "enter_initialization_mode", "exit_initialization_mode", "do_step", "terminate",
              "_get_fmu_state", "_set_fmu_state", *(f"{verb}_{kind}" for verb in ("get", "set")
                                                    for kind in ("real", "integer", "boolean", "string"))}
    guard = refusing(len).__code__
    assert {name for name, member in vars(ModelSlave).items() if getattr(member, "__code__", None) is guard} == called


def test_there_are_no_whole_numbers_and_no_texts():
    slave, _ = started()
    assert slave.get_integer([]) == slave.get_string([]) == []
    slave.set_integer([], [])
    slave.set_string([], [])
    refused("value reference 2 is no Integer of Tiny", slave.get_integer, [Y])
    refused("value reference 0 is no String of Tiny", slave.set_string, [U], ["x"])
