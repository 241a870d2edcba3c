"""What the user sees when an FMU discards, fails, hangs, crashes; and what is kept of the run."""
import os
import signal
import threading
from pathlib import Path

import psutil
import pytest
import small

from cosim.errors import RunError, UsageError
from cosim.master.algorithms import method
from cosim.master.fly import fly, fly_loaded
from cosim.master.isolated import fly_isolated
from cosim.master.loaded import Master, open_files
from cosim.temporary import PREFIX

AT = 0.74


def faulty(folder, fault):
    return small.pair(small.build(folder), fault=small.FAULTS.index(fault), fault_time=AT)


def isolated(system, algorithm="jacobi"):
    return fly_isolated(system, 0.01, 1.0, algorithm, time_limit=0.5)


def here(system):
    return fly(system, 0.01, 1.0, "jacobi")


def plain(system):
    return fly(system, 0.01, 1.0, "jacobi", plain=True)


@pytest.mark.parametrize("flown", [here, isolated, plain])
@pytest.mark.parametrize("fault,sentence,rows", [
    ("discard", "answered Discard to fmi2DoStep at t = 0.74 s: told to discard", 75),
    ("error", "answered Error to fmi2DoStep at t = 0.74 s: told to fail", 75),
    ("fatal", "answered Fatal to fmi2DoStep at t = 0.74 s: told to fail for good", 75),
    ("refuse_get", "answered Error to fmi2GetReal at t = 0.74 s: told not to show anything", 74),
])
def test_a_refusal_is_told_and_what_was_flown_is_kept(tmp_path, flown, fault, sentence, rows):
    flight = flown(faulty(tmp_path, fault))
    assert not flight.finished and flight.message == f"left (small_indirect.fmu) {sentence}"
    assert len(flight.time) == len(flight.signals) == rows


@pytest.mark.parametrize("fault,sentence", [
    ("hang", "did not come back within 0.5 s from fmi2DoStep at t = 0.74 s"),
    ("crash", "crashed (SIGSEGV) in fmi2DoStep at t = 0.74 s"),
])
@pytest.mark.parametrize("algorithm", ["jacobi", "iterated"])
def test_a_hang_or_a_crash_is_told_and_what_was_flown_is_kept(tmp_path, fault, sentence, algorithm):
    flight = isolated(faulty(tmp_path, fault), algorithm)
    assert not flight.finished and flight.message == f"left (small_indirect.fmu) {sentence}"
    whole = fly(small.pair(tmp_path / "small_indirect.fmu"), 0.01, 1.0, algorithm)
    assert flight.time.tobytes() == whole.time[:75].tobytes()
    assert flight.signals.tobytes() == whole.signals[:75].tobytes()


@pytest.mark.parametrize("fault,sentence", [
    ("refuse_init", "answered Error to fmi2EnterInitializationMode: told not to initialise"),
    ("hang_init", "did not come back within 0.5 s from fmi2EnterInitializationMode"),
])
def test_a_failure_before_the_first_tick_is_told(tmp_path, fault, sentence):
    with pytest.raises(RunError) as caught:
        isolated(faulty(tmp_path, fault))
    assert str(caught.value) == f"left (small_indirect.fmu) {sentence}"


def test_isolated_is_the_same_flight(tmp_path):
    system = small.pair(small.build(tmp_path))
    here, there = fly(system, 0.001, 10.0), isolated_long(system, tmp_path)
    assert here.signals.tobytes() == there.signals.tobytes() and here.parameters == there.parameters


def test_progress_of_an_isolated_flight_is_told_the_time(tmp_path):
    told = []
    fly_isolated(small.pair(small.build(tmp_path)), 0.01, 1.0, "jacobi", told.append)
    assert told == sorted(told) and told[-1] == pytest.approx(1.0)


def isolated_long(system, folder):
    return fly_isolated(system, 0.001, 10.0, "gauss-seidel")


def test_wrong_use_stays_wrong_use_in_isolation(tmp_path):
    with pytest.raises(UsageError, match="no variable lft"):
        isolated(small.pair(small.build(tmp_path), lft=1.0))


@pytest.mark.parametrize("flown", [fly, fly_isolated])
def test_an_interrupted_run_keeps_its_rows(tmp_path, flown):
    system, begun = small.pair(small.build(tmp_path), substeps=200.0), []

    def tell(t):
        if not begun:
            threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGTERM)).start()
        begun.append(t)

    flight = flown(system, 0.001, 3000.0, "jacobi", tell, record=["left.y"])
    assert not flight.finished and flight.message.startswith("Interrupted at t = ")
    assert len(flight.time) == flight.ticks + 1 > 100


def test_an_interrupt_ends_a_flight_that_hangs(tmp_path):
    """A second one shortly afterwards, as `timeout` sends it, changes nothing."""
    timers = [threading.Timer(wait, os.kill, (os.getpid(), signal.SIGTERM)) for wait in (1.0, 1.1)]
    begun = []

    def tell(t):
        for timer in () if begun else timers:
            timer.start()
        begun.append(t)

    former = signal.signal(signal.SIGTERM, lambda *_: None)  # for a second one that comes late
    flight = fly_isolated(faulty(tmp_path, "hang"), 0.01, 1.0, "jacobi", tell)
    for timer in timers:
        timer.join()
    signal.signal(signal.SIGTERM, former)
    assert flight.interrupted == signal.SIGTERM and not flight.finished and len(flight.time) == 75
    assert flight.message == "left (small_indirect.fmu) was interrupted in fmi2DoStep at t = 0.74 s"


def grown(fly_once, times):
    """Memory (bytes), open files and temporary files that `times` flights leave behind, after a few to warm up."""
    def held():
        return process.memory_info().rss, process.num_fds(), len(list(Path("/tmp").glob(f"ahv_{os.getpid()}*")))

    process = psutil.Process()
    for _ in range(times // 4 + 1):
        fly_once()
    before = held()
    for _ in range(times):
        fly_once()
    return [b - a for a, b in zip(before, held())]


@pytest.mark.parametrize("times", [100, pytest.param(1000, marks=pytest.mark.slow)])
def test_many_runs_leave_nothing_behind(tmp_path, monkeypatch, times):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    system = small.pair(small.build(tmp_path))

    memory, files, _ = grown(lambda: fly(system, 0.01, 1.0, "iterated"), times)
    assert files == 0 and memory < 3e6
    assert not list(tmp_path.glob(f"{PREFIX}*"))


def test_loaded_fmus_fly_again_after_reset(tmp_path):
    fmu = small.build(tmp_path)
    first, second = small.pair(fmu), small.pair(fmu, x1=2.0)
    with open_files(first) as files:
        master = Master(first, files)
        try:
            flights = []
            for system in (first, second, first):
                master.reset(system)
                flights.append(fly_loaded(master, method("jacobi"), 0.01, 100))
        finally:
            master.close()
    expected = [fly(s, 0.01, 1.0, "jacobi").signals for s in (first, second)]
    assert np_equal(flights[0], expected[0]) and np_equal(flights[1], expected[1]) and np_equal(flights[2], expected[0])


def np_equal(flight, signals):
    return flight.signals.tobytes() == signals.tobytes()
