"""An FMU ends the simulation (fmi2Discard with fmi2Terminated): the run ends well there. And how FMUs are ended."""
import json
import os
import signal
import subprocess
import time

import numpy as np
import pytest
import small
from command import carried_out
from places import AHV

from cosim.errors import UsageError
from cosim.master import isolated as isolated_module
from cosim.master import last_call, loaded
from cosim.master.fly import fly
from cosim.master.isolated import Parent, cause_of_death, fly_isolated
from cosim.master.system import System
from cosim.ssp.write import write

ALGORITHMS = ["gauss-seidel", "jacobi", "jacobi,hold=linear", "multi-rate,right=1", "iterated"]


def ending(fmu, at, **values):
    return small.pair(fmu, fault=small.FAULTS.index("end"), fault_time=at, **values)


def here(system, algorithm, **options):
    return fly(system, 0.01, 1.0, algorithm, **options)


def plain(system, algorithm):
    return here(system, algorithm, plain=True)


def isolated(system, algorithm):
    return fly_isolated(system, 0.01, 1.0, algorithm)


def well_ended(flight, at):
    return flight.finished and flight.ended_at == pytest.approx(at, abs=1e-12) and flight.message == (
        f"left (small_indirect.fmu) ended the simulation at t = {at:g} s: told to end")


@pytest.mark.parametrize("flown", [here, plain, isolated])
@pytest.mark.parametrize("algorithm", [*ALGORITHMS, "variable,tolerance=1e-3"])
def test_a_run_ends_well_where_an_fmu_ends_the_simulation(tmp_path, algorithm, flown):
    """`left` steps first, so that `right` follows it to that time, in the middle of a step."""
    fmu = small.build(tmp_path)
    flight = flown(ending(fmu, 0.745), algorithm)
    assert well_ended(flight, 0.745), flight.message
    assert flight.time[-1] == pytest.approx(0.745, abs=1e-12) and flight.ticks == len(flight.time) - 1
    if not algorithm.startswith("variable"):
        undisturbed = here(small.pair(fmu), algorithm)
        assert flight.time[:-1].tobytes() == undisturbed.time[:75].tobytes()
        assert flight.signals[:-1].tobytes() == undisturbed.signals[:75].tobytes()
    assert np.abs(flight.signals[-1] - fly(small.pair(fmu), 0.005, 1.0).signals[149]).max() < 0.02


@pytest.mark.parametrize("flown", [here, plain, isolated])
@pytest.mark.parametrize("right,order,end", [
    ({}, "right+left", 0.74),                   # right has stepped to 0.75 already
    ({"any_step": False}, "left+right", 0.74),  # right cannot step to 0.745
    ({"any_step": False}, "right+left", 0.74),
])
def test_no_row_is_made_of_two_times(tmp_path, flown, right, order, end):
    system = small.pair(small.build(tmp_path), small.build(tmp_path, **right), fault=small.FAULTS.index("end"),
                        fault_time=0.745)
    flight = flown(system, f"gauss-seidel,order={order}")
    assert well_ended(flight, 0.745) and flight.time[-1] == pytest.approx(end, abs=1e-12)
    assert flight.ticks == len(flight.time) - 1 == 74


@pytest.mark.parametrize("algorithm,direct,last", [("iterated", None, 0.74), ("multi-rate,left=5", False, 0.7),
                                                   ("multi-rate,right=5", False, 0.74)])
def test_where_the_others_cannot_follow_the_last_row_is_a_communication_point(tmp_path, algorithm, direct, last):
    """Steps that are repeated, or that are not equally long."""
    system = small.pair(small.build(tmp_path, direct), fault=small.FAULTS.index("end"), fault_time=0.745)
    flight = here(system, algorithm)
    assert flight.finished and flight.ended_at == pytest.approx(0.745, abs=1e-12)
    assert flight.time[-1] == pytest.approx(last, abs=1e-12) and flight.ticks == len(flight.time) - 1


def test_the_others_follow_from_where_they_are(tmp_path):
    """right would refuse a step that begins later than at 0.74 s."""
    left, right = ending(small.build(tmp_path), 0.745).components
    refuses = right.with_values({"fault": small.FAULTS.index("discard"), "fault_time": 0.743})
    flight = here(System((left, refuses), small.pair(left.fmu).connections), "gauss-seidel")
    assert well_ended(flight, 0.745) and flight.time[-1] == pytest.approx(0.745, abs=1e-12)


def test_an_fmu_that_flies_alone_ends_between_two_communication_points(tmp_path):
    fmu = small.build(tmp_path, any_step=False)
    alone = System((ending(fmu, 0.745).components[0],))
    flight = here(alone, "jacobi")
    assert flight.finished and (flight.ended_at, flight.time[-1]) == pytest.approx((0.745, 0.745), abs=1e-12)


