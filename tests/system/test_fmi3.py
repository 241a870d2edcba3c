"""FMI 3.0 in the master: types, arrays, events, early returns, mixed systems, and what is refused."""
from dataclasses import replace

import numpy as np
import pytest
import small
import small3

from cosim import info
from cosim.errors import RunError, UsageError
from cosim.master.algorithms.base import turn
from cosim.master.fly import fly
from cosim.master.isolated import fly_isolated
from cosim.master.loaded import Master, open_files
from cosim.master.program import program
from cosim.master.system import Component, Connection, System

BOTH = pytest.mark.parametrize("plain", [False, True])
VALUES = {"Float64": 0.1, "Float32": 0.5, "Int8": -128, "UInt8": 255, "Int16": -32768, "UInt16": 65535,
          "Int32": -2 ** 31, "UInt32": 2 ** 32 - 1, "Int64": 2 ** 53 + 1, "UInt64": 2 ** 64 - 1, "Boolean": True,
          "Enumeration": 2}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("small3")


@pytest.fixture(scope="module")
def fmu(folder):
    return small3.build(folder)


@pytest.fixture(scope="module")
def eventful(folder):
    return small3.build(folder, events=True)


def one(fmu, **values):
    return System((Component("a", fmu, values),))


def two(fmu, links, other=None, **values):
    """a and b, with connections from outputs of a to inputs of b."""
    return System((Component("a", fmu, values), Component("b", other or fmu)),
                  tuple(Connection(f"a.{source}", f"b.{target}") for source, target in links))


def shown_at_the_end(system, names, plain):
    """What the component b has after two ticks of Gauss-Seidel."""
    with open_files(system) as files:
        master = Master(system, files, plain=plain)
        try:
            master.initialise(0.0, 1.0)
            master.run(program([*turn(master, 0, False), *turn(master, 1, False)]), 0, 2, 0.0, 0.1)
            return master.instances[1].get(names)
        finally:
            master.close()


# --- types and arrays -------------------------------------------------------------------------------------------------

@BOTH
@pytest.mark.parametrize("which", ["fmu", "eventful"])
def test_every_type_arrives_with_all_its_digits(which, plain, request):
    system = two(request.getfixturevalue(which), [(f"{t}_out", f"{t}_in") for t in VALUES],
                 **{f"{t}_in": x for t, x in VALUES.items()})
    assert shown_at_the_end(system, [f"{t}_out" for t in VALUES], plain) == list(VALUES.values())


@BOTH
def test_texts_arrive_alone_and_in_arrays(fmu, eventful, plain):
    links = [("text_out", "text_in"), ("texts_out[2]", "texts_in[1]")]
    for one_fmu in (fmu, eventful):
        system = two(one_fmu, links, **{"text_in": "words", "texts_in[2]": "more"})
        assert shown_at_the_end(system, ["text_out", "texts_out[1]", "texts_out[2]"], plain) == ["words", "more", "two"]


@BOTH
def test_arrays_move_as_a_whole_and_the_rest_of_one_keeps_its_values(fmu, plain):
    system = two(fmu, [("vector_out[2]", "vector_in[3]"), ("table_out", "table_in")],
                 **{"table_in[1,2]": 7, "table_in[2,1]": -7, "matrix[2,3]": 0.0})
    system = replace(system, components=(system.components[0], system.components[1].with_values({"vector_in[1]": 4.0})))
    names = ["table_out[1,1]", "table_out[1,2]", "table_out[2,1]", "vector_in[1]", "vector_in[2]", "vector_in[3]"]
    assert shown_at_the_end(system, names, plain) == [0, 7, -7, 4.0, 0.5, 4.5]


def test_elements_are_columns_and_an_alias_can_be_recorded(fmu):
    flight = fly(one(fmu), 0.1, 1.0, record=["a.position", "a.y", "a.vector_in[*", "a.matrix[2,1]"])
    assert list(flight) == ["a.y", "a.vector_in[1]", "a.vector_in[2]", "a.vector_in[3]", "a.matrix[2,1]", "a.position"]
    assert (flight["a.position"] == flight["a.y"]).all() and flight["a.matrix[2,1]"][-1] == 4.0
    assert flight.parameters["a"]["matrix[1,3]"] == 3.0 and flight.parameters["a"]["size"] == 3


