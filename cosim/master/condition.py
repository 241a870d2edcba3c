"""Where something is true or false over time. What a comparison of signals is; Boolean signals are read as one."""
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .course import Course

Truths = Callable[..., np.ndarray]


@dataclass(frozen=True)
class Condition:
    """What holds at each of the times `time` (s), and what holds between each of them and the next.

    `time` and `points` have shape (n,), `between` has shape (n - 1,); n is at least 1.
    """
    time: np.ndarray
    points: np.ndarray
    between: np.ndarray

    @classmethod
    def held(cls, course: Course) -> "Condition":
        """Of a truth value, or of a number that is not 0: a row shows what held in the step that ended there. Raises
        ArithmeticError where it is not finite."""
        holds = finite(course).values != 0
        return cls(course.time, holds, holds[1:])

    @classmethod
    def crossed(cls, difference: Course, compare: Truths) -> "Condition":
        """Where `compare(difference, 0)` holds. Between two rows the difference runs straight, so that it is known when
        it crosses 0. Raises ArithmeticError where it is not finite."""
        time, values = difference.time, finite(difference).values
        signs = np.sign(values)
        at = np.flatnonzero(signs[1:] * signs[:-1] < 0)
        if len(at):
            share = values[at] / (values[at] - values[at + 1])
            time = np.insert(time, at + 1, time[at] + share * (time[at + 1] - time[at]))
            signs = np.insert(signs, at + 1, 0.0)
        return cls(time, compare(signs, 0), compare(signs[1:] + signs[:-1], 0))

    def on(self, time: np.ndarray) -> "Condition":
        """The same at other times, which lie within its own and have all of those between them."""
        ends = np.searchsorted(self.time, time)
        held = np.concatenate((self.points[:1], self.between))   # in the step that ended at each time
        own = self.time[ends] == time
        return Condition(time, np.where(own, self.points[ends], held[ends]), held[ends[1:]])

    def time_on(self) -> float:
        """How long (s) it holds."""
        return float(np.diff(self.time) @ self.between)

    def first(self) -> float:
        """Time (s) from the first row until it holds; infinite if it never does."""
        found = [self.time[np.argmax(holds)] for holds in (self.points, self.between) if holds.any()]
        return float(min(found) - self.time[0]) if found else np.inf


def finite(course: Course) -> Course:
    """The course itself. Raises ArithmeticError where it is not finite."""
    if not (known := np.isfinite(course.values)).all():
        raise ArithmeticError(f"what is compared is not a finite number at t = {course.time[np.argmin(known)]:.6g} s")
    return course


def combined(function: Truths, *parts: Condition) -> Condition:
    """`function` of conditions (np.logical_and and the like), at all times of all of them, while all are known."""
    if any(part.time is not parts[0].time for part in parts):
        begin, end = max(part.time[0] for part in parts), min(part.time[-1] for part in parts)
        time = np.unique(np.concatenate([part.time for part in parts]))
        time = time[(time >= begin) & (time <= end)]
        parts = tuple(part.on(time) for part in parts)
    return Condition(parts[0].time, function(*(part.points for part in parts)),
                     function(*(part.between for part in parts)))
