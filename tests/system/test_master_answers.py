"""Rare answers of FMUs: unknown statuses, refused and missing texts, numbers that do not fit, Fatal; and words."""
import ctypes
import math
from contextlib import suppress

import numpy as np
import pytest
import small
from altered import redescribed

from cosim.errors import RunError, UsageError
from cosim.master import last_call, program
from cosim.master.algorithms import method
from cosim.master.fly import fly, fly_loaded
from cosim.master.fmu import FmuFile
from cosim.master.instance import ONLY_ONE, Instance
from cosim.master.isolated import fly_isolated
from cosim.master.loaded import Master, open_files
from cosim.master.logger import ENVIRONMENTS, MOST_MESSAGES, log
from cosim.master.program import DISCARD, ERROR, FATAL
from cosim.master.system import Component, Connection, System

AT = 0.74
ALGORITHMS = ["gauss-seidel", "jacobi", "multi-rate,right=2", "iterated", "variable"]


def faulty(fmu, fault, **values):
    return small.pair(fmu, fault=small.FAULTS.index(fault), fault_time=AT, **values)


def here(system, algorithm="jacobi"):
    return fly(system, 0.01, 1.0, algorithm)


def plain(system, algorithm="jacobi"):
    return fly(system, 0.01, 1.0, algorithm, plain=True)


def isolated(system, algorithm="jacobi"):
    return fly_isolated(system, 0.01, 1.0, algorithm)


@pytest.fixture(scope="module")
def fmu(tmp_path_factory):
    return small.build(tmp_path_factory.mktemp("small"))


# --- statuses ---------------------------------------------------------------------------------------------------------

@pytest.mark.parametrize("flown", [here, plain, isolated])
@pytest.mark.parametrize("status,word", [(5, "Pending"), (6, "the unknown status 6"), (99, "the unknown status 99"),
                                         (100, "the unknown status 100"), (-1, "the unknown status -1")])
def test_a_status_that_is_none_is_an_error(fmu, flown, status, word):
    flight = flown(faulty(fmu, "answers", answer=status))
    assert flight.message == (f"left (small_indirect.fmu) answered {word} to fmi2DoStep at t = 0.74 s: "
                              f"told what to answer")
    assert not flight.finished and len(flight.time) == 75


@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_such_a_status_ends_every_algorithm(fmu, algorithm):
    assert "answered the unknown status -1 to fmi2DoStep" in here(faulty(fmu, "answers", answer=-1), algorithm).message


@pytest.mark.parametrize("flown", [here, plain])
def test_a_warning_is_none(fmu, flown):
    assert flown(faulty(fmu, "answers", answer=1)).finished


# --- texts and numbers ------------------------------------------------------------------------------------------------

def test_a_refused_text_is_told(fmu):
    with pytest.raises(RunError) as caught:
        here(small.pair(fmu, text_in="refused"))
    assert str(caught.value) == ("left (small_indirect.fmu) answered Error to fmi2SetString(text_in): "
                                 "this text is refused")


def texts(fmu, fault):
    parts = (Component("left", fmu, {"fault": small.FAULTS.index(fault), "fault_time": 0.0, "text_in": "words"}),
             Component("right", fmu))
    return System(parts, (Connection("left.text_out", "right.text_in"),))


@pytest.mark.parametrize("flown", [here, plain, isolated])
def test_a_text_that_is_refused_on_the_way_is_told(fmu, flown):
    system = texts(fmu, "refuse_text")
    with pytest.raises(RunError, match=r"answered Error to fmi2GetString\(text_out\): told not to show texts"):
        flown(system)
    later = System((system.components[0].with_values({"fault_time": AT}), system.components[1]), system.connections)
    assert flown(later).message == ("left (small_indirect.fmu) answered Error to fmi2GetString at t = 0.74 s: "
                                    "told not to show texts")


@pytest.mark.parametrize("flown", [here, plain, isolated])
def test_a_text_that_is_missing_is_empty(fmu, flown):
    assert flown(texts(fmu, "no_text")).finished


