"""The mathematics backend on plain floats: what a model's equations may call, and nothing more.

`fmus.symbols` has the same names on CasADi symbols. Every function takes and returns single numbers;
`integrate` and `interpolate` work on lists of them too.
"""
from math import (  # noqa: F401
    acos,
    asin,
    atan,
    atan2,
    ceil,
    cos,
    cosh,
    exp,
    fabs,
    floor,
    log,
    sin,
    sinh,
    sqrt,
    tan,
    tanh,
)

from .integrators import integrate  # noqa: F401
from .lookup import interpolated as _interpolated


def where(condition: bool, yes: float, no: float) -> float:
    """`yes` where the condition holds, else `no`; both are computed."""
    return yes if condition else no


def fmin(a: float, b: float) -> float:
    """The smaller number."""
    return a if a < b else b


def fmax(a: float, b: float) -> float:
    """The larger number."""
    return a if a > b else b


def clip(value: float, low: float, high: float) -> float:
    """`value` within [low, high]."""
    return low if value < low else high if value > high else value


def both(a: bool, b: bool) -> bool:
    """Whether both conditions hold."""
    return a and b


def either(a: bool, b: bool) -> bool:
    """Whether one of the conditions holds, or both."""
    return a or b


def interpolate(at: float, points: list[float], values: list[float], extrapolate: bool = False) -> float:
    """The value at `at` of a lookup table, on straight lines between its points; beyond them the last value, or
    with `extrapolate` the last line. The points increase; `values` has one for each. Raises ValueError otherwise."""
    return float(_interpolated(where, at, points, values, extrapolate))