@pytest.mark.parametrize("algorithm", [*ALGORITHMS, "gauss-seidel,order=right+left", "variable,tolerance=1e-3"])
@pytest.mark.parametrize("at", [0.0, 0.74])
def test_an_fmu_that_ends_where_a_step_begins(tmp_path, algorithm, at):
    flight = here(ending(small.build(tmp_path), at), algorithm)
    assert well_ended(flight, at) and flight.time[-1] == pytest.approx(at, abs=1e-12)
    assert flight.ticks == len(flight.time) - 1


@pytest.mark.parametrize("algorithm", [*ALGORITHMS, "gauss-seidel,order=right+left"])
@pytest.mark.parametrize("decimate", [1, 7])
def test_an_fmu_that_ends_with_the_step(tmp_path, algorithm, decimate):
    """It has computed the whole step: the row is that of an undisturbed flight."""
    fmu = small.build(tmp_path, flags=("-DEND_WITH_STEP",), any_step=False)
    flight = fly(ending(fmu, 0.745), 0.01, 1.0, algorithm, decimate=decimate)
    whole = fly(small.pair(fmu), 0.01, 1.0, algorithm)
    assert flight.finished and flight.ended_at == pytest.approx(0.75, abs=1e-12) and flight.ticks == 75
    kept = [*range(0, 75, decimate), 75]
    assert np.allclose(flight.time, whole.time[kept], rtol=0, atol=1e-12)
    assert flight.signals.tobytes() == whole.signals[kept].tobytes()


@pytest.mark.parametrize("flags,time", [(("-DNO_TIME",), 0.74), (("-DODD_TIME=NAN",), 0.74), (("-DODD_TIME=9",), 0.75),
                                        (("-DODD_TIME=-9",), 0.74)])
def test_an_fmu_that_ends_and_does_not_say_when(tmp_path, flags, time):
    flight = here(ending(small.build(tmp_path, flags=flags), 0.745), "gauss-seidel")
    assert flight.finished and flight.ended_at == pytest.approx(time, abs=1e-12)


@pytest.mark.parametrize("flown", [here, plain, isolated])
def test_an_fmu_that_does_not_say_whether_it_ended_has_failed(tmp_path, flown):
    flight = flown(ending(small.build(tmp_path, flags=("-DREFUSE_STATUS",)), 0.745), "gauss-seidel")
    assert (flight.finished, flight.ended_at, len(flight.time)) == (False, None, 75)
    assert flight.message.startswith("left (small_indirect.fmu) answered Discard to fmi2DoStep at t = 0.74 s: ")


@pytest.mark.parametrize("fault,sentence", [
    ("crash_terminate", "crashed (SIGSEGV) in fmi2Terminate"), ("crash_free", "crashed (SIGSEGV) in fmi2FreeInstance"),
    ("hang_terminate", "did not come back within 0.5 s from fmi2Terminate"),
])
@pytest.mark.parametrize("algorithm", ["gauss-seidel", "variable"])
def test_a_crash_after_the_flight_is_named_and_every_tick_is_kept(tmp_path, fault, sentence, algorithm):
    fmu = small.build(tmp_path)
    flight = fly_isolated(small.pair(fmu, fault=small.FAULTS.index(fault)), 0.01, 1.0, algorithm, time_limit=0.5)
    whole = fly(small.pair(fmu), 0.01, 1.0, algorithm)
    assert (flight.finished, flight.message) == (False, f"left (small_indirect.fmu) {sentence}")
    assert flight.ticks == whole.ticks and flight.wall_s > 0
    assert flight.time.tobytes() == whole.time.tobytes() and flight.signals.tobytes() == whole.signals.tobytes()


def test_a_crash_after_a_flight_that_failed_is_named_as_well(tmp_path):
    fmu = small.build(tmp_path)
    parts = small.pair(fmu, fault=small.FAULTS.index("discard"), fault_time=0.74).components
    right = parts[1].with_values({"fault": small.FAULTS.index("crash_free")})
    flight = fly_isolated(System((parts[0], right)), 0.01, 1.0, "jacobi")
    assert not flight.finished and flight.ticks == 74 and flight.message == (
        "left (small_indirect.fmu) answered Discard to fmi2DoStep at t = 0.74 s: told to discard; then right "
        "(small_indirect.fmu) crashed (SIGSEGV) in fmi2FreeInstance; it had said: told to discard")