@pytest.mark.parametrize("flown", [here, plain, isolated])
def test_a_text_that_does_not_fit_is_told(fmu, flown):
    system = texts(fmu, "none")
    parts = system.components[0].with_values({"text_in": "x" * 4096}), system.components[1]
    with pytest.raises(RunError, match=r"^left \(small_.*\.fmu\) shows a text longer than 4095 bytes at t = 0 s\.$"):
        flown(System(parts, system.connections))


@pytest.mark.parametrize("plain", [False, True])
def test_a_text_that_becomes_empty_arrives_empty(fmu, plain):
    system = texts(fmu, "none")
    with open_files(system) as files:
        master = Master(system, files, plain=plain)
        master.initialise(0.0, 1.0)
        get = program.program([program.row(program.GET, master.wiring.outputs[0][-1].number)])
        found = [bytes(master.wiring.texts[0]).partition(b"\0")[0]]
        master.instances[0].set({"fault": small.FAULTS.index("no_text")})
        master.run(get, 0, 1, 0.0, 0.0)
        found.append(bytes(master.wiring.texts[0]).partition(b"\0")[0])
        shown = master.instances[0].get(["text_out", "whole_out"])
        master.close()
    assert found == [b"words", b""] and shown == ["", 0]


@pytest.mark.parametrize("name,value,allowed", [
    ("whole_in", 1e12, "between -2147483648 and 2147483647"), ("whole_in", -2 ** 31 - 1, "between -2147483648 and"),
    ("whole_in", 10 ** 400, "a number"), ("whole_in", 0.5, "a whole number"), ("whole_in", math.nan, "between"),
    ("u", 10 ** 400, "a number"), ("u", "1e999", "between"), ("text_in", "a\0b", "without null characters"),
    ("text_in", "\udcff", "without null characters"),
])
def test_a_value_that_does_not_fit_is_refused_before_anything_flies(fmu, name, value, allowed):
    with pytest.raises(UsageError, match=rf"^left\.{name} = .* is not allowed: it must be .*{allowed}"):
        here(small.pair(fmu, **{name: value}))


def test_each_type_comes_back_as_itself(fmu):
    with FmuFile.open(fmu) as file:
        instance = Instance(file, "a")
        given = {"truth_in": True, "u": 0.5, "text_in": "Höhe", "whole_in": -3}
        instance.set(given)
        found = dict(zip(given, instance.get(given)))
        instance.close()
    assert found == given and found["truth_in"] is True and isinstance(found["whole_in"], int)


@pytest.mark.parametrize("value", [2 ** 31 - 1, -2 ** 31])
def test_the_largest_whole_numbers_arrive(fmu, value):
    flight = fly(System([Component("a", fmu, {"whole_in": value})]), 0.1, 0.1)
    assert np.all(flight["a.whole_out"] == value)


def test_the_limits_themselves_are_allowed(fmu, tmp_path):
    limited = redescribed(fmu, tmp_path / "limited.fmu",
                          ('<Real start="0.0"/></ScalarVariable><!-- 15 -->',
                           '<Real start="0.0" min="-1.5" max="2.5"/></ScalarVariable>'))
    for value in (-1.5, 2.5):
        assert np.all(fly(System([Component("a", limited, {"u": value})]), 0.1, 0.1, record=["a.u"])["a.u"] == value)
    for value in (-1.5000001, 2.5000001):
        with pytest.raises(UsageError, match=r"^a\.u = .* is not allowed: it must be between -1\.5 and 2\.5\.$"):
            fly(System([Component("a", limited, {"u": value})]), 0.1, 0.1)


@pytest.mark.parametrize("flown", [here, plain, isolated])
def test_signals_that_are_no_numbers_are_told(fmu, flown):
    flight = flown(faulty(fmu, "not_a_number"))
    assert flight.finished and flight.warnings == [
        "left.y, left.y1, left.y2, right.y, right.y1 and 1 more signals are nan or infinite, first at t = 0.75 s: "
        "figures made of them tell nothing."]
    assert here(small.pair(fmu)).warnings == []


# --- after Fatal ------------------------------------------------------------------------------------------------------

def calls_after_fatal(instance):
    """How many calls any instance in the library of `instance` was given after one answered Fatal."""
    return ctypes.c_int.in_dll(instance.library.dll, "calls_after_fatal").value


