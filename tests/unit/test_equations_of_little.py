"""FMUs without states, continuous outputs or inputs are linearised, too: their matrices are empty."""
from types import SimpleNamespace

import numpy as np
import pytest

from cosim.analysis.equations import Equations


class Little(Equations):
    """Equations of an FMU that answers no call."""

    def __init__(self, own):
        variable = SimpleNamespace(reference=0, array="", place=0, nominal=None)
        self.states, self.own = [], own
        self.file = SimpleNamespace(variables={"u": variable}, arrays={}, together=list, references=lambda names: [],
                                    description=SimpleNamespace(flat=False, derivatives=[]))
        self.instance = SimpleNamespace(get=lambda names: np.zeros(len(names)), set=lambda values: None)

    def call(self, name, *arguments):
        assert name != "GetDirectionalDerivative"

    def rates(self):
        return np.zeros(0)


@pytest.mark.parametrize("own", [True, False])
@pytest.mark.parametrize("inputs", [[], ["u"]])
def test_there_may_be_nothing_to_tell(own, inputs):
    system = Little(own).linear(inputs, [])
    assert [getattr(system, name).shape for name in "ABCD"] == [(0, 0), (0, len(inputs)), (0, 0), (0, len(inputs))]
