"""A flight in a process of its own: an FMU that crashes or hangs ends the flight, not the program.

The process is a fork, which sends recorded rows as they come. The FMU call that is under way is in shared memory, so
that the message can name it; so are rows that were not sent yet.
"""
import os
import signal
import tempfile
import time
from collections.abc import Callable
from multiprocessing import Pipe
from multiprocessing.connection import Connection as End
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import RunError, UsageError
from . import last_call
from . import program as P
from .flight import Flight, fly, interruptions, make_recorder
from .progress import Progress
from .recording import CHUNK_ROWS, Recorder
from .system import System
from .wiring import Signal

LOOK_S = 0.05


class Sender(Recorder):
    """A recorder that sends rows to the parent; its buffer is in shared memory where it fits."""

    def __init__(self, columns: list[Signal], end: End, place: last_call.Place):
        super().__init__(columns)
        self.end = end
        if (len(columns) + 1) * (CHUNK_ROWS + 1) <= len(place.doubles):
            self.times = place.doubles[:CHUNK_ROWS + 1]
            self.rows = place.doubles[CHUNK_ROWS + 1:][:(CHUNK_ROWS + 1) * len(columns)].reshape(
                CHUNK_ROWS + 1, len(columns))  # columns may be none, so -1 cannot be found out

    def keep(self, times: np.ndarray, rows: np.ndarray) -> None:
        self.end.send(("rows", times, rows))

    def took(self, used: int) -> None:
        super().took(used)
        self.master_cursor()[P.ROWS] = 0  # handed over: not to be looked for in shared memory

    @staticmethod
    def master_cursor() -> np.ndarray:
        """The loop's cursor, see `program`."""
        assert last_call.place is not None
        return last_call.place.cursor

    def finish(self) -> tuple[np.ndarray, np.ndarray]:
        return np.empty(0), np.empty((0, len(self.columns)))


def fly_isolated(system: System, step: float, stop: float, algorithm: str, progress: Progress | None = None,
                 time_limit: float | None = None, stream: Path | None = None, **options: Any) -> Flight:
    """`flight.fly` in a process of its own. An FMU call that takes longer than `time_limit` (s) ends the flight.

    Raises what `fly` raises; RunError also for a crash or a hang before the first tick.
    """
    if time_limit is not None and not time_limit > 0:
        raise UsageError(f"--time-limit {time_limit:g} must be a positive number of seconds.")
    place = last_call.Place()
    with tempfile.TemporaryDirectory(prefix="ahv_") as folder:  # what a crash leaves behind goes with it
        ours, theirs = Pipe()
        child = os.fork()
        if child == 0:
            run_child(theirs, place, folder, lambda begun: fly(
                system, step, stop, algorithm, (lambda t: theirs.send(("progress", t))) if progress else None,
                recorder=lambda columns: Sender(columns, theirs, place), begun=begun,
                flown=lambda flight: theirs.send(("flown", flight)), **options))
        theirs.close()
        return Parent(child, ours, place, stream, progress, time_limit).wait()


def run_child(end: End, place: last_call.Place, folder: str, flight: Callable[[Any], Flight]) -> None:
    """What the child does: fly, send the result or the error, and exit. Does not return."""
    try:
        last_call.place, tempfile.tempdir = place, folder
        result = flight(lambda head, calls: end.send(("head", head, calls)))
        end.send(("end", result))
    except BaseException as error:
        known = isinstance(error, UsageError | RunError)
        end.send(("error", error if known else RunError(f"The flight failed: {error!r}")))
    finally:
        os._exit(0)