# --- mixed systems ----------------------------------------------------------------------------------------------------

@BOTH
@pytest.mark.parametrize("algorithm", ["gauss-seidel", "jacobi,hold=linear", "multi-rate,right=2", "iterated",
                                       "variable,hold=constant"])
def test_fmi_2_and_3_together_show_what_two_of_fmi_2_show(folder, fmu, algorithm, plain):
    old = small.build(folder)
    expected, system = (small.pair(old, other, a21=-4.0, a22=-0.3) for other in (None, fmu))
    flights = [fly(s, 0.01, 1.0, algorithm, plain=plain, record=["left.y", "right.y"]) for s in (expected, system)]
    assert all(f.finished for f in flights), [f.message for f in flights]
    assert np.array_equal(flights[0].signals, flights[1].signals)


def test_numbers_pass_between_the_versions(folder, fmu):
    system = two(small.build(folder), [("whole_out", "Int64_in"), ("truth_out", "Boolean_in"), ("y", "Float32_in"),
                                       ("text_out", "text_in"), ("whole_out", "Enumeration_in")], fmu,
                 whole_in=2, truth_in=True, text_in="words", x1=0.1)
    found = shown_at_the_end(system, ["Int64_out", "Boolean_out", "text_out", "Enumeration_out", "Float32_out"], False)
    assert found[:4] == [2, True, "words", 2] and found[4] == np.float32(found[4]) != 0.0


# --- events and early returns -----------------------------------------------------------------------------------------

@BOTH
def test_discrete_states_are_updated_at_events(fmu, eventful, plain):
    flights = [fly(one(f, period=0.25, substeps=50.0), 0.1, 1.0, plain=plain) for f in (fmu, eventful)]
    for flight in flights:
        assert flight.finished and flight["a.count"].tolist() == [0, 0, 0, 1, 1, 2, 2, 2, 3, 3, 4]
    assert flights[0]["a.y"] == pytest.approx(flights[1]["a.y"], rel=1e-9)
    assert (flights[0]["a.entered"][-1], flights[1]["a.entered"][-1]) == (0, 4)


@BOTH
@pytest.mark.parametrize("link,entered", [("count", 2), ("level_out", 0)])
def test_event_mode_is_entered_when_a_discrete_input_changes_and_not_else(eventful, plain, link, entered):
    """b is given what a counts, twice in the time."""
    flight = fly(two(eventful, [(link, "level_in")], period=0.5), 0.1, 1.0, plain=plain)
    assert flight.finished and flight["b.entered"][-1] == entered
    assert (flight["b.level_out"] == flight[f"a.{link}"]).all()


@pytest.mark.parametrize("algorithm", ["iterated", "variable"])
def test_a_restored_state_is_given_its_discrete_inputs_again(eventful, algorithm):
    links = (Connection("a.count", "b.level_in"), Connection("a.y", "b.u"), Connection("b.y", "a.u", 0.1))
    system = System((Component("a", eventful, {"period": 0.5}), Component("b", eventful)), links)
    flights = [fly(system, 0.05, 1.0, algorithm, plain=plain) for plain in (False, True)]
    assert flights[0].finished and np.array_equal(flights[0].signals, flights[1].signals)
    assert flights[0]["b.level_out"][-1] == 2


@BOTH
def test_a_step_goes_on_after_an_early_return(fmu, plain):
    whole, parts = (fly(one(fmu, early=early), 0.1, 1.0, plain=plain) for early in (0.0, 0.03))
    fine = fly(one(fmu), 0.0025, 1.0, decimate=40)
    assert parts.finished and parts.ticks == 10
    assert abs(parts["a.y"][-1] - fine["a.y"][-1]) < 0.1 * abs(whole["a.y"][-1] - fine["a.y"][-1])


def faulty(fmu, fault, **more):
    return one(fmu, fault=small3.FAULTS.index(fault), fault_time=0.5, period=0.25, **more)


