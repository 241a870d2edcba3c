"""Each algorithm on two oscillators that push each other, beside the solution of the whole."""
from functools import partial

import numpy as np
import pytest
import small
from scipy.linalg import expm

from cosim.errors import UsageError
from cosim.master.fly import fly
from cosim.master.system import Component, Connection, System

STOP = 2.0


@pytest.fixture(scope="module")
def build(tmp_path_factory):
    return partial(small.build, tmp_path_factory.mktemp("small"))


def exact(times, ld=0.0):
    """left.y and right.y of `small.pair` in continuous time; `ld` is left's direct path."""
    whole = np.array([[0, 1, 0, 0], [-4, -0.3, 0.8, 0], [0, 0, 0, 1], [1, 0, -9 + 0.8 * ld, -0.3]])
    states = np.array([expm(whole * t) @ [1.0, 0.0, -0.5, 0.2] for t in times])
    return np.column_stack([states[:, 0] + ld * 0.8 * states[:, 2], states[:, 2]])


def error(system, step, algorithm, ld=0.0):
    flight = fly(system, step, STOP, algorithm)
    assert flight.finished, flight.message
    shown = np.column_stack([flight["left.y"], flight["right.y"]])
    both = slice(None, None, 4) if "right=4" in algorithm else slice(None)  # between, right shows what it had
    later = flight.time[both] > 0.5 * (ld != 0)  # a first step has no slope yet
    return float(np.abs(shown - exact(flight.time, ld))[both][later].max()), flight


def order(system, algorithm):
    errors = [error(system, step, algorithm)[0] for step in (0.02, 0.01, 0.005)]
    return np.log2(np.array(errors[:-1]) / errors[1:])


@pytest.mark.parametrize("algorithm,expected", [
    ("jacobi", 1), ("gauss-seidel", 1), ("gauss-seidel,order=right+left", 1), ("multi-rate,right=4", 1),
    ("jacobi,hold=linear", 2), ("gauss-seidel,hold=linear", 2), ("multi-rate,right=4,hold=linear", 2),
])
def test_order_where_outputs_are_states(build, algorithm, expected):
    assert order(small.pair(build()), algorithm) == pytest.approx(expected, abs=0.15)


@pytest.mark.parametrize("algorithm,expected", [("iterated", 1), ("iterated,hold=linear", 2)])
def test_order_of_iteration_where_a_loop_is_declared(build, algorithm, expected):
    assert order(small.pair(build(direct=None)), algorithm) == pytest.approx(expected, abs=0.15)


@pytest.mark.parametrize("algorithm", ["jacobi,hold=linear", "gauss-seidel,hold=linear"])
def test_input_derivatives_give_order_two_where_outputs_depend_on_inputs(build, algorithm):
    system = small.pair(build(direct=True, interpolates=True), build(interpolates=True), d=0.5)
    errors = [error(system, step, algorithm, ld=0.5)[0] for step in (0.02, 0.01)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2, abs=0.2)


def test_the_order_follows_from_declared_dependencies(build):
    system = small.pair(build(direct=True), build(), d=0.5)
    default, given, other = (fly(system, 0.01, STOP, f"gauss-seidel{o}").signals
                             for o in ("", ",order=right+left", ",order=left+right"))
    assert np.array_equal(default, given) and not np.array_equal(default, other)


def test_multi_rate_with_equal_rates_is_gauss_seidel(build):
    system = small.pair(build())
    assert np.array_equal(fly(system, 0.01, STOP, "multi-rate,left=1").signals,
                          fly(system, 0.01, STOP, "gauss-seidel").signals)


def test_multi_rate_holds_what_a_slow_component_shows(build):
    flight = fly(small.pair(build()), 0.01, STOP, "multi-rate,right=5")
    shown = flight["right.y"][:-1].reshape(-1, 5)
    assert np.all(shown == shown[:, :1]) and len(np.unique(shown)) == 40


