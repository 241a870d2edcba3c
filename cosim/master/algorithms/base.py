"""What the algorithms' programs are made of, and how a program of fixed ticks is flown."""
from dataclasses import dataclass
from typing import Any

from ...errors import UsageError
from .. import program as P
from ..dependencies import step_order
from ..loaded import Master
from ..program import Row, row
from ..recording import Recorder


@dataclass
class Experiment:
    """From `start`, `ticks` steps of `step` seconds, every `decimate`-th tick recorded."""
    start: float
    step: float
    ticks: int
    recorder: Recorder
    decimate: int = 1

    @property
    def stop(self) -> float:
        return self.start + self.ticks * self.step


def inputs(master: Master, part: int, hold: bool, period: int = 1) -> list[Row]:
    """Give a component its inputs for a step of `period` ticks: as they are, or on their last slope."""
    def code(group: Any) -> int:
        return P.SET if not hold or group.suffix != "Real" else P.SLOPE if group.interpolates else P.PREDICT
    return [row(code(g), g.number, period, 0, period) for g in master.wiring.inputs[part]]


def step(part: int, period: int = 1) -> Row:
    return row(P.STEP, part, period, 0, period)


def outputs(master: Master, part: int, hold: bool, decimate: int = 1, period: int = 1) -> list[Row]:
    """Read what others need, and on recorded ticks what is only to be recorded."""
    def when(group: Any) -> tuple[int, int]:
        return (period, 0) if period > 1 or group.connected or decimate == 1 else (decimate, decimate - 1)
    marks = [row(P.MARK, part, period, 0, period)] if hold else []
    return marks + [row(P.GET, g.number, *when(g)) for g in master.wiring.outputs[part]]


def turn(master: Master, part: int, hold: bool, decimate: int = 1, period: int = 1) -> list[Row]:
    """A component's whole share of a tick: inputs, step, outputs."""
    return [*inputs(master, part, hold, period), step(part, period), *outputs(master, part, hold, decimate, period)]


def chosen_order(master: Master, order: list[str] | None) -> list[int]:
    """The numbers of the components in the wished order; without one, in that of the declared dependencies.

    Raises UsageError if the wish is not exactly the components.
    """
    if order is None:
        return [master.number[n] for group in step_order(master.system, master.files, master.targets) for n in group]
    if sorted(order) != sorted(master.number):
        raise UsageError(f"order={'+'.join(order)} must name each component once: {'+'.join(master.number)}.")
    return [master.number[name] for name in order]


def need_states(master: Master, algorithm: str) -> None:
    """UsageError naming the components that cannot step back."""
    lacking = master.cannot_save()
    if lacking:
        raise UsageError(f"--algorithm {algorithm} steps back, and {', '.join(lacking)} cannot: "
                         f"the FMU does not claim canGetAndSetFMUstate.")


class Even:
    """What flies in ticks of equal length: where it is, and whether it has arrived."""
    plan: Experiment
    ticks: int

    @property
    def time(self) -> float:
        return self.plan.start + self.ticks * self.plan.step

    @property
    def done(self) -> bool:
        return self.ticks == self.plan.ticks


class Fixed(Even):
    """Flies a program that is the same on every tick. A discarded step ends the run: nothing is taken back."""

    def __init__(self, master: Master, plan: Experiment):
        self.master, self.plan, self.ticks = master, plan, 0
        self.ops = P.program(self.rows(plan.decimate))
        self.last_ops = P.program(self.rows(1))  # the last tick is recorded whatever its number

    def rows(self, decimate: int) -> list[Row]:
        raise NotImplementedError

    def advance(self, most: int) -> None:
        plan = self.plan
        odd = plan.ticks % plan.decimate != 0
        count = min(most, plan.ticks - self.ticks - odd)
        ops, decimate = self.ops, plan.decimate
        if count == 0:
            ops, count, decimate = self.last_ops, 1, 1
        rows, times = plan.recorder.room(count // decimate + 1)
        self.master.cursor[:3] = self.ticks, 0, 0
        status = self.master.attempt(ops, self.ticks, count, plan.start, plan.step, rows, times, decimate)
        self.ticks = self.ticks + count if status == 0 else int(self.master.cursor[0])
        plan.recorder.took(int(self.master.cursor[2]))
        self.master.check(status, ops, plan.start, plan.step)