ENDS = {
    "error": "a (small3_events.fmu) answered Error to fmi3DoStep at t = 0.5 s: told to fail",
    "fatal": "a (small3_events.fmu) answered Fatal to fmi3DoStep at t = 0.5 s: told to fail for good",
    "discard": "a (small3_events.fmu) answered Discard to fmi3DoStep at t = 0.5 s: told to discard",
    "refuse_event": "a (small3_events.fmu) answered Error to fmi3EnterEventMode at t = 0.4 s: told not to enter event "
                    "mode",
    "refuse_update": "a (small3_events.fmu) answered Error to fmi3UpdateDiscreteStates at t = 0.4 s: told not to "
                     "update",
    "restless": "a (small3_events.fmu) does not come to the end of its events in the step from t = 0.4 s.",
    "stuck": "a (small3_events.fmu) does not come to the end of its events in the step from t = 0.5 s.",
}


@pytest.mark.parametrize("flown", [fly, lambda *a: fly(*a, plain=True), fly_isolated])
@pytest.mark.parametrize("fault", ENDS)
def test_what_goes_wrong_is_told(eventful, fault, flown):
    flight = flown(faulty(eventful, fault), 0.1, 1.0, "gauss-seidel")
    assert not flight.finished and flight.message == ENDS[fault]


@BOTH
@pytest.mark.parametrize("fault,time", [("end", 0.55), ("end", 0.5), ("end_in_event", 0.5)])
def test_an_fmu_may_end_the_simulation(eventful, fault, time, plain):
    system = System((faulty(eventful, fault).components[0].with_values({"fault_time": time}),))
    flight = fly(system, 0.1, 1.0, plain=plain)
    assert flight.finished and flight.ended_at == pytest.approx(time) and flight.time[-1] == pytest.approx(time)
    assert flight.message == f"a (small3_events.fmu) ended the simulation at t = {time:g} s."


@pytest.mark.parametrize("claimed,had,flies", [(True, 1, True), (True, 0, True), (False, 0, True), (False, 1, False)])
def test_event_mode_is_used_where_it_is_claimed_and_there(tmp_path, claimed, had, flies):
    system = one(small3.build(tmp_path, events=claimed, flags=(f"-DEVENTS={had}",)), period=0.25)
    if not flies:
        with pytest.raises(RunError, match=r"cannot be instantiated: .* It said: not with this event mode"):
            fly(system, 0.1, 1.0)
        return
    flight = fly(system, 0.1, 1.0)
    assert flight.finished and flight["a.count"][-1] == 4 and flight["a.entered"][-1] == 4 * had


# --- start, tolerance, outputs ----------------------------------------------------------------------------------------

@pytest.mark.parametrize("isolate", [False, True])
@pytest.mark.parametrize("algorithm", ["gauss-seidel", "multi-rate,a=2", "variable", "iterated"])
def test_a_flight_starts_at_any_time(fmu, algorithm, isolate):
    flight = (fly_isolated if isolate else fly)(replace(one(fmu), start=-2.5), 0.25, -1.0, algorithm)
    assert flight.finished and flight.time[[0, -1]].tolist() == [-2.5, -1.0]
    assert flight.together(["a.y"])[[0, -1]].all()
    again = fly(one(fmu), 0.25, 1.5, algorithm)
    assert flight["a.y"][-1] == pytest.approx(again["a.y"][-1], rel=1e-6)


@pytest.mark.parametrize("start,stop,words", [(1.0, 1.0, "--stop 1 s must be after the start at 1 s"),
                                              (0.5, 1.03, "is not a whole number of .* from the start at 0.5 s"),
                                              (float("nan"), 1.0, "--start nan must be a finite number")])
def test_a_start_that_does_not_fit_is_refused(fmu, start, stop, words):
    with pytest.raises(UsageError, match=words):
        fly(one(fmu), 0.1, stop, start=start)


def test_the_tolerance_is_handed_over(fmu, folder):
    assert fly(one(fmu), 0.1, 1.0, tolerance=0.25).finished
    with pytest.raises(RunError, match="answered Error to fmi3EnterInitializationMode: such a tolerance"):
        fly(one(fmu), 0.1, 1.0, tolerance=0.125)
    with pytest.raises(UsageError, match="--tolerance -1 must be a positive number"):
        fly(one(fmu), 0.1, 1.0, tolerance=-1.0)


