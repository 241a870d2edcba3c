"""A flight in a process of its own: an FMU that crashes or hangs ends the flight, not the program.

The process is a fork (see `guard`), which sends recorded rows as they come. The FMU call that is under way is in shared
memory, so that the message can name it; so are rows that were not sent yet.
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

from ..errors import Interrupted, RunError, UsageError
from ..temporary import Folder
from . import last_call
from . import program as P
from .desk import Watch
from .flight import Flight
from .fly import MakeRecorder, fly, known_of, make_recorder, row_count, take_rows
from .guard import LOOK_S, Guarded
from .interruptions import interruptions
from .progress import Progress
from .recording import CHUNK_ROWS, NoRoom, Recorder
from .system import System
from .wiring import Signal

GRACE_S = 0.3  # for a flight that was asked to end


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
                 time_limit: float | None = None, stream: Path | None = None,
                 meanwhile: Callable[[], None] | None = None, watch: Watch | None = None, **options: Any) -> Flight:
    """`fly.fly` in a process of its own. An FMU call that takes longer than `time_limit` (s) ends the flight; a
    signal ends it within GRACE_S, in whatever call it is. `meanwhile` is called here once the process has begun;
    `watch` is told here what comes from it.

    Raises what `fly` raises; RunError also for a crash or a hang before the first tick, Interrupted for a signal then.
    """
    if time_limit is not None and not time_limit > 0:
        raise UsageError(f"--time-limit {time_limit:g} must be a positive number of seconds.")
    start = options.get("start")
    rows = row_count(step, stop, options.get("decimate", 1), system.start if start is None else start)
    place = last_call.Place()
    with Folder() as folder, interruptions() as interrupted:  # what a crash leaves behind goes with the folder
        ours, theirs = Pipe(duplex=False)
        guarded = Guarded(lambda: run_child(theirs, place, folder.path, lambda begun: fly(
            system, step, stop, algorithm, (lambda t: theirs.send(("progress", t))) if progress else None,
            recorder=lambda columns: Sender(columns, theirs, place), begun=begun,
            flown=lambda flight: theirs.send(("flown", flight)), **options)), folder.path, place.status, (ours, theirs))
        theirs.close()
        try:
            if meanwhile:
                meanwhile()
            return Parent(guarded, ours, place, lambda columns: make_recorder(columns, stream, rows), progress,
                          time_limit, interrupted, watch).wait()
        finally:
            guarded.end()
            ours.close()


def run_child(end: End, place: last_call.Place, folder: Path, flight: Callable[[Any], Flight]) -> None:
    """What the child does: fly, send the result or the error, and exit. Does not return."""
    try:
        last_call.place, tempfile.tempdir = place, str(folder)
        result = flight(lambda head, calls: end.send(("head", head, calls)))
        end.send(("end", result))
    except BaseException as error:
        known = isinstance(error, UsageError | RunError)
        end.send(("error", error if known else RunError(f"The flight failed: {error!r}")))
    finally:
        os._exit(0)


class Parent:
    """The process that waits: it collects rows and progress, and ends the child when an FMU call takes too long."""
    def __init__(self, guarded: Guarded, end: End, place: last_call.Place, make: MakeRecorder,
                 progress: Progress | None, limit: float | None, interrupted: list[int],
                 watch: Watch | None = None):
        self.guarded, self.end, self.place, self.make, self.progress = guarded, end, place, make, progress
        self.limit, self.interrupted, self.watch = limit, interrupted, watch
        self.recorder: Recorder | None = None
        self.head: Flight | None = None   # what is known before the first tick; all that is, once it has flown
        self.flown = False
        self.until = -np.inf              # time of the last row that came, s
        self.calls: dict[tuple[int, int], tuple[str, str, int]] = {}
        self.begun = time.perf_counter()

    def wait(self) -> Flight:
        """The flight, once the child has ended. Raises the child's error, and RunError if it ended before a tick.

        Only the time within one FMU call counts for the limit.
        """
        seen, since = self.position(), time.monotonic()
        asked, how = None, ""
        while True:
            if self.interrupted and asked is None:
                self.guarded.ask()
                asked = time.monotonic()
            if asked is not None and not how and time.monotonic() - asked > GRACE_S:
                how = "was interrupted in"
                self.guarded.end()
            try:
                item = self.end.recv() if self.end.poll(LOOK_S) else None
            except (EOFError, OSError):  # OSError: in the middle of a message
                return self.broken(how or f"{cause_of_death(self.guarded.end())} in")
            if item:
                try:
                    result = self.take(item)
                except NoRoom as error:
                    self.guarded.end()
                    return self.ended(str(error))
                if result is not None:
                    result.interrupted = self.signal
                    return result
            now = self.position()
            if item or now != seen or self.place.stage[0] == last_call.OUTSIDE:
                seen, since = now, time.monotonic()
            elif not how and self.limit is not None and time.monotonic() - since > self.limit:
                how = f"did not come back within {self.limit:g} s from"
                self.guarded.end()

    @property
    def signal(self) -> int:
        """The signal that asked for an end; 0 if none did."""
        return self.interrupted[0] if self.interrupted else 0

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
            self.recorder = self.make(self.head.columns)
            self.recorder.about(known_of(self.head))
            if self.watch:
                self.watch.begun(self.head)
        elif kind == "rows":
            assert self.recorder is not None
            self.recorder.keep(*rest)
            self.until = float(rest[0][-1])
            if self.watch:
                self.watch.rows(*rest)
        elif kind == "flown":
            self.head, self.flown = rest[0], True
        elif kind == "error":
            raise rest[0]
        elif kind == "end":
            assert self.recorder is not None
            flight: Flight = rest[0]
            take_rows(flight, self.recorder)
            return flight
        return None

    def broken(self, how: str) -> Flight:
        """The flight as far as it came, of a process that is gone; `how` is the verb of the message. See `ended`."""
        message = self.place.read(last_call.LOGGED)
        return self.ended(f"{self.told(how)}{f'; it had said: {message}' if message else ''}")

    def ended(self, sentence: str) -> Flight:
        """The flight as far as it came, of a process that is gone; `sentence` says why.

        Raises RunError with it if the process ended before the first tick, Interrupted if there was a signal.
        """
        if self.head is None or self.recorder is None:
            raise Interrupted(sentence, self.signal) if self.interrupted else RunError(sentence)
        tick, _, used, _, _, _, steps = self.place.cursor.tolist()
        columns = self.head.columns
        if used and (len(columns) + 1) * (CHUNK_ROWS + 1) <= len(self.place.doubles):
            rows = self.place.doubles[CHUNK_ROWS + 1:][:used * len(columns)].reshape(used, len(columns))
            times = self.place.doubles[:used]
            fresh = times > self.until  # the process may have ended after it sent them
            try:
                if fresh.any():
                    self.recorder.keep(times[fresh], rows[fresh])
            except NoRoom as error:
                sentence = f"{sentence.rstrip('.')}; {error}"
        flight = self.head
        if self.flown:  # what follows is the end of its FMUs
            sentence = f"{flight.message.rstrip('.')}; then {sentence}" if flight.message else sentence
        else:
            start, step = self.place.span.tolist()
            flight.ticks, flight.wall_s = tick if steps < 0 else steps, time.perf_counter() - self.begun
            flight.reached = start + tick * step
        flight.finished, flight.message, flight.interrupted = False, sentence, self.signal
        take_rows(flight, self.recorder)
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
    """`fly.fly`, in a process of its own if `isolate` or with a `time_limit` (s). Raises what those raise."""
    if isolate or time_limit is not None:
        return fly_isolated(system, step, stop, algorithm, progress, time_limit, **options)
    options.pop("meanwhile", None)
    return fly(system, step, stop, algorithm, progress, **options)