def test_a_crash_between_steps_of_any_length_keeps_count_of_them(tmp_path):
    fmu = small.build(tmp_path)
    flight = fly_isolated(small.pair(fmu, fault=small.FAULTS.index("crash"), fault_time=0.74), 0.01, 1.0, "variable")
    assert not flight.finished and flight.ticks == len(flight.time) - 1 > 20
    assert flight.message.startswith("left (small_indirect.fmu) crashed (SIGSEGV) in fmi2DoStep at t = 0.7")


def test_an_fmu_that_ends_its_process_is_named(tmp_path):
    """In a program of its own: here exit() would end what other tests have loaded."""
    system = small.pair(small.build(tmp_path), fault=small.FAULTS.index("leave"), fault_time=0.74)
    write(tmp_path / "pair.ssp", "pair", system, 0.01, 1.0)
    command = [AHV, "simulate", tmp_path / "pair.ssp", "--algorithm", "jacobi", "--out", tmp_path / "out"]
    assert subprocess.run(command, capture_output=True).returncode == 1
    told = json.loads((tmp_path / "out" / "run.json").read_text())
    assert told["ticks"] == 74 and told["message"] == (
        "left (small_indirect.fmu) ended its process (exit status 3) in fmi2DoStep at t = 0.74 s")


def test_only_fmu_calls_count_for_the_time_limit(tmp_path, monkeypatch):
    """Not what comes before, nor the waits of a paced flight; each call counts by itself."""
    def slow_loop(*arguments):
        time.sleep(1.0)
        return make_loop(*arguments)

    make_loop = loaded.make_loop
    monkeypatch.setattr(loaded, "make_loop", slow_loop)
    slow = small.FAULTS.index("slow_init")
    system = small.pair(small.build(tmp_path), fault=slow)
    system = System((system.components[0], system.components[1].with_values({"fault": slow})), system.connections)
    flight = fly_isolated(system, 0.7, 1.4, "jacobi", time_limit=0.5, real_time=1.0)
    assert flight.finished, flight.message


@pytest.mark.parametrize("isolate,limit,place", [(False, None, "here"), (True, None, "apart"), (False, 0.5, "apart"),
                                                 (True, 0.5, "apart")])
def test_a_process_of_its_own_comes_with_a_time_limit_or_on_demand(monkeypatch, isolate, limit, place):
    for name, answer in (("fly", "here"), ("fly_isolated", "apart")):
        monkeypatch.setattr(isolated_module, name, lambda *arguments, answer=answer, **options: answer)
    assert isolated_module.launch(None, 0.01, 1.0, isolate=isolate, time_limit=limit) == place


@pytest.mark.parametrize("limit", [0.0, -1.0, float("nan")])
def test_a_time_limit_that_is_none_is_refused(tmp_path, limit):
    with pytest.raises(UsageError, match=rf"^--time-limit {limit:g} must be a positive number of seconds\.$"):
        fly_isolated(small.pair(small.build(tmp_path)), 0.01, 1.0, "jacobi", time_limit=limit)


def test_a_process_that_is_ended_outside_of_any_call_is_told():
    child = os.fork()
    if child == 0:
        os.kill(os.getpid(), signal.SIGKILL)
    cause, place = cause_of_death(os.waitpid(child, 0)[1]), last_call.Place()
    parent = Parent(None, None, place, None, None, None, [])
    assert parent.told(f"{cause} in") == "The process of the flight crashed (SIGKILL) outside of all FMU calls"
    place.stage[0] = last_call.TICKING
    assert parent.told(f"{cause} in") == "An FMU crashed (SIGKILL) in the exchange of initial values"


def simulated(folder, *flags, status=0, **values):
    write(folder / "pair.ssp", "pair", small.pair(small.build(folder), **values), 0.01, 1.0)
    done = carried_out("simulate", folder / "pair.ssp", "--json", "--out", folder / "out", *flags)
    assert done.returncode == status, done.stderr
    return json.loads(done.stdout), json.loads((folder / "out" / "run.json").read_text()), done.stderr


def test_the_command_line_takes_an_end_for_no_failure(tmp_path):
    printed, record, said = simulated(tmp_path, fault=small.FAULTS.index("end"), fault_time=0.745)
    words = "left (small_indirect.fmu) ended the simulation at t = 0.745 s: told to end"
    for found in (printed, record):
        assert [found[k] for k in ("finished", "departed_at_s", "ended_at_s", "ticks")] == [True, None, 0.745, 75]
    assert said == f"ahv: {words}\n" and record["message"] == words and record["warnings"] == []


def test_the_command_line_tells_of_signals_that_are_no_numbers(tmp_path):
    _, record, said = simulated(tmp_path, fault=small.FAULTS.index("not_a_number"), fault_time=0.745)
    assert record["warnings"] and said == f"ahv: {record['warnings'][0]}\n" and "first at t = 0.76 s" in said
