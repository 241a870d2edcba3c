"""A lookup table in one dimension, in the arithmetic that floats and symbols share."""
from collections.abc import Callable, Sequence
from itertools import pairwise
from numbers import Real
from typing import Any


def interpolated(where: Callable[[Any, Any, Any], Any], at: Any, points: Sequence[float], values: Sequence[Any],
                 extrapolate: bool) -> Any:
    """The value at `at` on the straight lines through (points, values): exact at every point, beyond the ends the end's
    value, or with `extrapolate` the line through the last two points there.

    `where` is a backend's. `points` are numbers that increase, at least two; `values` as many, symbols too. Raises
    ValueError for others.
    """
    if not all(isinstance(point, Real) for point in points) or not all(a < b for a, b in pairwise(points)):
        raise ValueError(f"the points of a lookup table are numbers that increase, not {list(points)}")
    if len(points) < 2 or len(values) != len(points):
        raise ValueError(f"a lookup table has at least two points and a value for each, not {len(points)} and "
                         f"{len(values)}")
    ends = list(zip(points, values))
    result = None
    for (x0, y0), (x1, y1) in pairwise(ends):
        line = y0 + (y1 - y0) / (x1 - x0) * (at - x0)
        result = line if result is None else where(at >= x0, line, result)
    if extrapolate:
        return result
    return where(at <= points[0], values[0], where(at >= points[-1], values[-1], result))
