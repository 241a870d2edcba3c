"""Gauss-Seidel: each component in turn takes its inputs as they are now, steps, and shows its outputs.

Needs of an FMU: nothing. The order is that of the dependencies which the FMUs declare (a component comes after
those on whose outputs its own depend directly), and the system's where that leaves a choice; order=a+b+c sets it.
Order 1 in the step; what comes later in the tick gets inputs from the step's end, so the error is usually smaller
than Jacobi's. hold=linear as in `jacobi`; inputs from components that have stepped already are interpolated.
A discarded step ends the run: those before it in the tick have stepped already.
"""
from typing import Any, ClassVar

from ..loaded import Master
from ..program import Row
from .base import Experiment, Fixed, chosen_order, turn
from .options import HOLD, ORDER, Options


class GaussSeidel(Fixed):
    """One component after the other: inputs, step, outputs."""
    OPTIONS: ClassVar[Options] = {**HOLD, **ORDER}

    def __init__(self, master: Master, options: dict[str, Any], experiment: Experiment):
        self.hold, self.order = options["hold"], chosen_order(master, options["order"])
        super().__init__(master, experiment)

    def rows(self, decimate: int) -> list[Row]:
        return [r for i in self.order for r in turn(self.master, i, self.hold, decimate)]