@pytest.mark.parametrize("flown", [fly, fly_isolated])
def test_an_fmu_without_outputs_flies(folder, flown):
    flight = flown(one(small3.build(folder, causality="local")), 0.1, 1.0, "gauss-seidel")
    assert flight.finished and flight.signals.shape == (11, 0) and flight.time[-1] == 1.0


def test_a_library_needs_what_is_called_only(folder):
    lean = small.build(folder, claims=("canNotUseMemoryManagementFunctions",), flags=("-DLEAN",))
    assert fly(small.pair(lean), 0.1, 1.0).finished


# --- refusals ---------------------------------------------------------------------------------------------------------

def test_input_clocks_are_refused_by_name_and_output_clocks_are_not_needed(folder):
    assert fly(one(small3.build(folder, clock="output")), 0.1, 1.0).finished
    with pytest.raises(UsageError, match=r"small3_clock_input\.fmu needs its clock tick to tick; input clocks"):
        fly(one(small3.build(folder, clock="input")), 0.1, 1.0)


@pytest.mark.parametrize("version", ["3.0-beta.2", "1.0", "4.0", "3"])
def test_other_versions_are_refused(folder, version):
    with pytest.raises(UsageError, match=rf"is FMI {version}; co-simulation FMUs of FMI 2\.0 and 3\.0 are what runs"):
        fly(one(small3.build(folder, fmiVersion=version)), 0.1, 1.0)


@pytest.mark.parametrize("source,target,words", [
    ("Int32_out", "Int16_in", r"a\.Int32_out \(Int32\) cannot be connected to b\.Int16_in \(Int16\)"),
    ("UInt32_out", "Int32_in", "cannot be connected"), ("Float32_out", "Int32_in", "cannot be connected"),
    ("Boolean_out", "Int32_in", "cannot be connected"), ("bytes_out", "bytes_in", r"\(Binary\) cannot be connected"),
    ("text_out", "texts_in", r"has the array texts_in: name one of its elements, texts_in\[1\] to texts_in\[2\]"),
    ("vector_out", "vector_in", r"ends at vector_out\[2\] and b\.vector_in at vector_in\[3\]: only arrays of the same"),
    ("vector_out[3]", "u", r"has no variable vector_out\[3\]; did you mean vector_out\[2\]\?"),
])
def test_connections_that_do_not_fit_are_refused(fmu, source, target, words):
    with pytest.raises(UsageError, match=words):
        fly(two(fmu, [(source, target)]), 0.1, 1.0)


@pytest.mark.parametrize("name,value,words", [
    ("UInt8_in", 256, "a.UInt8_in = 256 is not allowed: it must be between 0 and 255"),
    ("UInt64_in", -1, "between 0 and 18446744073709551615"), ("Int64_in", "9223372036854775808", "must be between"),
    ("Float32_in", 1e39, "must be between"), ("Int16_in", 0.5, "must be a whole number"),
    ("size", 4, "a.size is a structural parameter: sizes are flown as the FMU declares them"),
    ("bytes_in", "ff", "a.bytes_in is a Binary, which cannot be set here"),
    ("matrix", 1.0, r"has the array matrix: name one of its elements, matrix\[1,1\] to matrix\[2,3\]"),
])
def test_values_that_do_not_fit_are_refused(fmu, name, value, words):
    with pytest.raises(UsageError, match=words):
        fly(one(fmu, **{name: value}), 0.1, 1.0)


@pytest.mark.parametrize("more,words", [
    ('<Float64 name="huge" valueReference="200" causality="local"><Dimension start="2000000"/></Float64>',
     "its variable huge is an array of 2000000 elements; at most 1000000 are read"),
    ('</ModelVariables><ModelStructure><Output valueReference="555"/></ModelStructure><ModelVariables>',
     r"its model structure \(Output\) refers to a value reference that no variable has"),
])
def test_descriptions_that_cannot_be_used_are_refused(folder, more, words):
    with pytest.raises(UsageError, match=words):
        fly(one(small3.build(folder, more=more)), 0.1, 1.0)


def test_info_reads_it(fmu):
    found = info(fmu)
    assert found.fmi_version == "3.0" and found["a21"].start == -4.0 and found["matrix"].start == "1 2 3 4 5 6"
