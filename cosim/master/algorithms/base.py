"""What all algorithms share: the experiment, pieces of programs, and programs that are the same on every tick."""
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

import numpy as np

from ...errors import RunError, UsageError
from .. import program as P
from ..loaded import Ended, Master
from ..program import Row, row
from ..recording import Recorder
from ..wiring import Group
from .options import Options


@dataclass
class Experiment:
    """From `start`, `ticks` steps of `step` seconds, every `decimate`-th tick recorded; the first `first` of them were
    taken by an earlier flight."""
    start: float
    step: float
    ticks: int
    recorder: Recorder
    decimate: int = 1
    first: int = 0

    @property
    def stop(self) -> float:
        """The end, s."""
        return self.start + self.ticks * self.step


class Algorithm(Protocol):
    """What every algorithm offers; see the package."""
    OPTIONS: ClassVar[Options]
    ticks: int

    def __init__(self, master: Master, options: dict[str, Any], experiment: Experiment) -> None: ...

    @property
    def time(self) -> float:
        """The simulated time, s."""

    @property
    def done(self) -> bool:
        """Whether the experiment's stop is reached."""

    def advance(self, most: int) -> None:
        """Take at most `most` steps. Raises RunError if an FMU refuses one, Ended if one ends the simulation."""


def inputs(master: Master, component: int, hold: bool, period: int = 1) -> list[Row]:
    """Give a component its inputs for a step of `period` ticks: as they are, or on their last slope. Those of a table
    are looked up first."""
    def code(group: Group) -> int:
        if group.in_events:
            return P.OFFER
        return P.SET if not hold or not group.real else P.SLOPE if group.interpolates else P.PREDICT
    return [*(row(P.GET, g.number, period, 0, period) for g in master.wiring.looked_up[component]),
            *(row(code(g), g.number, period, 0, period) for g in master.wiring.inputs[component])]


def step(component: int, period: int = 1) -> Row:
    """One step of a component, over `period` ticks."""
    return row(P.STEP, component, period, 0, period)


def outputs(master: Master, component: int, hold: bool, decimate: int = 1, period: int = 1) -> list[Row]:
    """Read what others need, and on recorded ticks what is only to be recorded."""
    def when(group: Group) -> tuple[int, int]:
        return (period, 0) if period > 1 or group.connected else (decimate, decimate - 1)
    marks = [row(P.MARK, component, period, 0, period)] if hold or period > 1 else []
    return marks + [row(P.GET, g.number, *when(g)) for g in master.wiring.outputs[component]]


def turn(master: Master, component: int, hold: bool, decimate: int = 1, period: int = 1) -> list[Row]:
    """A component's whole share of a tick: inputs, step, outputs."""
    return [*inputs(master, component, hold, period), step(component, period),
            *outputs(master, component, hold, decimate, period)]


def chosen_order(master: Master, order: list[str] | None) -> list[int]:
    """The numbers of the components in the given order; without one, in that of the declared dependencies.

    Raises UsageError unless `order` names each component once.
    """
    if order is None:
        return [master.number[n] for group in master.step_order for n in group]
    if sorted(order) != sorted(master.number):
        raise UsageError(f"order={'+'.join(order)} must name each component once: {'+'.join(master.number)}.")
    return [master.number[name] for name in order]


def need_states(master: Master, algorithm: str) -> None:
    """Raises UsageError, naming the components, if some cannot save and restore their state."""
    lacking = master.cannot_save()
    if lacking:
        raise UsageError(f"--algorithm {algorithm} steps back, and {', '.join(lacking)} cannot: "
                         f"the FMU does not claim canGetAndSetFMUstate.")


class Even:
    """An algorithm whose ticks are equally long."""
    master: Master
    experiment: Experiment
    ticks: int

    @property
    def time(self) -> float:
        """The simulated time, s."""
        return self.experiment.start + self.ticks * self.experiment.step

    @property
    def done(self) -> bool:
        """Whether the experiment's stop is reached."""
        return self.ticks == self.experiment.ticks

    def last_row(self, end: Ended, ops: np.ndarray, at: int) -> None:
        """Record the time at which an FMU ended the simulation in the row `at` of `ops`, where the others can reach it.

        They can if it is the end of the tick. If it is earlier, none may have stepped yet, and all must claim steps of
        any length.
        """
        master, experiment, begun = self.master, self.experiment, self.time
        others = [master.instances[i] for i in ops[ops[:, 0] == P.STEP, 1] if ops[at, 1] != i]
        short = end.time < begun + experiment.step * (1 - 1e-9)
        stepped = bool(np.any(ops[:at, 0] == P.STEP))
        able = all(i.claims("canHandleVariableCommunicationStepSize") for i in others)
        if end.time <= begun or np.any(ops[:, 2] != 1) or (short and (stepped or not able)):
            return
        rest = ops[(np.arange(len(ops)) > at) | (ops[:, 0] == P.GET)]
        try:
            if short:
                master.run(rest, 0, 1, begun, end.time - begun)
            else:  # the same numbers as on any other tick
                master.run(rest, self.ticks, 1, experiment.start, experiment.step)
        except RunError:
            return
        self.ticks += 1
        experiment.recorder.add(end.time if short else self.time, master.row())


class Fixed(Even):
    """An algorithm with the same program on every tick. A discarded step ends the run: no step is taken back."""

    def __init__(self, master: Master, experiment: Experiment):
        self.master, self.experiment, self.ticks = master, experiment, experiment.first
        self.ops = P.program(self.rows(experiment.decimate))
        self.last_ops = P.program(self.rows(1))  # the last tick is recorded whatever its number

    def rows(self, decimate: int) -> list[Row]:
        """The program of one tick when every `decimate`-th is recorded."""
        raise NotImplementedError

    def advance(self, most: int) -> None:
        """Take at most `most` steps. Raises RunError if an FMU refuses one, Ended if one ends the simulation."""
        experiment = self.experiment
        odd = experiment.ticks % experiment.decimate != 0
        count = max(0, min(most, experiment.ticks - self.ticks - odd))
        ops, decimate = self.ops, experiment.decimate
        if count == 0:
            ops, count, decimate = self.last_ops, 1, 1
        rows, times = experiment.recorder.room(count // decimate + 1)
        cursor = self.master.cursor
        cursor[P.TICK], cursor[P.AT], cursor[P.ROWS] = self.ticks, 0, 0
        status = self.master.attempt(ops, self.ticks, count, experiment.start, experiment.step, rows, times, decimate)
        self.ticks = self.ticks + count if status == 0 else int(self.master.cursor[P.TICK])
        experiment.recorder.took(int(self.master.cursor[P.ROWS]))
        at = int(self.master.cursor[P.AT])
        try:
            self.master.check(status, ops, experiment.start, experiment.step)
        except Ended as end:
            self.last_row(end, self.last_ops, at)
            raise
