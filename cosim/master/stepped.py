"""A system that is flown step by step, by somebody who gives inputs before each step."""
from collections.abc import Mapping, Sequence
from math import nan
from pathlib import Path

import numpy as np

from ..errors import UsageError
from .algorithms import Method
from .algorithms.base import Algorithm, Even, Experiment
from .flight import Flight
from .fly import inquire, origins, tick_count
from .kept import Kept
from .recording import Whole
from .system import System, Value
from .table import Table


class Stepped:
    """A system whose `inputs` (component.variable -> start value) are given before each advance of `hold` communication
    steps of `step` (s), until `stop` (s). It stays loaded from flight to flight.

    `record` are patterns of the signals to keep. Raises UsageError for what does not fit.
    """

    def __init__(self, system: System, inputs: Mapping[str, float], record: Sequence[str], step: float, stop: float,
                 chosen: Method, hold: int = 1):
        if not issubclass(chosen.algorithm, Even):
            raise UsageError(f"--algorithm {chosen.word} is not allowed: inputs are given step by step, and its steps "
                             f"are not equally long.")
        ticks = tick_count(step, stop, system.start)
        if not isinstance(hold, int) or isinstance(hold, bool) or hold < 1 or ticks % hold:
            raise UsageError(f"hold = {hold!r} is not allowed: it must be a whole number that divides the {ticks} "
                             f"communication steps of a flight.")
        self.start, self.step, self.ticks, self.chosen, self.hold = system.start, step, ticks, chosen, hold
        # The inputs are a table of one row, which is written anew before each step.
        self.system = system
        self.kept = Kept(record=list(record), apart=hold > 1, table=Table(
            Path("actions"), np.array([system.start]), {name: np.array([x]) for name, x in inputs.items()}))
        self.recorder: Whole | None = None
        self.running: Algorithm | None = None

    def begin(self, values: Mapping[str, Value]) -> np.ndarray:
        """Begin a flight with `values` (component.variable -> value); the signals at its start, see `row`.

        Raises UsageError for values that do not fit, RunError if an FMU refuses.
        """
        self.running = None
        master = self.kept.ready(self.system.with_values(values))
        assert master.inputs is not None
        self.given: np.ndarray = master.inputs.rows[0]
        for i, name in enumerate(master.inputs.names):
            component, _, variable = name.partition(".")
            self.given[i] = master.values[component].get(variable, master.files[component].start(variable))
        if self.recorder is None:
            self.recorder = Whole(master.columns, self.ticks // self.hold + 2)
            self.places = {c.name: i for i, c in enumerate(master.columns)}
        experiment = Experiment(self.start, self.step, self.ticks, self.recorder.restart(), self.hold)
        running = self.chosen.algorithm(master, self.chosen.options, experiment)
        master.initialise(self.start, experiment.stop)
        self.recorder.add(running.time, master.row_at(running.time, self.step))
        self.running = running
        return self.row

    def advance(self, inputs: np.ndarray) -> np.ndarray:
        """Hold `inputs`, shape (inputs,), for an advance; the signals at its end, see `row`.

        Raises RunError if an FMU refuses a step, Ended, which is one, if an FMU ends the simulation; then the flight is
        over, and `row` is the last one that was complete. Raises UsageError if no flight is under way.
        """
        running = self.running
        if running is None or running.done:
            raise UsageError("There is no step to take: the flight is over, or did not begin. Reset it.")
        self.given[:] = inputs
        running.advance(self.hold)
        return self.row

    @property
    def row(self) -> np.ndarray:
        """The last signals, shape (columns,), in the order of `places`; valid until the next flight begins."""
        assert self.recorder is not None
        row: np.ndarray = self.recorder.rows[self.recorder.used - 1]
        return row

    @property
    def time(self) -> float:
        """The time of `row`, s; nan before the first flight."""
        return float(self.recorder.times[self.recorder.used - 1]) if self.recorder and self.recorder.used else nan

    @property
    def done(self) -> bool:
        """Whether the stop is reached."""
        return self.running is not None and self.running.done

    def flight(self, message: str = "", ended_at: float | None = None) -> Flight:
        """What was flown since the last `begin`, with why it ended if that was early. Of an FMU that has failed the
        parameters are those that were set. Raises UsageError without a flight."""
        master = self.kept.master
        if self.recorder is None or self.running is None or master is None:
            raise UsageError("There is no flight yet: reset it first.")
        time, signals = (array.copy() for array in self.recorder.finish())
        parameters = {i.name: master.values[i.name] if i.failed else inquire(i) for i in master.instances}
        return Flight(time, signals, master.columns, not message or ended_at is not None, message, 0.0, 0.0, parameters,
                      origins(master), self.running.ticks, self.time, ended_at=ended_at)

    def close(self) -> None:
        """End and unload the FMUs."""
        self.running = None
        self.kept.close()
