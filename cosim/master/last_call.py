"""What is being called just now, where a parent process can read it after a crash or a hang.

`Place` is memory that a process and its fork share; `place` is the one in use. Without isolation there is none, and
notes are lost at once.
"""
import mmap

import numpy as np

LINE = 1024
CURSOR, SPAN, NOTE, SAID, ROWS = 0, 256, 512, 512 + LINE, 4096
ROOM = 1 << 26  # for rows that are not handed over yet; untouched memory costs nothing


class Place:
    def __init__(self) -> None:
        self.memory = mmap.mmap(-1, ROWS + ROOM)
        self.cursor = np.frombuffer(self.memory, np.int64, 5, CURSOR)   # see `loop_compiled.kernel`
        self.span = np.frombuffer(self.memory, np.float64, 2, SPAN)     # start and step of the ticks
        self.doubles = np.frombuffer(self.memory, np.float64, ROOM // 8, ROWS)

    def write(self, where: int, text: str) -> None:
        line = text.encode("utf-8", "replace")[:LINE - 1]
        self.memory[where:where + len(line) + 1] = line + b"\0"

    def read(self, where: int) -> str:
        return bytes(self.memory[where:where + LINE]).partition(b"\0")[0].decode("utf-8", "replace")


place: Place | None = None


def note(text: str) -> None:
    """About to be called, outside of ticks; an empty text says that ticks have begun."""
    if place is not None:
        place.write(NOTE, text)


def said(text: str) -> None:
    """A line of an FMU's log."""
    if place is not None:
        place.write(SAID, text)
