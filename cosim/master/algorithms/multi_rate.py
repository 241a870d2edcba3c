"""Multi-rate: Gauss-Seidel in which each component steps once in a whole number of ticks.

`multi-rate,controller=20` at a step of 1 ms is a 50 Hz controller on a 1 kHz plant. A slow component takes its
inputs at the start of its step, steps over all its ticks at once, and what it shows holds until its next step (with
hold=linear: is interpolated). With all rates 1 it is Gauss-Seidel to the last bit.

Other components take what a slow one shows from the start of its step on, as they do in Gauss-Seidel. The recorded
rows have it from the end of that step on, the time for which the FMU gave it.

Needs of an FMU: that it accepts its own step. Order 1 in the slowest step, as `gauss_seidel`. The run's number of
ticks must be a multiple of every rate. A discarded step ends the run.
"""
from math import lcm
from typing import Any, ClassVar

from ...errors import UsageError
from ..loaded import Master
from ..program import Row
from .base import Experiment, Fixed, chosen_order, turn
from .options import HOLD, ORDER, Options


class MultiRate(Fixed):
    """Gauss-Seidel with a period, in ticks, for each component."""
    OPTIONS: ClassVar[Options] = {**HOLD, **ORDER, "rates": ({}, None)}

    def __init__(self, master: Master, options: dict[str, Any], experiment: Experiment):
        self.hold, self.order, rates = options["hold"], chosen_order(master, options["order"]), options["rates"]
        for name in set(rates) - set(master.number):
            raise UsageError(f"--algorithm multi-rate: there is no component {name}; "
                             f"there are {', '.join(master.number)}.")
        if experiment.ticks % lcm(*rates.values()):
            raise UsageError(f"--algorithm multi-rate: {experiment.ticks} ticks are not a whole number of steps for "
                             f"all of {', '.join(f'{n}={k}' for n, k in rates.items())}.")
        self.periods = {master.number[name]: period for name, period in rates.items()}
        super().__init__(master, experiment)

    def rows(self, decimate: int) -> list[Row]:
        return [r for i in self.order for r in turn(self.master, i, self.hold, decimate, self.periods.get(i, 1))]
