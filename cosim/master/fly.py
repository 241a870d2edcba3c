"""Flies a system from start to stop and keeps what it showed."""
import time
from collections.abc import Callable
from math import inf, isfinite
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import RunError, UsageError
from .algorithms import Method, method
from .algorithms.base import Algorithm, Experiment
from .desk import Desk
from .flight import Flight
from .instance import Instance
from .interruptions import interruptions
from .loaded import Ended, Master, open_files
from .memory import free_memory
from .pace import Pace
from .progress import Progress
from .recording import CHUNK_ROWS, Recorder, Stream
from .state import State, keep_state, need_even, need_serialised
from .system import System
from .table import Table
from .wiring import Signal

MOST_TICKS = 1e12  # 11 days at a microsecond each
CHUNK_S = 0.1  # wall time between two looks at the world
COPIES = 3  # of all rows in memory at a time, at most: when they are put together and written
MakeRecorder = Callable[[list[Signal]], Recorder]
Begun = Callable[[Flight, dict[tuple[int, int], tuple[str, str, int]]], None]
Flown = Callable[[Flight], None]


def tick_count(step: float, stop: float, start: float = 0.0) -> int:
    """Whole number of communication steps from `start` to `stop`; UsageError if it is none, or not sensible."""
    if not isfinite(start):
        raise UsageError(f"--start {start:g} must be a finite number of seconds.")
    if start == 0 and not (0 < step < inf and 0 < stop < inf):
        raise UsageError(f"--step {step:g} and --stop {stop:g} must be positive numbers of seconds.")
    if not 0 < step < inf:
        raise UsageError(f"--step {step:g} must be a positive number of seconds.")
    if not start < stop < inf:
        raise UsageError(f"--stop {stop:g} s must be after the start at {start:g} s.")
    if not (stop - start) / step <= MOST_TICKS:
        raise UsageError(f"--stop {stop:g} s is more than {MOST_TICKS:g} communication steps of {step:g} s.")
    count = round((stop - start) / step)
    if count < 1 or abs(count * step - (stop - start)) > 1e-6 * step:
        since = f" from the start at {start:g} s" if start else ""
        raise UsageError(f"--stop {stop:g} s is not a whole number of communication steps of {step:g} s{since}.")
    return count


def row_count(step: float, stop: float, decimate: int, start: float = 0.0) -> int:
    """Rows of a flight that takes all steps. Raises what `tick_count` raises."""
    return tick_count(step, stop, start) // decimate + 2


def fly(system: System, step: float, stop: float, algorithm: str | Method = "gauss-seidel",
        progress: Progress | None = None, *, start: float | None = None, tolerance: float | None = None,
        record: list[str] | None = None, decimate: int = 1, plain: bool = False,
        real_time: float | None = None, stream: Path | None = None, recorder: MakeRecorder | None = None,
        begun: Begun | None = None, flown: Flown | None = None, inputs: Table | None = None,
        save: Path | None = None, restore: State | None = None, desk: Desk | None = None) -> Flight:
    """Fly `system` from `start` (None: the system's) to `stop` (s) in communication steps of `step` (s).

    `algorithm` is a word as in `algorithms.method`. `tolerance` is the relative one that FMUs are asked to keep (None:
    what each declares in its default experiment). `record` picks the variables to keep, by component.variable with *
    for any (None: all numeric outputs), `decimate` every how many ticks; `stream` is a file to write them to as they
    come, see `recording.Stream`, and then memory keeps a part only. `plain` takes the tick loop in Python. `real_time`
    paces the run, times that factor. `recorder` makes another place for the rows, and `begun` is told before the first
    tick what is known by then, with the FMU calls of the programs; `flown` is told the flight before its FMUs
    are ended. `inputs` has inputs over time. `save` is a file for the whole state at the end, `restore` the state of
    such a file to go on from: to the last bit as the flight that it was saved of would have gone on. `desk` steps
    inputs while the flight flies; they are recorded as well.

    An FMU that refuses a step ends the run early: what was flown is in the result, `finished` is false
    and `message` names the FMU, the call, the time and its reason. So does Ctrl-C. An FMU may also end the simulation
    (fmi2Discard with fmi2Terminated): then `finished` is true, and `ended_at` and `message` tell when and why.

    Raises UsageError before anything flies if the system or the numbers do not fit; RunError if the
    FMUs cannot be started.
    """
    chosen = algorithm if isinstance(algorithm, Method) else method(algorithm)
    start = restore.start if restore else system.start if start is None else start
    ticks = tick_count(step, stop, start)
    if save or restore:
        need_even(chosen)
    if restore:
        restore.check(step, chosen.word, ticks)
    if tolerance is not None and not 0 < tolerance < inf:
        raise UsageError(f"--tolerance {tolerance:g} must be a positive number.")
    began = time.perf_counter()
    with open_files(system) as files:
        master = Master(system, files, record, plain, decimate > 1, tolerance, inputs, desk.inputs if desk else ())
        try:
            if desk:
                desk.connect(master)
            if save or restore:
                need_serialised(master)
            flight = fly_loaded(master, chosen, step, ticks, progress, decimate, real_time,
                                recorder(master.columns) if recorder else make_recorder(
                                    master.columns, stream, row_count(step, stop, decimate, start)),
                                begun, began, start, restore, bool(save or restore), desk)
            if save and flight.ended_at is None and (flight.finished or flight.interrupted):
                keep_state(save, master, flight, start, step, chosen.word, restore.tick if restore else 0)
            if flown:
                flown(flight)
            return flight
        finally:
            master.close()


