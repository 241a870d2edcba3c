"""A control desk: what a running flight shares with whoever watches it, and steps its inputs, from outside.

A desk lists connected Real inputs. An offset that is asked for is added to the input's connected value from the next
tick on, in the input's unit. The memory is shared with forks, so the asker may be another process or a thread; the
flight looks at it between two ticks and never waits.
"""
import mmap
from collections.abc import Sequence
from typing import Protocol

import numpy as np

from ..errors import UsageError
from . import program as P
from .flight import Flight
from .loaded import Master

MOST = 10_000  # steps of one flight


class Watch(Protocol):
    """Who is told of a flight in a process of its own while it flies."""

    def begun(self, flight: Flight) -> None:
        """What is known before the first tick."""

    def rows(self, times: np.ndarray, rows: np.ndarray) -> None:
        """Recorded rows, shape (rows, columns), and their times (s), as they come."""


class Desk:
    """Offsets of `inputs` (component.variable) that are asked for, those that act, and how late the flight is."""

    def __init__(self, inputs: Sequence[str]):
        self.inputs = tuple(inputs)
        count = len(self.inputs)
        self.memory = mmap.mmap(-1, 8 * (count + 3 + 3 * MOST))
        self.wanted = np.frombuffer(self.memory, float, count)
        self.late = np.frombuffer(self.memory, float, 2, 8 * count)             # of the last tick and the worst, s
        self.count = np.frombuffer(self.memory, np.int64, 1, 8 * (count + 2))   # steps made
        self.log = np.frombuffer(self.memory, float, 3 * MOST, 8 * (count + 3)).reshape(MOST, 3)
        self.acting = self.asked()
        self.links: list[int] = []
        self.base: list[float] = []
        self.offset = np.empty(0)  # of all links of the flight, see `wiring`

    def asked(self) -> bytes:
        """The wanted offsets as they are in memory."""
        return self.memory[:8 * len(self.inputs)]

    def ask(self, name: str, offset: float) -> None:
        """Have `offset` added to the input `name` from the next tick on. Raises UsageError for an input that the desk
        does not have, an offset that is not finite, and after MOST steps."""
        if name not in self.inputs:
            raise UsageError(f"{name} is no input that can be stepped; there are {', '.join(self.inputs) or 'none'}.")
        if not np.isfinite(offset):
            raise UsageError(f"{name}: the offset {offset:g} must be a finite number.")
        if self.count[0] >= MOST:
            raise UsageError(f"{name}: a flight takes at most {MOST} steps, and they are made.")
        self.wanted[self.inputs.index(name)] = offset

    def made(self) -> list[dict[str, float | str]]:
        """The steps so far: the time (s) from which each acts, its input, and the offset from then on as `value`."""
        return [{"time": time, "input": self.inputs[int(place)], "value": value}
                for time, place, value in self.log[:int(self.count[0])].tolist()]

    def connect(self, master: Master) -> None:
        """Find the inputs among the links of a loaded system. Raises UsageError for one that no connection ends at, or
        that is not Real."""
        wiring = master.wiring
        places = {f"{master.instances[group.owner].name}.{name}": int(wiring.groups[group.number, P.FIRST]) + i
                  for groups in wiring.inputs for group in groups if group.real for i, name in enumerate(group.names)}
        for name in self.inputs:
            if name not in master.targets or name not in places:
                raise UsageError(f"{name} cannot be stepped: it is no Real input that a connection ends at.")
        self.links = [places[name] for name in self.inputs]
        self.offset, self.base = wiring.offset, wiring.offset[self.links].tolist()

    def tick(self, time: float, late: float) -> None:
        """Before the tick that begins at `time` (s), `late` (s) by the wall clock: what is asked for acts from now."""
        self.late[:] = late, max(late, float(self.late[1]))
        asked = self.asked()
        if asked == self.acting:
            return
        before, self.acting = np.frombuffer(self.acting), asked
        for i, (value, old) in enumerate(zip(np.frombuffer(asked).tolist(), before.tolist())):
            if value != old and self.count[0] < MOST:
                self.offset[self.links[i]] = self.base[i] + value
                self.log[self.count[0]] = time, i, value
                self.count[0] += 1