@pytest.mark.parametrize("plain", [False, True])
@pytest.mark.parametrize("algorithm", ALGORITHMS)
def test_nothing_is_called_after_fatal(fmu, algorithm, plain):
    """Neither of this instance nor of another of the FMU, whose library they share (FMI 2.0 section 2.1.3)."""
    system = faulty(fmu, "fatal")
    with open_files(system) as files:
        master = Master(system, files, plain=plain)
        instances = list(master.instances)
        flight = fly_loaded(master, method(algorithm), 0.01, 100)
        assert "answered Fatal to fmi2DoStep" in flight.message
        for again in (lambda: master.reset(system), lambda: master.initialise(0.0, 1.0),
                      lambda: master.run(program.program([]), 0, 1, 0.0, 0.0), lambda: instances[1].get(["y"]),
                      lambda: instances[1].set({"u": 1.0}), lambda: instances[1].simple("fmi2Reset")):
            with pytest.raises(RunError, match="cannot be used any more: the FMU has answered Fatal"):
                again()
        master.close()
        master.close()
    assert [calls_after_fatal(i) for i in instances] == [0, 0]


@pytest.mark.parametrize("plain", [False, True])
@pytest.mark.parametrize("fault,algorithm,words", [("refuse_free", "variable", "told not to free"),
                                                   ("refuse_set", "jacobi,hold=linear", "told to take nothing")])
def test_nothing_is_called_after_fatal_within_a_row_of_the_program(tmp_path, fault, algorithm, words, plain):
    """Such as fmi2GetFMUstate after fmi2FreeFMUstate, or fmi2SetRealInputDerivatives after fmi2SetReal."""
    system = faulty(small.build(tmp_path, interpolates=True), fault)
    with open_files(system) as files:
        master = Master(system, files, plain=plain)
        instances = list(master.instances)
        assert fly_loaded(master, method(algorithm), 0.01, 100).message.endswith(f": {words}")
        master.close()
    assert [calls_after_fatal(i) for i in instances] == [0, 0]


@pytest.mark.parametrize("fault,sentence", [("fatal_init", "answered Fatal to fmi2EnterInitializationMode"),
                                            ("fatal_terminate", "")])
def test_nothing_is_called_after_fatal_at_either_end(fmu, fault, sentence):
    system = faulty(fmu, fault)
    with open_files(system) as files:
        master = Master(system, files)
        instances = list(master.instances)
        if sentence:
            with pytest.raises(RunError, match=sentence):
                master.initialise(0.0, 1.0)
        else:
            master.initialise(0.0, 1.0)
        master.close()
    assert [calls_after_fatal(i) for i in instances] == [0, 0] and files["left"].corrupted


def test_a_later_answer_does_not_undo_fatal_or_error(fmu):
    with FmuFile.open(fmu) as file:
        first, second = Instance(file, "a"), Instance(file, "b")
        for status in (ERROR, DISCARD):
            with pytest.raises(RunError):
                first.check(status, "fmi2DoStep")
        assert first.failed and first.alive and not second.failed
        for status in (FATAL, DISCARD):
            with pytest.raises(RunError):
                first.check(status, "fmi2DoStep")
        assert not first.alive and not second.alive
        first.close()
        second.close()


def test_every_instance_is_told_of_the_whole_experiment(fmu, monkeypatch):
    made: list[tuple[str, str, list[object]]] = []
    call = Instance.call

    def spy(instance, name, *arguments):
        made.append((instance.name, name, [a.value for a in arguments]))
        return call(instance, name, *arguments)

    monkeypatch.setattr(Instance, "call", spy)
    system = small.pair(fmu)
    with open_files(system) as files:
        master = Master(system, files)
        master.initialise(0.5, 3.0)
        master.close()
    for name in ("left", "right"):
        calls = [c for n, c, _ in made if n == name]
        assert calls.count("fmi2EnterInitializationMode") == calls.count("fmi2ExitInitializationMode") == 1
        assert [a for n, c, a in made if n == name and c == "fmi2SetupExperiment"] == [[0, 0.0, 0.5, 1, 3.0]]