@pytest.mark.parametrize("plain", [False, True])
@pytest.mark.parametrize("hold", ["", ",hold=linear"])
def test_a_row_shows_what_a_slow_component_had_and_never_what_it_will_have(build, hold, plain):
    """What `right` gives at the end of a step of its own is due then: at t = 0, 0.05, 0.1 ..."""
    flight = fly(small.pair(build()), 0.01, STOP, f"multi-rate,right=5{hold}", plain=plain)
    assert flight.periods == {"right": pytest.approx(0.05)}
    for name, column in (("left.y", 0), ("right.y", 1)):
        due = flight.together([name])
        assert np.abs(flight[name] - exact(flight.time)[:, column])[due].max() < 0.1
    steps = np.flatnonzero(np.diff(flight["right.y"])) + 1
    assert np.array_equal(steps, np.flatnonzero(flight.together(["right.y"]))[1:])
    part = fly(small.pair(build()), 0.01, STOP, f"multi-rate,right=5{hold}", plain=plain, decimate=3)
    assert np.array_equal(part.signals, flight.signals[[*range(0, 201, 3), 200]])


def test_iteration_without_a_declared_loop_is_gauss_seidel(build):
    system = small.pair(build())
    assert np.array_equal(fly(system, 0.01, STOP, "iterated").signals, fly(system, 0.01, STOP, "gauss-seidel").signals)


def test_iteration_solves_an_algebraic_loop(build):
    """Two gains without states: y = 0.5 u + 1 and y = -0.8 u meet at 1/1.4."""
    fmu = build(direct=True)
    still = {"a12": 0.0, "a21": 0.0, "b2": 0.0}
    system = System((Component("a", fmu, {**still, "x1": 1.0, "d": 0.5}), Component("b", fmu, {**still, "d": -0.8})),
                    (Connection("a.y", "b.u"), Connection("b.y", "a.u")))
    flight = fly(system, 0.1, 1.0, "iterated")
    assert np.abs(flight["a.y"] - 1 / 1.4).max() < 1e-9
    assert np.abs(flight["b.y"] + 0.8 / 1.4).max() < 1e-9


def test_iteration_that_does_not_converge_says_so(build):
    fmu = build(direct=None)
    system = System((Component("a", fmu, {"b1": 100.0, "x1": 1.0}), Component("b", fmu, {"b1": 100.0})),
                    (Connection("a.y", "b.u"), Connection("b.y", "a.u")))
    flight = fly(system, 1.0, 5.0, "iterated")
    assert not flight.finished and len(flight.time) == 1
    assert flight.message.startswith("The loop does not converge in the step from t = 0 s: a.y, b.y still change")
    assert fly(system, 1.0, 5.0, "iterated,passes=3").message.endswith("still change after 3 passes.")


@pytest.mark.parametrize("hold", ["linear", "constant"])
def test_variable_steps_follow_the_tolerance(build, hold):
    """The tolerance is for one step and for what is connected; the run's error falls with some root of it."""
    reached = []
    for tolerance in (1e-4, 1e-6):
        found, flight = error(small.pair(build()), 0.01, f"variable,tolerance={tolerance},hold={hold}")
        assert flight.time[-1] == STOP and flight.ticks == len(flight.time) - 1
        reached.append(found)
    assert 0.25 < np.log(reached[0] / reached[1]) / np.log(100) < 0.75


def test_variable_steps_leave_out_outputs_that_depend_on_inputs_if_there_are_others(build):
    """They lag behind as the held inputs do: as a measure of the error they would ask for 271 steps."""
    system = small.pair(build(direct=True), build(), d=0.5)
    assert fly(system, 0.01, STOP, "variable,tolerance=1e-3").ticks < 50


def test_variable_steps_follow_outputs_that_depend_on_inputs_if_there_are_no_others(build):
    system = small.pair(build(direct=True), d=0.5)
    few, many = (fly(system, 0.01, 0.2, f"variable,tolerance={t}").ticks for t in (1e-2, 1e-4))
    assert 20 * few < many


def test_variable_steps_follow_the_worst_signal(build):
    slow, fast = small.oscillator(a21=-1.0), small.oscillator(a21=-400.0)
    links = (Connection("p.y", "q.u"), Connection("q.y", "p.u"))
    ticks = [fly(System((Component("p", build(), a), Component("q", build(), b)), links), 0.01, STOP,
                 "variable,tolerance=1e-3").ticks for a, b in ((slow, fast), (fast, slow), (slow, slow))]
    assert ticks[0] == ticks[1] > 2 * ticks[2]


