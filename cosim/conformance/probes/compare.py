"""How far two trajectories differ, and how much of that the FMU's tolerance explains."""
import math
import struct
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from ..fmi2 import Value
from ..job import Job, Known

BITS = 1e-12  # a smaller share of the scale is rounding
LEAST_SCALE = 1e-6  # of the nominal: a variable that stays below that is noise around zero
GROWTH = 5.0  # the last difference above the first, from where on it is called a drift

Column = tuple[Known, Sequence[Value], Sequence[Value]]


class Difference(NamedTuple):
    """Where two trajectories differ most: `share` is the greatest difference by the variable's own scale.

    `is_explained`: the tolerance allows for it. `counts`: the variable is an output or a state; the tolerance says
    nothing of others, derivatives least of all.
    """
    variable: str
    text: str
    share: float
    counts: bool
    is_explained: bool


def worst_difference(columns: Iterator[Column], times: Sequence[float], job: Job) -> Difference | None:
    """The greatest difference of all variables, each by its own scale; None if all are equal to the last bit.

    What counts and is beyond the tolerance comes first. A column has a variable with its values in both runs, at
    `times` (s). What is no Real differs by infinity.
    """
    worst: tuple[tuple[bool, float], Column, list[tuple[float, float]]] | None = None
    for column in columns:
        shares = list(differences(column, times))
        share = max((share for _, share in shares), default=0.0)
        rank = column[0].counts and not explains(job, column, share), share
        if shares and (worst is None or rank > worst[0]):
            worst = rank, column, shares
    if worst is None:
        return None
    (_, share), column, shares = worst
    v, first, second = column
    at = times.index(shares[0][0])
    text = f"{second[at]!r} instead of {first[at]!r} at time {times[at]:g}"
    return Difference(v.name, f"{text}{grown(shares)}", share, v.counts, explains(job, column, share))


def differences(column: Column, times: Sequence[float]) -> Iterator[tuple[float, float]]:
    """(time, difference by the variable's scale) wherever the values differ."""
    _, first, second = column
    scale = scale_of(column)
    for time, a, b in zip(times, first, second, strict=False):
        if bits(a) == bits(b):
            continue
        is_measured = isinstance(a, float) and isinstance(b, float) and math.isfinite(a) and math.isfinite(b)
        yield time, abs(a - b) / scale if is_measured else math.inf  # type: ignore[operator]


def scale_of(column: Column) -> float:
    """The greatest magnitude that a variable has in two runs, but no less than LEAST_SCALE of its nominal value."""
    v, first, second = column
    numbers = [abs(x) for x in (*first, *second) if isinstance(x, float) and math.isfinite(x)]
    return max([*numbers, LEAST_SCALE * abs(v.nominal or 1.0)])


def explains(job: Job, column: Column, share: float) -> bool:
    """Whether the tolerance allows a variable to differ by a `share` of its scale."""
    scale = scale_of(column)
    nominal = abs(column[0].nominal or 1.0) if job.has_tolerance else 0.0
    return share * scale <= job.tolerance * max(scale, nominal)


def grown(shares: list[tuple[float, float]]) -> str:
    """The end of a sentence that says whether differences grow with time."""
    (begin, first), (end, last) = shares[0], shares[-1]
    third = len(shares) // 3
    if third < 2 or not 0 < first < math.inf or last < GROWTH * first or last == math.inf:
        return ""
    if max(share for _, share in shares[:third]) > max(share for _, share in shares[-third:]):
        return ""
    return f"; it grows with time, from {first:.2g} of the scale at {begin:g} to {last:.2g} at {end:g}"


def bits(value: Value) -> object:
    """A value so that equal means equal to the last bit, also for NaN and for -0.0."""
    return struct.pack("<d", value) if isinstance(value, float) else value