class Parent:
    """The process that waits: it collects rows and progress, and ends the child when an FMU call takes too long."""
    def __init__(self, child: int, end: End, place: last_call.Place, stream: Path | None, progress: Progress | None,
                 limit: float | None):
        self.child, self.end, self.place, self.stream, self.progress = child, end, place, stream, progress
        self.limit = limit
        self.recorder: Recorder | None = None
        self.head: Flight | None = None   # what is known before the first tick; all that is, once it has flown
        self.flown = False
        self.calls: dict[tuple[int, int], tuple[str, str, int]] = {}
        self.begun = time.perf_counter()

    def wait(self) -> Flight:
        """The flight, once the child has ended. Raises the child's error, and RunError if it ended before a tick.

        Only the time within one FMU call counts for the limit.
        """
        seen, since = self.position(), time.monotonic()
        with interruptions() as interrupted:
            while True:
                try:
                    if self.end.poll(LOOK_S):
                        result = self.take(self.end.recv())
                        if result is not None:
                            os.waitpid(self.child, 0)
                            return result
                        seen, since = self.position(), time.monotonic()
                        continue
                except EOFError:
                    _, status = os.waitpid(self.child, 0)
                    return self.broken(f"{cause_of_death(status)} in")
                now = self.position()
                if now != seen or self.place.stage[0] == last_call.OUTSIDE:
                    seen, since = now, time.monotonic()
                elif self.limit is not None and time.monotonic() - since > self.limit:
                    self.kill()
                    return self.broken(f"did not come back within {self.limit:g} s from")
                if len(interrupted) > 1:
                    self.kill()
                    return self.broken("was interrupted in")

    def kill(self) -> None:
        """End the child."""
        os.kill(self.child, signal.SIGKILL)
        os.waitpid(self.child, 0)

    def position(self) -> int:
        """What changes with every FMU call of the child."""
        return int(self.place.cursor[P.CALLS])

    def take(self, item: tuple[Any, ...]) -> Flight | None:
        """Handle a message of the child; the flight if it is the last one. Raises the child's error."""
        kind, *rest = item
        if kind == "progress" and self.progress:
            self.progress(*rest)
        elif kind == "head":
            self.head, self.calls = rest
            self.recorder = make_recorder(self.head.columns, self.stream)
        elif kind == "rows":
            assert self.recorder is not None
            self.recorder.keep(*rest)
        elif kind == "flown":
            self.head, self.flown = rest[0], True
        elif kind == "error":
            os.waitpid(self.child, 0)
            raise rest[0]
        elif kind == "end":
            assert self.recorder is not None
            flight: Flight = rest[0]
            flight.time, flight.signals = self.recorder.finish()
            return flight
        return None

    def broken(self, how: str) -> Flight:
        """The flight as far as it came, of a process that is gone; `how` is the verb of the message.

        Raises RunError if the process ended before the first tick.
        """
        message = self.place.read(last_call.LOGGED)
        sentence = f"{self.told(how)}{f'; it had said: {message}' if message else ''}"
        if self.head is None or self.recorder is None:
            raise RunError(sentence)
        tick, _, used, _, _, _, steps = self.place.cursor.tolist()
        columns = self.head.columns
        if used and (len(columns) + 1) * (CHUNK_ROWS + 1) <= len(self.place.doubles):
            rows = self.place.doubles[CHUNK_ROWS + 1:][:used * len(columns)].reshape(used, len(columns))
            self.recorder.keep(self.place.doubles[:used].copy(), rows.copy())
        flight = self.head
        flight.time, flight.signals = self.recorder.finish()
        if self.flown:  # what follows is the end of its FMUs
            sentence = f"{flight.message.rstrip('.')}; then {sentence}" if flight.message else sentence
        else:
            start, step = self.place.span.tolist()
            flight.ticks, flight.wall_s = tick if steps < 0 else steps, time.perf_counter() - self.begun
            flight.reached = start + tick * step
        flight.finished, flight.message = False, sentence
        return flight

    def told(self, how: str) -> str:
        """Who did `how` in which call, and when if it was a tick's."""
        stage, (tick, _, _, code, index, _, _) = self.place.stage[0], self.place.cursor.tolist()
        if stage == last_call.OUTSIDE:
            return f"The process of the flight {how.rpartition(' ')[0]} outside of all FMU calls"
        if stage == last_call.CALLING:
            who, _, call = self.place.read(last_call.NOTE).partition(": ")
            return f"{who} {how} {call}"
        if (code, index) not in self.calls:
            return f"An FMU {how} the exchange of initial values"
        (who, call, late), (start, step) = self.calls[code, index], self.place.span.tolist()
        return f"{who} {how} {call} at t = {start + (tick + late) * step:.6g} s"


def cause_of_death(status: int) -> str:
    """What a process did that ended with `status`, as os.waitpid tells it."""
    if not os.WIFSIGNALED(status):
        return f"ended its process (exit status {os.WEXITSTATUS(status)})"
    number = os.WTERMSIG(status)
    known = number in signal.valid_signals() and number in set(signal.Signals)
    return f"crashed ({signal.Signals(number).name if known else f'signal {number}'})"


def launch(system: System, step: float, stop: float, algorithm: str = "gauss-seidel", progress: Progress | None = None,
           isolate: bool = False, time_limit: float | None = None, **options: Any) -> Flight:
    """`flight.fly`, in a process of its own if `isolate` or with a `time_limit` (s). Raises what those raise."""
    if isolate or time_limit is not None:
        return fly_isolated(system, step, stop, algorithm, progress, time_limit, **options)
    return fly(system, step, stop, algorithm, progress, **options)