def test_variable_steps_allow_an_error_relative_to_the_signal_or_to_its_nominal_value(build):
    def ticks(scale):
        system = small.pair(build(), x1=scale)
        right = system.components[1].with_values({"x1": -0.5 * scale, "x2": 0.2 * scale})
        return fly(System((system.components[0], right), system.connections), 0.01, STOP,
                   "variable,tolerance=1e-4").ticks

    assert ticks(1e3) == pytest.approx(ticks(1e6), abs=2) and ticks(1e3) > 1.2 * ticks(1.0) > 1.2 * ticks(1e-4)


def test_a_variable_step_is_at_most_a_hundred_times_the_first(build):
    taken = np.diff(fly(small.pair(build()), 0.001, STOP, "variable,tolerance=1e3").time)
    assert taken.max() == pytest.approx(0.1)


def test_the_last_of_the_variable_steps_is_no_sliver(build):
    system = small.pair(build())
    for stop in np.linspace(1.0, 2.0, 21).round(2):
        taken = np.diff(fly(system, 0.01, stop, "variable,tolerance=1e-3").time)
        assert taken[-1] > 0.3 * taken[-2]


def test_a_signal_that_is_no_number_ends_a_variable_run(build):
    fault = small.FAULTS.index("not_a_number")
    flight = fly(small.pair(build(), fault=fault, fault_time=1.0), 0.01, STOP, "variable,tolerance=1e-3")
    assert not flight.finished and 0.99 < flight.time[-1] < 1.2
    assert "cannot be made short enough for a tolerance of 0.001" in flight.message


@pytest.mark.parametrize("algorithm,direct", [("variable,tolerance=1e-5", False), ("iterated", None)])
def test_every_seventh_row_and_the_last_of_steps_that_are_taken_one_by_one(build, algorithm, direct):
    system = small.pair(build(direct=direct))
    full, part = (fly(system, 0.01, 0.5, algorithm, decimate=n) for n in (1, 7))
    kept = sorted({*range(0, len(full.time), 7), len(full.time) - 1})
    assert part.time.tobytes() == full.time[kept].tobytes()
    assert part.signals.tobytes() == full.signals[kept].tobytes()


def test_only_what_is_in_a_loop_must_save_its_state(build):
    system = small.pair(build(direct=None))
    outside = Component("outside", build(direct=True, states=False), small.oscillator())
    system = System((*system.components, outside), (*system.connections, Connection("left.y", "outside.u")))
    assert fly(system, 0.01, 0.1, "iterated").finished


def test_variable_steps_back_from_a_discarded_step(build):
    flight = fly(small.pair(build(), longest=0.003), 0.05, STOP, "variable,tolerance=1e-3")
    assert flight.finished and np.diff(flight.time).max() <= 0.003


def test_a_step_that_is_always_discarded_ends_a_variable_run_in_the_words_of_the_fmu(build):
    flight = fly(small.pair(build(), fault=1, fault_time=1.0), 0.01, STOP, "variable,tolerance=1e-3")
    assert not flight.finished and 1.0 <= flight.time[-1] < 1.3
    assert "answered Discard to fmi2DoStep" in flight.message and "told to discard" in flight.message


@pytest.mark.parametrize("algorithm,sentence", [
    ("variable", "steps back, and left, right cannot"),
    ("iterated", "repeats steps, and left, right cannot"),
])
def test_what_an_algorithm_needs_is_asked_for(build, algorithm, sentence):
    with pytest.raises(UsageError, match=sentence):
        fly(small.pair(build(direct=None, states=False)), 0.01, STOP, algorithm)


@pytest.mark.parametrize("word,sentence", [
    ("jacoby", "Did you mean jacobi"), ("jacobi,order=a", "order=a is not an option of jacobi"),
    ("jacobi,hold=2", "2 is no value for hold"), ("multi-rate,left=0", "0 is no value for left"),
    ("gauss-seidel,order=left", "must name each component once"), ("multi-rate,wing=2", "no component wing"),
    ("multi-rate,left=7", "200 ticks are not a whole number"), ("multi-rate,left=3,right=4", "not a whole number"),
    ("gauss-seidel,order=left+right+left", "must name each component once"), ("iterated,passes=0", "0 is no value"),
    ("variable,tolerance=0", "0 is no value for tolerance"), ("variable,tolerance=inf", "inf is no value"),
    ("variable,tolerance=nan", "nan is no value"), ("jacobi,hold", "hold is not an option"),
])
def test_a_wrong_word_is_named(build, word, sentence):
    with pytest.raises(UsageError, match=sentence):
        fly(small.pair(build()), 0.01, STOP, word)
