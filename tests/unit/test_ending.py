"""Signals that end the command line: once, as exceptions, and again where one was swallowed."""
import os
import signal
import subprocess
import sys

import pytest

BEGIN = "import os, signal, time, weakref\nfrom cosim.cli.ending import ending\n"


def program(code, *arguments):
    """What a program with `code` in the context `ending` answers and prints."""
    body = "".join(f"    {line}\n" for line in code.splitlines())
    done = subprocess.run([sys.executable, "-c", f"{BEGIN}with ending():\n{body}print('after')", *arguments], text=True,
                          capture_output=True, timeout=60,
                          preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
    return done.returncode, done.stdout


@pytest.mark.parametrize("name,status", [("SIGTERM", 143), ("SIGHUP", 129)])
def test_a_signal_ends_the_program_with_its_status(name, status):
    assert program(f"os.kill(os.getpid(), signal.{name})\ntime.sleep(9)") == (status, "")


def test_ctrl_c_is_a_keyboard_interrupt():
    assert program("try: signal.raise_signal(signal.SIGINT)\nexcept KeyboardInterrupt: print('caught')")[1].startswith(
        "caught\n")


@pytest.mark.parametrize("name", ["SIGTERM", "SIGINT"])
def test_an_exception_that_is_swallowed_comes_again(name):
    """In a callback of a weak reference, as imports have them."""
    code = ("class Some: pass\nsome = Some()\n"
            f"callback = weakref.ref(some, lambda _: signal.raise_signal(signal.{name}))\n"
            "del some\nprint('swallowed', flush=True)\ntime.sleep(9)\nprint('never')")
    status, said = program(code)
    assert status in (143, -signal.SIGINT) and said == "swallowed\n"


@pytest.mark.parametrize("first", ["SIGTERM", "SIGINT"])
@pytest.mark.parametrize("second", ["SIGTERM", "SIGINT", "SIGHUP"])
def test_what_closes_things_is_not_disturbed(first, second):
    code = (f"try:\n    signal.raise_signal(signal.{first})\nfinally:\n    time.sleep(0.5)\n"
            f"    signal.raise_signal(signal.{second})\n    print('closed', flush=True)")
    assert program(code)[1] == "closed\n"


def test_a_signal_in_held_blocks_is_an_entry_and_not_an_exception():
    code = ("from cosim.master.interruptions import interruptions\nfrom cosim.cli.ending import end\n"
            "with interruptions() as caught:\n    end(signal.SIGTERM)\n    print([int(n) for n in caught], flush=True)")
    assert program(code)[1].startswith(f"[{int(signal.SIGTERM)}]\n")


def test_after_the_context_nothing_more_happens():
    code = f"{BEGIN}with ending(): pass\nsignal.raise_signal(signal.SIGTERM)\ntime.sleep(0.5)\nprint('end')"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, "end\n")


def test_a_signal_that_is_ignored_stays_ignored():
    done = subprocess.run([sys.executable, "-c", f"{BEGIN}with ending(): signal.raise_signal(signal.SIGHUP)"],
                          preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN), env=os.environ)
    assert done.returncode == 0


@pytest.mark.parametrize("name, status", [("SIGTERM", 143), ("SIGINT", 130)])
def test_a_call_that_does_not_come_back_is_ended_and_its_temporary_folder_goes(name, status, tmp_path, monkeypatch):
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    code = ("import ctypes, threading\nfrom cosim.cli import ending as it\nfrom cosim.temporary import Folder\n"
            "it.PATIENCE_S = 0.2\nfolder, lock = Folder(), ctypes.create_string_buffer(256)\n"
            f"threading.Timer(0.5, os.kill, (os.getpid(), signal.{name})).start()\n"
            "with it.ended_in_any_case():\n"
            "    for _ in range(2): ctypes.CDLL(None).pthread_mutex_lock(lock)")
    assert program(code) == (status, "") and list(tmp_path.iterdir()) == []


def test_what_was_wired_for_signals_before_is_there_afterwards():
    code = ("from cosim.cli.ending import ended_in_any_case\nhere, there = os.pipe()\nos.set_blocking(there, False)\n"
            "signal.set_wakeup_fd(there)\nwith ended_in_any_case(): pass\nprint(signal.set_wakeup_fd(-1) == there)")
    assert program(code) == (0, "True\nafter\n")
