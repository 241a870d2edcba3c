"""Variable: Gauss-Seidel with steps as long as the error allows, each taken twice (step doubling).

From saved states each step is taken once whole and once in halves; the halves' result is kept. The difference of the
two estimates its error. In each connected continuous output it may be `tolerance` times the variable's nominal value
(or its own size, where that is larger); the worst one decides. That is per step, and of what is connected only: the
error of the run falls more slowly than the tolerance. Outputs that depend directly on inputs are left out (if there
are others): they lag behind as the held inputs do, and what that does shows in the others. A step that fails is taken
back through the FMU states and shortened; the next one is as long as the estimate allows. `--step` is the first step
and, times MOST_STEPS, the longest one.

Needs of an FMU: canGetAndSetFMUstate and canHandleVariableCommunicationStepSize. Order as in `gauss_seidel`: 1, and
with hold=linear (the default) 2 where connected outputs are states. A discarded step is taken back and tried at SHRINK
of its length; below SHORTEST of the first step the run ends with the FMU's own words. If it is discarded because the
FMU ends the simulation, the next one is tried up to that time.
"""
from typing import Any, ClassVar

import numpy as np

from ...errors import RunError, UsageError
from .. import program as P
from ..dependencies import value_needs
from ..loaded import NO_ROWS, NO_TIMES, Ended, Master
from ..program import row
from .base import Experiment, chosen_order, need_states, turn
from .options import ORDER, Options, linear, tolerance

MOST_STEPS, SHORTEST = 100, 1e-6  # times the first step
SAFETY, SHRINK, GROW = 0.9, 0.2, 3.0


class Variable:
    """Gauss-Seidel with a step that the estimated error sets."""
    OPTIONS: ClassVar[Options] = {"tolerance": (1e-6, tolerance), "hold": (True, linear), **ORDER}

    def __init__(self, master: Master, options: dict[str, Any], experiment: Experiment):
        need_states(master, "variable")
        for instance in master.instances:
            if not instance.claims("canHandleVariableCommunicationStepSize"):
                raise UsageError(f"--algorithm variable needs steps of any length, and {instance.name} does not claim "
                                 f"canHandleVariableCommunicationStepSize.")
        if master.inputs:
            raise UsageError("--algorithm variable takes no inputs from a table: its steps would be chosen without "
                             "them.")
        self.master, self.experiment, self.ticks = master, experiment, 0
        self.time, self.step = experiment.start, experiment.step
        self.tolerance, hold = options["tolerance"], options["hold"]
        order = chosen_order(master, options["order"])
        self.ops = P.program(r for i in order for r in turn(master, i, hold))
        self.save = P.program(row(P.SAVE, i) for i in order)
        self.restore = P.program(row(P.RESTORE, i) for i in order)
        w = master.wiring
        needs = value_needs(master.system, master.files, master.targets)
        smooth = [s for s in w.sources if w.smooth[s]]
        states = [s for s in smooth if not needs[w.slots[s]]]
        self.slots = np.array(states or smooth, np.int64)
        followed = all(g.interpolates for groups in w.inputs for g in groups if g.real)
        second = hold and (followed or len(states) == len(smooth))
        self.power: float = 1 / 3 if second else 1 / 2  # one over the local error's order
        self.end: Ended | None = None         # the FMU that ended the simulation in the last attempt
        self.failed: float = SHRINK ** (-1 / self.power)  # an error for which the next step is SHRINK as long

    @property
    def done(self) -> bool:
        """Whether the experiment's stop is reached."""
        return self.time >= self.experiment.stop

    def advance(self, most: int) -> None:
        """Take at most `most` steps. Raises RunError if an FMU refuses one that cannot be made shorter, Ended if one
        ends the simulation there."""
        for _ in range(most):
            if self.done:
                return
            self.take()
            if self.ticks % self.experiment.decimate == 0 or self.done:
                self.experiment.recorder.add(self.time, self.master.row())

    def take(self) -> None:
        """One step that is good enough."""
        master, experiment = self.master, self.experiment
        begun, aimed = master.snapshot(), False
        master.cursor[P.STEPS] = self.ticks
        master.run(self.save, 0, 1, self.time, 0.0)
        while True:
            left = experiment.stop - self.time
            last = self.step >= left * (1 - 1e-9)
            step = left if last else self.step if self.step < 0.5 * left else 0.5 * left  # no sliver at the end
            error = self.error(step, begun)
            factor = GROW if error == 0 else SAFETY * error ** -self.power
            self.step = step * min(max(factor, SHRINK), GROW)
            self.step = min(self.step, MOST_STEPS * experiment.step)
            if self.end and not aimed:
                self.step, aimed = self.end.time - self.time, True
            if error <= 1:
                self.time = experiment.stop if last else self.time + step
                self.ticks += 1
                return
            if self.step < SHORTEST * experiment.step:
                raise RunError(f"The step from t = {self.time:.6g} s cannot be made short enough for a tolerance of "
                               f"{self.tolerance:g}: it is below {self.step:.3g} s.")
            master.run(self.restore, 0, 1, self.time, 0.0)
            master.put_back(begun)

    def error(self, step: float, begun: list[np.ndarray]) -> float:
        """Take the step whole, step back, take it in halves; the estimated error over the allowed one."""
        master, w = self.master, self.master.wiring
        if not self.attempt(1, step):
            return self.failed
        whole = w.signals[self.slots]
        master.run(self.restore, 0, 1, self.time, 0.0)
        master.put_back(begun)
        if not self.attempt(2, step / 2):
            return self.failed
        halves = w.signals[self.slots]
        allowed = self.tolerance * np.maximum(np.abs(halves), w.nominal[self.slots])
        ratio = np.abs(whole - halves) / (2 ** (1 / self.power - 1) - 1) / allowed
        worst = float(np.max(ratio, initial=0.0))
        return worst if np.isfinite(worst) else self.failed

    def attempt(self, count: int, step: float) -> bool:
        """Take `count` steps; False if an FMU discards one and a shorter one may be tried."""
        master, self.end = self.master, None
        status = master.attempt(self.ops, 0, count, self.time, step, NO_ROWS, NO_TIMES, 0)
        discarded = status == P.DISCARD and self.ops[master.cursor[P.AT], 0] == P.STEP
        try:
            if not discarded or step * SHRINK <= SHORTEST * self.experiment.step:
                master.check(status, self.ops, self.time, step)
            else:
                master.check_end(self.ops, self.time + master.cursor[P.TICK] * step, step)
        except Ended as end:
            if end.time - self.time <= SHORTEST * self.experiment.step:
                raise
            self.end = end
        return status == 0
