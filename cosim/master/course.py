"""A signal over time, and what is said of it as a whole. Rows may lie at any distance from each other."""
import re
from collections.abc import Container
from dataclasses import dataclass
from functools import lru_cache

import numpy as np


@dataclass(frozen=True)
class Course:
    """The values of a signal, or of a sum of signals, at `time` (s); both have shape (rows,), with at least one row.

    Figures are weighted by time, so that they belong to what was flown and not to how often it was recorded. Between
    two rows a signal runs straight. What holds for whole steps, such as a truth value, shows at a row what held in the
    step that ended there.
    """
    time: np.ndarray
    values: np.ndarray

    def min(self) -> float:
        """The least value."""
        return float(self.values.min())

    def max(self) -> float:
        """The largest value."""
        return float(self.values.max())

    def max_abs(self) -> float:
        """The largest magnitude."""
        return float(np.abs(self.values).max())

    def final(self) -> float:
        """The last value."""
        return float(self.values[-1])

    def integral(self) -> float:
        """The integral over time (trapezoidal rule), in the signal's unit times s; of a single row, 0."""
        return float(np.diff(self.time) @ (self.values[1:] + self.values[:-1]) / 2)

    def mean(self) -> float:
        """The average over time (trapezoidal rule); of a single row, its value."""
        return average(self.time, self.values)

    def rms(self) -> float:
        """The root of the average over time of the values' squares."""
        return float(np.sqrt(average(self.time, self.values**2)))

    def travel(self) -> float:
        """The way up and down: the sum of all changes' magnitudes."""
        return float(np.abs(np.diff(self.values)).sum())

    def time_on(self) -> float:
        """How long (s) a truth value held."""
        return float(np.diff(self.time) @ (self.values[1:] != 0))

    def share_on(self) -> float:
        """The share of the time for which a truth value held, 0 ... 1; of a single row, whether it holds."""
        span = float(self.time[-1] - self.time[0])
        return self.time_on() / span if span > 0 else float(self.values[0] != 0)

    def settling(self, target: float, band: float) -> float | None:
        """Time (s) from the first row until the values stay within `band` of `target`; None if they do not, NaN if one
        of them is no number."""
        away = np.abs(self.values - target)
        if np.isnan(away).any():
            return np.nan
        outside = np.flatnonzero(away > band)
        if not len(outside):
            return 0.0
        last = int(outside[-1])
        if last == len(away) - 1:
            return None
        share = (away[last] - band) / abs(self.values[last + 1] - self.values[last]) if away[last] < np.inf else 1.0
        return float(self.time[last] + share * (self.time[last + 1] - self.time[last]) - self.time[0])

    def at(self, times: np.ndarray | float) -> np.ndarray:
        """The values at `times` (s), in the shape of these; NaN before the first and after the last row."""
        found: np.ndarray = np.interp(times, self.time, self.values, left=np.nan, right=np.nan)
        return found


def average(time: np.ndarray, values: np.ndarray) -> float:
    """The average of `values` over `time` by the trapezoidal rule; of a single row, its value."""
    span = time[-1] - time[0]
    if not span > 0:
        return float(values[0])
    return float(np.diff(time) @ (values[1:] + values[:-1]) / (2 * span))


def terms(expression: str, known: Container[str] = ()) -> list[tuple[int, str]]:
    """`a - b + c` as signs and names: [(1, "a"), (-1, "b"), (1, "c")]. A name that is `known` is never taken apart."""
    if expression in known:
        return [(1, expression)]
    return [*split(expression)]


@lru_cache(1000)
def split(expression: str) -> tuple[tuple[int, str], ...]:
    """The same, where no name has a sign."""
    first, *rest = re.split(r" ([+-]) ", expression)
    signs = (1 if word == "+" else -1 for word in rest[::2])
    return ((1, first.strip()), *zip(signs, (name.strip() for name in rest[1::2])))
