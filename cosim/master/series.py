"""One signal of a flight: an array that knows its unit."""
from typing import Any

import numpy as np

from .wiring import Signal

UNKNOWN = Signal("", "", "")


class Series(np.ndarray):
    """A numpy array of shape (rows,) with the unit and description that the FMU declares.

    Slices keep the unit. Results of arithmetic are plain arrays: their unit may be another one.
    """
    signal: Signal = UNKNOWN

    @classmethod
    def of(cls, values: np.ndarray, signal: Signal) -> "Series":
        """`values` as they are in memory, with what `signal` says of them."""
        made = values.view(cls)
        made.signal = signal
        return made

    @property
    def name(self) -> str:
        """component.variable"""
        return self.signal.name

    @property
    def unit(self) -> str:
        """The unit of the values; empty if the FMU declares none."""
        return self.signal.unit

    @property
    def display_unit(self) -> str:
        """The unit in which the FMU wants people to see the values; `unit` if it does not say."""
        return self.signal.display_unit or self.signal.unit

    @property
    def description(self) -> str:
        """What the FMU says of the variable."""
        return self.signal.description

    @property
    def displayed(self) -> "Series":
        """The values in `display_unit`."""
        s = self.signal
        values = np.asarray(self) * s.display_factor + s.display_offset
        return Series.of(values, Signal(s.name, self.display_unit, s.description))

    def __array_finalize__(self, source: Any) -> None:
        if isinstance(source, Series):
            self.signal = source.signal

    def __array_wrap__(self, array: np.ndarray, context: Any = None, return_scalar: bool = False) -> Any:
        plain = np.asarray(array)
        return plain if plain.ndim else plain[()]

    def __reduce__(self) -> Any:
        return Series.of, (np.asarray(self), self.signal)
