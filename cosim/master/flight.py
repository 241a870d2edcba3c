"""Flies a system from start to stop and keeps what it showed."""
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import RunError, UsageError
from .algorithms import Method, method
from .algorithms.base import Experiment
from .fmu import Instance
from .loaded import Master, Signal, open_files
from .pace import Pace
from .recording import CHUNK_ROWS, Recorder, Stream
from .system import System

CHUNK_S = 0.1  # wall time between two looks at the world
Progress = Callable[[float], None]
MakeRecorder = Callable[[list[Signal]], Recorder]


@dataclass
class Flight:
    """What a run left: one row of `signals` per recorded tick that was completed, the first at the start time."""
    time: np.ndarray                 # (rows,), s
    signals: np.ndarray              # (rows, columns)
    columns: list[Signal]
    finished: bool
    message: str                     # why it ended early; empty if it did not
    startup_s: float                 # loading and initialising
    wall_s: float                    # ticking
    parameters: dict[str, dict[str, Any]]
    fmus: dict[str, dict[str, str]]
    ticks: int = 0                   # steps that were taken
    lateness: dict[str, float] | None = None   # of a paced run

    def __getitem__(self, name: str) -> np.ndarray:
        """The column called `component.variable`, shape (rows,)."""
        return self.signals[:, [c.name for c in self.columns].index(name)]

    def has(self, name: str) -> bool:
        return any(c.name == name for c in self.columns)


Begun = Callable[[Flight, dict[tuple[int, int], tuple[str, str, int]]], None]


def tick_count(step: float, stop: float) -> int:
    """Whole number of communication steps to `stop`; UsageError if it is none, or not sensible."""
    if not (0 < step < float("inf") and 0 < stop < float("inf")):
        raise UsageError(f"--step {step:g} and --stop {stop:g} must be positive numbers of seconds.")
    count = round(stop / step)
    if count < 1 or abs(count * step - stop) > 1e-6 * step:
        raise UsageError(f"--stop {stop:g} s is not a whole number of communication steps of {step:g} s.")
    return count


def fly(system: System, step: float, stop: float, algorithm: str | Method = "gauss-seidel",
        progress: Progress | None = None, *, record: list[str] | None = None, decimate: int = 1,
        plain: bool = False, real_time: float | None = None, stream: Path | None = None,
        recorder: MakeRecorder | None = None, begun: Begun | None = None) -> Flight:
    """Fly `system` from 0 to `stop` (s) in communication steps of `step` (s).

    `algorithm` is a word as in `algorithms.method`. `record` picks the variables to keep, by component.variable with *
    for any (None: all numeric outputs), `decimate` every how many ticks; `stream` is a Parquet file to
    write them to as they come, and then memory keeps a part only. `plain` takes the tick loop in Python. `real_time`
    paces the run, times that factor. `recorder` makes another place for the rows, and `begun` is told before the first
    tick what is known by then, with the FMU calls of the programs.

    An FMU that refuses a step ends the run early: what was flown is in the result, `finished` is false
    and `message` names the FMU, the call, the time and its reason. So does Ctrl-C.

    Raises UsageError before anything flies if the system or the numbers do not fit; RunError if the
    FMUs cannot be started.
    """
    chosen = algorithm if isinstance(algorithm, Method) else method(algorithm)
    ticks = tick_count(step, stop)
    began = time.perf_counter()
    with open_files(system) as files:
        master = Master(system, files, record, plain, decimate > 1)
        try:
            return fly_loaded(master, chosen, step, ticks, progress, decimate, real_time,
                              recorder(master.columns) if recorder else make_recorder(master.columns, stream),
                              begun, began)
        finally:
            master.close()


def make_recorder(columns: list[Signal], stream: Path | None) -> Recorder:
    return Recorder(columns) if stream is None else Stream(columns, stream)