@pytest.mark.parametrize("fault,lives,ends", [
    ("none", "", 0), ("none", "fly", 1), ("none", "fly reset", 0), ("error", "fly", 0), ("error", "fly reset fly", 1),
    ("discard", "fly", 1), ("refuse_init", "fly", 0),
])
def test_an_instance_is_terminated_where_that_is_allowed(fmu, fault, lives, ends):
    """Not before it can step, and not after an error, which only a reset undoes (FMI 2.0 section 4.2.4)."""
    with FmuFile.open(fmu) as file:
        instance = Instance(file, "a")
        made: list[str] = []
        call = instance.call
        instance.call = lambda name, *arguments: made.append(name) or call(name, *arguments)
        instance.set({"fault": small.FAULTS.index(fault), "fault_time": 0.0})
        instance.setup(0.0, 1.0)
        for life in lives.split():
            with suppress(RunError):
                fly_one(instance) if life == "fly" else instance.simple("fmi2Reset")
        instance.close()
        assert made.count("fmi2Terminate") == ends


def fly_one(instance):
    """From before initialisation to one step."""
    for call in ("fmi2EnterInitializationMode", "fmi2ExitInitializationMode"):
        instance.simple(call)
    real, flag = ctypes.c_double, ctypes.c_int
    instance.check(instance.call("fmi2DoStep", real(0.0), real(0.1), flag(1)), "fmi2DoStep", 0.0)


def test_another_extraction_of_the_file_can_be_used_after_fatal(fmu):
    assert "answered Fatal" in here(faulty(fmu, "fatal")).message and here(small.pair(fmu)).finished


# --- only one in a process --------------------------------------------------------------------------------------------

@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    return small.build(tmp_path_factory.mktemp("alone"), claims=("canBeInstantiatedOnlyOncePerProcess",))


@pytest.mark.parametrize("flown", [here, isolated])
def test_a_system_with_two_instances_of_an_fmu_that_allows_one_is_refused(alone, flown):
    with pytest.raises(UsageError, match=r"^right \(small_.*\.fmu\) cannot be instantiated beside left: the FMU allows "
                       r"only one instance in a process \(canBeInstantiatedOnlyOncePerProcess\)\.$"):
        flown(small.pair(alone))
    assert not ONLY_ONE


def test_one_instance_of_such_an_fmu_flies_again_and_again(alone, fmu):
    for _ in range(2):
        assert here(small.pair(alone, fmu)).finished
    assert not ONLY_ONE


# --- words ------------------------------------------------------------------------------------------------------------

def test_each_of_two_masters_keeps_the_words_of_its_own_fmus(fmu):
    first, second = faulty(fmu, "discard"), faulty(fmu, "error")
    with open_files(first) as files:
        masters = [Master(s, files) for s in (first, second)]
        flights = [fly_loaded(m, method("jacobi"), 0.01, 100) for m in masters]
        words = [m.instances[0].messages for m in masters]
        for master in masters:
            master.close()
    assert words == [["told to discard"], ["told to fail"]]
    assert [f.message.rpartition(": ")[2] for f in flights] == ["told to discard", "told to fail"]


def test_words_are_kept_by_name_where_the_fmu_hands_on_something_else(tmp_path):
    fmu = small.build(tmp_path, flags=("-DFORGETS_ENVIRONMENT",))
    assert here(faulty(fmu, "error")).message.endswith(": told to fail")


def test_a_closed_instance_leaves_nothing_behind(fmu):
    before = set(ENVIRONMENTS)
    here(small.pair(fmu))
    with pytest.raises(RunError):
        here(small.pair(fmu, text_in="refused"))
    assert set(ENVIRONMENTS) == before


def test_an_instance_that_is_not_made_is_told_and_leaves_nothing_behind(tmp_path):
    before = set(ENVIRONMENTS)
    with pytest.raises(RunError, match=r"^left \(small_indirect\.fmu\) cannot be instantiated: .* It said: told not"):
        here(small.pair(small.build(tmp_path, flags=("-DREFUSE_INSTANCE",))))
    assert set(ENVIRONMENTS) == before


