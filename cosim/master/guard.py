"""A process that flies, and its guard: whatever ends the flight or the program, nothing that it started lives on.

Three processes: the program, the guard, and the worker that calls the FMUs. The guard ends the worker and all that the
worker started when the program says so or is gone, and when the worker has ended; then it removes their temporary
folder. All three are forks of the program.
"""
import contextlib
import os
import select
import signal
import time
from collections.abc import Callable
from multiprocessing.connection import Connection as End
from pathlib import Path

import numpy as np

from ..processes import PARENT_DEATH, SUBREAPER, end_all, prctl
from ..temporary import empty
from .interruptions import ASKING

LOOK_S = 0.05
POSSIBLE = hasattr(os, "fork")


class Guarded:
    """A running worker with its guard, as the program sees them."""

    def __init__(self, work: Callable[[], None], folder: Path, status: np.ndarray, ends: tuple[End, End]):
        """Begin `work` in a worker. `folder` is temporary; the guard writes how the worker ended (as os.waitpid tells
        it) to `status`, shape (1,), which is shared memory; of `ends` the worker has the second only."""
        orders, self.orders = os.pipe()
        self.status, program = status, os.getpid()
        self.status[0] = -1
        self.guard: int | None = os.fork()
        if self.guard == 0:
            try:
                os.close(self.orders)
                keep(work, folder, status, ends, orders, program)
            finally:
                os._exit(1)
        os.close(orders)

    def ask(self) -> None:
        """SIGTERM for the worker."""
        with contextlib.suppress(BrokenPipeError):
            os.write(self.orders, b"t")

    def end(self) -> int:
        """End the worker and all that it started; how it ended, as os.waitpid tells it. It may be gone already."""
        if self.guard is not None:
            os.close(self.orders)
            _, status = os.waitpid(self.guard, 0)
            self.guard = None
            if self.status[0] < 0:  # killed itself
                self.status[0] = status
        return int(self.status[0])


def keep(work: Callable[[], None], folder: Path, status: np.ndarray, ends: tuple[End, End], orders: int,
         program: int) -> None:
    """What the guard does: fork the worker, watch it, and end everything. Does not return."""
    os.setsid()  # what a terminal sends to the program's group does not come here
    prctl(SUBREAPER, 1)
    gone, alive = os.pipe()
    guard = os.getpid()
    worker = os.fork()
    if worker == 0:
        os.close(orders)
        os.close(gone)
        ends[0].close()
        prctl(PARENT_DEATH, signal.SIGKILL)
        if os.getppid() == guard:
            work()
        os._exit(0)
    for number in ASKING:
        signal.signal(number, signal.SIG_IGN)
    os.close(alive)
    for end in ends:
        end.close()
    ended = 0
    while not ended and os.getppid() == program:
        ready, _, _ = select.select([orders, gone], [], [], LOOK_S)
        if orders in ready:
            if not os.read(orders, 1):
                break
            os.kill(worker, signal.SIGTERM)
        elif ready:
            time.sleep(0.001)  # its files are closed; its end follows
        ended, found = os.waitpid(worker, os.WNOHANG)
    end_all()
    if not ended:
        _, found = os.waitpid(worker, 0)
    empty(folder)
    status[0] = found
    os._exit(0)
