"""The FMU call that is under way and the last log message in shared memory: a parent process reads them after a crash.

`Place` is memory that a process and its fork share; `place` is the one in use. Without isolation there is none, and
nothing is kept.
"""
import mmap

import numpy as np

from . import program

LINE = 1024
CURSOR, STAGE, SPAN, STATUS, NOTE, LOGGED, ROWS = 0, 128, 256, 384, 512, 512 + LINE, 4096
OUTSIDE, CALLING, TICKING = range(3)  # of FMU calls; in the one that NOTE names; in those of the tick loop
ROOM = 1 << 26  # for rows that are not handed over yet; untouched memory costs nothing


class Place:
    """Shared memory: the loop's cursor and times, two lines of text, and rows that are not handed over yet."""
    def __init__(self) -> None:
        self.memory = mmap.mmap(-1, ROWS + ROOM)
        self.cursor = np.frombuffer(self.memory, np.int64, 7, CURSOR)   # see `program`
        self.cursor[:] = program.cursor()
        self.stage = np.frombuffer(self.memory, np.int64, 1, STAGE)
        self.span = np.frombuffer(self.memory, np.float64, 2, SPAN)     # start and step of the ticks
        self.status = np.frombuffer(self.memory, np.int64, 1, STATUS)   # how the process ended, see `guard`
        self.doubles = np.frombuffer(self.memory, np.float64, ROOM // 8, ROWS)

    def write(self, where: int, text: str) -> None:
        """Write a line at the offset `where` (NOTE or LOGGED)."""
        line = text.encode("utf-8", "replace")[:LINE - 1]
        self.memory[where:where + len(line) + 1] = line + b"\0"

    def read(self, where: int) -> str:
        """The line at the offset `where`."""
        return bytes(self.memory[where:where + LINE]).partition(b"\0")[0].decode("utf-8", "replace")


place: Place | None = None


def begin(call: str = "") -> None:
    """An FMU call begins: `call`, or if that is empty those of the tick loop."""
    if place is not None:
        if call:
            place.write(NOTE, call)
        place.cursor[program.CALLS] += 1
        place.stage[0] = CALLING if call else TICKING


def end() -> None:
    """The call has come back."""
    if place is not None:
        place.stage[0] = OUTSIDE


def logged(text: str) -> None:
    """Keep a message of an FMU's log."""
    if place is not None:
        place.write(LOGGED, text)