def fly_loaded(master: Master, chosen: Method, step: float, ticks: int, progress: Progress | None = None,
               decimate: int = 1, real_time: float | None = None, recorder: Recorder | None = None,
               begun: Begun | None = None, began: float | None = None) -> Flight:
    """The same with FMUs that are loaded, or were reset (`Master.reset`)."""
    began = time.perf_counter() if began is None else began
    recorder = recorder or Recorder(master.columns)
    plan = Experiment(0.0, step, ticks, recorder, decimate)
    try:
        if real_time is not None and not 0 < real_time < float("inf"):
            raise UsageError(f"--real-time {real_time:g} must be a positive number.")
        flier = chosen.algorithm(master, chosen.options, plan)
        master.initialise(0.0, plan.stop)
        flight = Flight(time=np.empty(0), signals=np.empty((0, len(master.columns))), columns=master.columns,
                        finished=False, message="", startup_s=0.0, wall_s=0.0,
                        parameters={i.name: inquire(i) for i in master.instances}, fmus=origins(master))
        flight.startup_s = time.perf_counter() - began
        if begun:
            begun(flight, master.calls())
        recorder.add(0.0, master.row())
    except BaseException:
        recorder.abandon()
        raise
    pace = Pace(real_time, step) if real_time else None
    began = time.perf_counter()
    flight.message = ascend(flier, plan, progress, pace)
    flight.wall_s = time.perf_counter() - began
    flight.time, flight.signals = recorder.finish()
    flight.finished, flight.ticks = not flight.message, flier.ticks
    flight.lateness = pace.report() if pace else None
    return flight


def ascend(flier: Any, plan: Experiment, progress: Progress | None, pace: Pace | None) -> str:
    """Advance to the stop in chunks of about CHUNK_S; why it ended early, or an empty text."""
    most, limit = 16, CHUNK_ROWS * plan.decimate
    with interruptions() as interrupted:
        try:
            while not flier.done:
                if interrupted:
                    return f"Interrupted at t = {flier.time:.6g} s."
                if pace:
                    pace.wait(flier.time, interrupted)
                chunk = time.perf_counter()
                flier.advance(1 if pace else most)
                took = time.perf_counter() - chunk
                most = max(1, min(int(most * min(4.0, CHUNK_S / max(took, 1e-9))), limit))
                if progress:
                    progress(flier.time)
        except RunError as error:
            return str(error)
    return ""


@contextmanager
def interruptions() -> Iterator[list[int]]:
    """Ctrl-C and SIGTERM as entries of a list, so that no FMU is torn out of a call; a Python FMU would take the
    exception for its own failure."""
    caught: list[int] = []
    if threading.current_thread() is not threading.main_thread():
        yield caught
        return
    previous = {s: signal.signal(s, lambda number, _: caught.append(number)) for s in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield caught
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)


def inquire(instance: Instance) -> dict[str, Any]:
    """All parameters of a component with the values it flies with."""
    file = instance.file
    names = [n for causality in ("parameter", "calculatedParameter") for n in file.names(causality)
             if file.variables[n].type != "String"]
    return dict(zip(names, instance.get(names)))


def origins(master: Master) -> dict[str, dict[str, str]]:
    """Which FMU files flew."""
    return {c.name: {"file": str(c.fmu), "model": file.description.modelName or "", "guid": file.description.guid or "",
                     "sha256": file.sha256, "generation_tool": file.description.generationTool or ""}
            for c in master.system.components for file in [master.files[c.name]]}


def progress_bar(title: str, stop: float) -> tuple[Any, Progress | None]:
    """A context manager and a progress function: a bar on stderr, or nothing if that is no terminal."""
    from contextlib import nullcontext

    if not sys.stderr.isatty():
        return nullcontext(), None
    from rich.console import Console
    from rich.progress import Progress as Bar

    bar = Bar(console=Console(stderr=True), transient=True)
    task = bar.add_task(title, total=stop)
    return bar, lambda t: bar.update(task, completed=t)