def make_recorder(columns: list[Signal], stream: Path | None, rows: int) -> Recorder:
    """Rows into memory, or into the file `stream`. Raises UsageError if so many would not fit in memory."""
    if stream is not None:
        return Stream(columns, stream)
    need, free = COPIES * 8 * rows * (len(columns) + 1), free_memory()
    if need > free:
        raise UsageError(f"--step and --stop give {rows - 1:.3g} rows of {len(columns)} signals. They need "
                         f"{need / 1e9:.3g} GB of memory, and {free / 1e9:.3g} GB are free. Use --stream.")
    return Recorder(columns)


def fly_loaded(master: Master, chosen: Method, step: float, ticks: int, progress: Progress | None = None,
               decimate: int = 1, real_time: float | None = None, recorder: Recorder | None = None,
               begun: Begun | None = None, began: float | None = None, start: float = 0.0,
               restore: State | None = None, goes_on: bool = False, desk: Desk | None = None) -> Flight:
    """The same with FMUs that are loaded, or were reset (`Master.reset`), from `start` (s) on; with a state from where
    that was saved, where `start` and `ticks` are those of the whole flight. If it `goes_on`, FMUs are told no stop."""
    began = time.perf_counter() if began is None else began
    recorder = recorder or Recorder(master.columns)
    experiment = Experiment(start, step, ticks, recorder, decimate, restore.tick if restore else 0)
    try:
        if real_time is not None and not 0 < real_time < float("inf"):
            raise UsageError(f"--real-time {real_time:g} must be a positive number.")
        running = chosen.algorithm(master, chosen.options, experiment)
        master.initialise(start, None if goes_on else experiment.stop)
        if restore:
            restore.into(master)
        flight = Flight(time=np.empty(0), signals=np.empty((0, len(master.columns))), columns=master.columns,
                        finished=False, message="", startup_s=0.0, wall_s=0.0,
                        parameters={i.name: inquire(i) for i in master.instances}, fmus=origins(master),
                        periods=chosen.periods(step))
        flight.startup_s = time.perf_counter() - began
        recorder.about(known_of(flight))
        if begun:
            begun(flight, master.calls())
        recorder.add(running.time, master.row_at(running.time, step))
    except BaseException:
        recorder.abandon()
        raise
    pace = Pace(real_time, step) if real_time else None
    began = time.perf_counter()
    with interruptions() as interrupted:
        flight.message, flight.ended_at = advance(running, experiment, progress, pace, interrupted, desk)
        flight.wall_s = time.perf_counter() - began
        flight.finished = not flight.message or flight.ended_at is not None
        flight.ticks = running.ticks - experiment.first
        flight.reached = running.time if flight.ended_at is None else flight.ended_at
        take_rows(flight, recorder)
    flight.interrupted = interrupted[0] if interrupted else 0
    flight.lateness = pace.report() if pace else None
    return flight


def known_of(flight: Flight) -> dict[str, Any]:
    """What is known of a flight before its first row, as JSON goes."""
    return {"fmus": flight.fmus, "parameters": flight.parameters, "periods": flight.periods,
            "startup_s": flight.startup_s}


def take_rows(flight: Flight, recorder: Recorder) -> None:
    """End the recording. A flight whose rows did not all find room is not finished."""
    flight.time, flight.signals = recorder.finish()
    if recorder.trouble:
        flight.fail(recorder.trouble)


def advance(algorithm: Algorithm, experiment: Experiment, progress: Progress | None, pace: Pace | None,
            interrupted: list[int], desk: Desk | None = None) -> tuple[str, float | None]:
    """Advance to the stop in chunks of about CHUNK_S, until there is something in `interrupted`; why it ended early, or
    an empty text, and the time (s) at which an FMU ended the simulation if one did."""
    most, limit = 16, CHUNK_ROWS * experiment.decimate
    try:
        while not algorithm.done:
            if interrupted:
                return f"Interrupted at t = {algorithm.time:.6g} s.", None
            if pace:
                pace.wait(algorithm.time, interrupted)
            if desk:
                desk.tick(algorithm.time, pace.late[-1] if pace else 0.0)
            chunk = time.perf_counter()
            algorithm.advance(1 if pace else most)
            took = time.perf_counter() - chunk
            most = max(1, min(int(most * min(4.0, CHUNK_S / max(took, 1e-9))), limit))
            if progress:
                progress(algorithm.time)
    except Ended as end:
        return str(end), end.time
    except RunError as error:
        return str(error), None
    return "", None


def inquire(instance: Instance) -> dict[str, Any]:
    """All parameters of a component with the values it flies with."""
    names = instance.file.parameters
    return dict(zip(names, instance.get(names)))


def origins(master: Master) -> dict[str, dict[str, str]]:
    """Which FMU files flew."""
    found = {}
    for component in master.system.components:
        file = master.files[component.name]
        said = file.description.attributes
        found[component.name] = {"file": str(component.fmu), "model": said.get("modelName", ""),
                                 "guid": said.get("guid", said.get("instantiationToken", "")), "sha256": file.sha256,
                                 "generation_tool": said.get("generationTool", "")}
    return found