def test_an_fmu_that_never_stops_talking_does_not_fill_the_memory(fmu):
    with FmuFile.open(fmu) as file:
        instance = Instance(file, "a")
        for k in range(MOST_MESSAGES + 5):
            log(instance.number, b"a", ERROR, b"", str(k).encode())
        instance.close()
    assert len(instance.messages) == MOST_MESSAGES


def test_a_call_of_many_variables_names_the_first(fmu):
    with FmuFile.open(fmu) as file:
        instance = Instance(file, "a")
        instance.set({"fault": small.FAULTS.index("refuse_get"), "fault_time": 0.0})
        instance.setup(0.0, 1.0)
        for call in ("fmi2EnterInitializationMode", "fmi2ExitInitializationMode"):
            instance.simple(call)
        for names, shown in ((["y", "y1", "y2"], "y, y1, y2"), (["y", "y1", "y2", "u"], r"y, y1, y2, \.\.\.")):
            with pytest.raises(RunError, match=rf"fmi2GetReal\({shown}\): told not to show anything$"):
                instance.get(names)
        instance.close()


def test_a_call_is_known_as_long_as_it_lasts(fmu, monkeypatch):
    place = last_call.Place()
    monkeypatch.setattr(last_call, "place", place)
    with FmuFile.open(fmu) as file:
        instance = Instance(file, "a")
        made = int(place.cursor[program.CALLS])
        assert place.stage[0] == last_call.OUTSIDE
        instance.get(["y", "whole_out"])
        assert (place.stage[0], place.cursor[program.CALLS]) == (last_call.OUTSIDE, made + 2)
        assert place.read(last_call.NOTE) == "a (small_indirect.fmu): fmi2GetInteger"
        instance.close()
        assert place.stage[0] == last_call.OUTSIDE
        assert place.read(last_call.NOTE) == "a (small_indirect.fmu): fmi2FreeInstance"


def test_both_loops_count_their_calls_alike(fmu):
    counts = []
    for plain in (False, True):
        system = small.pair(fmu)
        with open_files(system) as files:
            master = Master(system, files, plain=plain)
            fly_loaded(master, method("jacobi"), 0.01, 100)
            counts.append(int(master.cursor[program.CALLS]))
            master.close()
    assert counts[0] == counts[1] > 2 * 100 * 3  # set, step and get of both


@pytest.mark.parametrize("plain", [False, True])
@pytest.mark.parametrize("algorithm,final", [("jacobi", 1), ("gauss-seidel", 1), ("iterated", 0), ("variable", 0)])
def test_a_step_that_may_be_taken_back_is_not_called_final(tmp_path, algorithm, final, plain):
    """noSetFMUStatePriorToCurrentPoint (FMI 2.0 section 4.2.2)."""
    fmu = small.build(tmp_path, direct=None if algorithm == "iterated" else False, flags=("-DSHOWS_KEEP",))
    flight = fly(small.pair(fmu), 0.01, 0.1, algorithm, plain=plain)
    assert flight.finished and set(flight["left.whole_out"][1:]) == set(flight["right.whole_out"][1:]) == {final}


def test_what_is_only_recorded_is_read_on_recorded_ticks_only(fmu):
    counts = {}
    for decimate in (1, 10, 100):
        system = small.pair(fmu)
        with open_files(system) as files:
            master = Master(system, files, ["*.y1"], apart=True)
            before = int(master.cursor[program.CALLS])
            fly_loaded(master, method("jacobi"), 0.01, 100, decimate=decimate)
            counts[decimate] = int(master.cursor[program.CALLS]) - before
            master.close()
    assert (counts[1] - counts[10], counts[10] - counts[100]) == (2 * 90, 2 * 9)


def test_every_saved_state_is_freed(tmp_path, monkeypatch):
    freed = []
    free = Instance.free_state
    monkeypatch.setattr(Instance, "free_state", lambda self, place: freed.append(self.name) or free(self, place))
    assert here(small.pair(small.build(tmp_path, direct=None)), "iterated").finished
    assert sorted(freed) == ["left", "right"]


def test_the_logger_takes_what_fmus_hand_it():
    log(None, None, ERROR, b"", None)
    log(12345678901, b"nobody", -1, b"", b"\xff")
