"""The guard of a flight: what the worker started ends with it, and both end with the program."""
import os
import signal
import subprocess
import sys
import time

import psutil
import pytest

from cosim.master.guard import Guarded
from cosim.master.last_call import Place
from cosim.temporary import Folder

SLEEP = "87654.3"  # of the processes that a worker starts here


def sleepers():
    return [p for p in psutil.process_iter(["cmdline"]) if p.info["cmdline"] == ["sleep", SLEEP]]


def none_within(seconds=10.0):
    until = time.monotonic() + seconds
    while sleepers() and time.monotonic() < until:
        time.sleep(0.02)
    return sleepers() == []


def escape():
    """Start a process in a session of its own, whose parent goes."""
    subprocess.run(["setsid", "--fork", "sleep", SLEEP], check=True)
    while not sleepers():
        time.sleep(0.02)


@pytest.fixture
def guarded():
    """Makes guards whose workers do something, with no files to share."""
    from multiprocessing import Pipe

    folder, place = Folder(), Place()

    def make(work):
        ends = Pipe(duplex=False)
        made = Guarded(work, folder.path, place.status, ends)
        ends[1].close()
        return made, ends[0], folder.path

    return make


def test_the_end_of_a_worker_is_told_and_its_folder_goes(guarded):
    worker, end, folder = guarded(lambda: os._exit(3))
    with pytest.raises(EOFError):
        end.recv()
    while folder.exists():
        time.sleep(0.01)
    assert os.waitstatus_to_exitcode(worker.end()) == 3 == os.waitstatus_to_exitcode(worker.end())


@pytest.mark.parametrize("then", [lambda: os._exit(0), lambda: os.kill(os.getpid(), signal.SIGSEGV), signal.pause])
def test_what_a_worker_started_ends_with_it(guarded, then):
    """Also in a session of its own; also if the worker is ended by the program."""
    worker, _, folder = guarded(lambda: (escape(), then()))
    while not sleepers() and then is signal.pause:
        time.sleep(0.02)
    if then is not signal.pause:
        time.sleep(1.0)
    worker.end()
    assert none_within() and not folder.exists()


@pytest.mark.parametrize("how", [signal.SIGTERM, signal.SIGINT, signal.SIGHUP])
def test_the_guard_itself_takes_no_signal_that_asks_for_an_end(guarded, how):
    worker, end, _ = guarded(signal.pause)
    time.sleep(0.3)
    os.kill(worker.guard, how)
    assert not end.poll(0.3)
    worker.end()


def test_a_guard_that_is_killed_takes_its_worker_along(guarded):
    worker, end, _ = guarded(signal.pause)
    time.sleep(0.3)
    os.kill(worker.guard, signal.SIGKILL)
    with pytest.raises(EOFError):
        end.recv()
    assert os.waitstatus_to_exitcode(worker.end()) == -signal.SIGKILL


def test_asking_is_a_sigterm_for_the_worker(guarded):
    worker, end, _ = guarded(lambda: (signal.signal(signal.SIGTERM, lambda *_: os._exit(7)), signal.pause()))
    time.sleep(0.5)
    worker.ask()
    with pytest.raises(EOFError):
        end.recv()
    assert os.waitstatus_to_exitcode(worker.end()) == 7


PROGRAM = f"""
import os, signal, subprocess
from multiprocessing import Pipe
from cosim.master.guard import Guarded
from cosim.master.last_call import Place
from cosim.temporary import Folder
folder, place = Folder(), Place()
def work():
    subprocess.run(["setsid", "--fork", "sleep", "{SLEEP}"])
    signal.pause()
made = Guarded(work, folder.path, place.status, Pipe(duplex=False))
print(folder.path, flush=True)
signal.pause()
"""


def test_all_ends_with_a_program_that_is_killed(tmp_path):
    program = subprocess.Popen([sys.executable, "-c", PROGRAM], stdout=subprocess.PIPE, text=True,
                               env=os.environ | {"TMPDIR": str(tmp_path)})
    program.stdout.readline()
    while not sleepers():
        time.sleep(0.02)
    program.kill()
    program.wait()
    assert none_within()
    until = time.monotonic() + 10
    while list(tmp_path.iterdir()) and time.monotonic() < until:
        time.sleep(0.02)
    assert list(tmp_path.iterdir()) == []
