"""Jacobi: all components take the inputs of the tick's start, all step, then all show their outputs.

Needs of an FMU: nothing. Order of the component does not matter, so it is what every other master offers, and
what could run in parallel. Order 1 in the step: an input is one step behind at the end of the step. With
hold=linear inputs follow their last slope (fmi2SetRealInputDerivatives where the FMU claims canInterpolateInputs,
else the value expected halfway is held): order 2 where the connected outputs are states; where they depend
directly on inputs they still show the inputs that were held, and the order stays 1.
A discarded step ends the run: the others have stepped already.
"""
from typing import Any, ClassVar

from ..loaded import Master
from ..program import Row
from .base import Experiment, Fixed, inputs, outputs, step
from .options import HOLD, Options


class Jacobi(Fixed):
    """All inputs, then all steps, then all outputs."""
    OPTIONS: ClassVar[Options] = HOLD

    def __init__(self, master: Master, options: dict[str, Any], experiment: Experiment):
        self.hold = options["hold"]
        super().__init__(master, experiment)

    def rows(self, decimate: int) -> list[Row]:
        components = range(len(self.master.instances))
        return [*(r for i in components for r in inputs(self.master, i, self.hold)),
                *(step(i) for i in components),
                *(r for i in components for r in outputs(self.master, i, self.hold, decimate))]
