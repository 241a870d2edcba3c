"""Iterated: components around an algebraic loop repeat the step until their outputs agree with each other's inputs.

A loop is where the FMUs declare it: connected outputs that depend directly on inputs, around a circle. The rest goes
in order, as in `gauss_seidel`, and without loops the result is that to the last bit. Within a loop the inputs are those
of the step's end (with hold=linear: the course from its start to its end, order 2 where outputs are states);
order 1, and stable for stiff couplings for which one pass is not.

Needs of an FMU: canGetAndSetFMUstate, of those in a loop. Ends when no connected output changes by more than
`tolerance` of its nominal (or own) size; after `passes` without that, the run ends with an error that names them.
A discarded step ends the run, as the step cannot be made shorter.
"""
from typing import Any, ClassVar

import numpy as np

from ...errors import RunError, UsageError
from .. import program as P
from ..dependencies import looped, value_needs
from ..loaded import Ended, Master
from ..program import row
from .base import Even, Experiment, inputs, outputs, step, turn
from .options import HOLD, Options, positive, whole


class Iterated(Even):
    """Gauss-Seidel that repeats the steps of each algebraic loop until its signals agree."""
    OPTIONS: ClassVar[Options] = {**HOLD, "tolerance": (1e-10, positive), "passes": (50, whole)}

    def __init__(self, master: Master, options: dict[str, Any], experiment: Experiment):
        self.master, self.experiment, self.ticks = master, experiment, experiment.first
        self.tolerance, self.passes, hold = options["tolerance"], options["passes"], options["hold"]
        self.blocks: list[tuple[np.ndarray, np.ndarray | None, np.ndarray]] = []  # first pass, further ones, slots
        w = master.wiring
        lacking = set(master.cannot_save())
        loops = looped(value_needs(master.system, master.files, master.targets))
        for group in master.step_order:
            members = [master.number[name] for name in group]
            once = [r for i in members for r in turn(master, i, hold)]
            if not loops & set(group):
                self.blocks.append((P.program(once), None, np.empty(0, np.int64)))
                continue
            if lacking & set(group):
                raise UsageError(f"--algorithm iterated repeats steps, and {', '.join(sorted(lacking & set(group)))} "
                                 f"cannot: the FMU does not claim canGetAndSetFMUstate.")
            repeat = [r for i in members for r in
                     (row(P.RESTORE, i), *inputs(master, i, hold), step(i), *outputs(master, i, False))]
            self.blocks.append((P.program([*(row(P.SAVE, i) for i in members), *once]), P.program(repeat),
                                w.sources[np.isin(w.holder[w.sources], members)]))

    def advance(self, most: int) -> None:
        """Take at most `most` steps. Raises RunError if an FMU refuses one, or a loop does not converge; Ended if one
        ends the simulation."""
        experiment, master = self.experiment, self.master
        for _ in range(min(most, experiment.ticks - self.ticks)):
            for number, (once, repeat, slots) in enumerate(self.blocks):
                try:
                    master.run(once, self.ticks, 1, experiment.start, experiment.step)
                except Ended as end:
                    if all(again is None for _, again, _ in self.blocks):
                        programs = [block[0] for block in self.blocks]
                        at = sum(map(len, programs[:number])) + int(master.cursor[P.AT])
                        self.last_row(end, np.concatenate(programs), at)
                    raise
                if repeat is not None:
                    self.settle(repeat, slots)
            self.ticks += 1
            if self.ticks % experiment.decimate == 0 or self.done:
                experiment.recorder.add(self.time, master.row())

    def settle(self, repeat: np.ndarray, slots: np.ndarray) -> None:
        """Repeat the step until the signals at `slots` change no more. Raises RunError after `passes` of them."""
        w, experiment = self.master.wiring, self.experiment
        for _ in range(self.passes):
            before = w.signals[slots]
            self.master.run(repeat, self.ticks, 1, experiment.start, experiment.step)
            after = w.signals[slots]
            settled = np.abs(after - before) <= self.tolerance * np.maximum(np.abs(after), w.nominal[slots])
            if np.all(settled):
                return
        unsettled = [w.slots[s] for s, still in zip(slots, settled) if not still]
        raise RunError(f"The loop does not converge in the step from t = {self.time:.6g} s: {', '.join(unsettled[:5])} "
                       f"still change after {self.passes} passes.")
