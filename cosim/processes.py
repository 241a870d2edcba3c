"""Processes below one of ours: who they are, and their end. Knowledge of Linux; elsewhere there is less of it."""
import contextlib
import ctypes
import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

SUBREAPER, PARENT_DEATH = 36, 1  # prctl: orphans below come to this process; a signal when its parent dies


def prctl(option: int, value: int) -> None:
    """Linux's prctl; nothing elsewhere."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(option, value, 0, 0, 0)


def as_worker() -> None:
    """Make this process, which multiprocessing began, a worker: Ctrl-C is for the parent, and the worker does not
    outlive it, not even in an FMU's call."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    prctl(PARENT_DEATH, signal.SIGKILL)
    threading.Thread(target=end_with_parent, daemon=True).start()


def end_with_parent() -> None:
    """Wait for the end of the parent process, then end this one."""
    from multiprocessing import parent_process

    parent = parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)


def end_all() -> None:
    """Kill all processes below this one, until there are none left."""
    while found := below(os.getpid()):
        for how in (signal.SIGSTOP, signal.SIGKILL):  # stopped first: what is stopped starts nothing
            for pid in found:
                with contextlib.suppress(ProcessLookupError, PermissionError):
                    os.kill(pid, how)
        time.sleep(0.001)


def below(ancestor: int) -> list[int]:
    """The running processes that descend from `ancestor`; without /proc, none."""
    children: dict[int, list[int]] = {}
    for pid, state, parent in processes():
        if state not in "ZX":
            children.setdefault(parent, []).append(pid)
    found = list(children.get(ancestor, ()))
    for pid in found:
        found.extend(children.get(pid, ()))
    return found


def processes() -> Iterator[tuple[int, str, int]]:
    """(process, state, parent) of all processes that /proc shows."""
    for pid in filter(str.isdigit, os.listdir("/proc") if os.path.isdir("/proc") else ()):
        with contextlib.suppress(OSError):
            fields = Path("/proc", pid, "stat").read_text("utf-8", "replace").rpartition(")")[2].split()
            yield int(pid), fields[0], int(fields[1])
