"""Flies a system from start to stop and keeps every tick."""
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from .errors import RunError, UsageError
from .master import ALGORITHMS, Master, Signal, open_files
from .system import System

CHUNK_S = 0.2  # wall time between two signs of life
Progress = Callable[[float], None]


@dataclass
class Flight:
    """What a run left: one row of `signals` per tick that was completed, the first at the start time."""
    time: np.ndarray                 # (rows,), s
    signals: np.ndarray              # (rows, columns)
    columns: list[Signal]
    finished: bool
    message: str                     # why it ended early; empty if it did not
    startup_s: float                 # loading and initialising
    wall_s: float                    # ticking
    parameters: dict[str, dict[str, Any]]
    fmus: dict[str, dict[str, str]]

    def __getitem__(self, name: str) -> np.ndarray:
        """The column called `component.variable`, shape (rows,)."""
        return self.signals[:, [c.name for c in self.columns].index(name)]

    def has(self, name: str) -> bool:
        return any(c.name == name for c in self.columns)


def tick_count(step: float, stop: float) -> int:
    """Whole number of communication steps to `stop`; UsageError if it is none, or not sensible."""
    if not (0 < step < float("inf") and 0 < stop < float("inf")):
        raise UsageError(f"--step {step:g} and --stop {stop:g} must be positive numbers of seconds.")
    count = round(stop / step)
    if count < 1 or abs(count * step - stop) > 1e-6 * step:
        raise UsageError(f"--stop {stop:g} s is not a whole number of communication steps of {step:g} s.")
    return count


def fly(system: System, step: float, stop: float, algorithm: str = "gauss-seidel",
        progress: Progress | None = None) -> Flight:
    """Fly `system` from 0 to `stop` (s) in communication steps of `step` (s).

    An FMU that refuses a step ends the run early: what was flown is in the result, `finished` is false
    and `message` names the FMU, the time and its reason. So does Ctrl-C.

    Raises UsageError before anything flies if the system or the numbers do not fit; RunError if the
    FMUs cannot be started.
    """
    if algorithm not in ALGORITHMS:
        raise UsageError(f"--algorithm {algorithm} is not known; there are {', '.join(ALGORITHMS)}.")
    ticks, tick = tick_count(step, stop), ALGORITHMS[algorithm]
    began = time.perf_counter()
    with open_files(system) as files:
        master = Master(system, files)
        try:
            master.initialise(0.0, stop)
            rows = np.empty((ticks + 1, len(master.columns)))
            rows[0] = master.signals
            parameters = {m.instance.name: inquire(m) for m in master.members}
            startup = time.perf_counter() - began
            done, message = 0, ""
            began = last = time.perf_counter()
            try:
                for done in range(ticks):
                    tick(master, done * step, step)
                    rows[done + 1] = master.signals
                    if progress and (now := time.perf_counter()) - last > CHUNK_S:
                        last = now
                        progress((done + 1) * step)
                done = ticks
            except RunError as error:
                message = str(error)
            except KeyboardInterrupt:
                message = f"Interrupted at t = {done * step:.6g} s."
            wall = time.perf_counter() - began
        finally:
            master.close()
        fmus = {c.name: {"file": str(c.fmu), "model": files[c.name].description.modelName,
                         "guid": files[c.name].description.guid, "sha256": files[c.name].sha256,
                         "generation_tool": files[c.name].description.generationTool or ""}
                for c in system.components}
    return Flight(time=np.arange(done + 1) * step, signals=rows[:done + 1], columns=master.columns,
                  finished=not message, message=message, startup_s=startup, wall_s=wall,
                  parameters=parameters, fmus=fmus)


def inquire(member: Any) -> dict[str, Any]:
    """All parameters of a component with the values it flies with."""
    file = member.instance.file
    names = [n for causality in ("parameter", "calculatedParameter") for n in file.names(causality)
             if file.variables[n].type != "String"]
    return dict(zip(names, member.instance.get(names)))


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
