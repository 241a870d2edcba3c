"""The mathematics backend on CasADi symbols: the same names as `fmus.floats`."""
from casadi import (  # noqa: F401
    SX,
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
    fmax,
    fmin,
    if_else,
    log,
    logic_and,
    logic_or,
    sin,
    sinh,
    sqrt,
    tan,
    tanh,
)

from .integrators import integrate  # noqa: F401
from .lookup import interpolated as _interpolated

both = logic_and
either = logic_or


def where(condition: SX | bool, yes: SX | float, no: SX | float) -> SX:
    """`yes` where the condition holds, else `no`."""
    return if_else(condition, yes, no)


def clip(value: SX | float, low: SX | float, high: SX | float) -> SX:
    """`value` within [low, high]."""
    return if_else(value < low, low, if_else(value > high, high, value))


def interpolate(at: SX | float, points: list[float], values: list[SX | float], extrapolate: bool = False) -> SX:
    """The value at `at` of a lookup table, as in `fmus.floats`: the points are numbers, the values symbols too.
    Raises ValueError as there."""
    result: SX = _interpolated(where, at, points, values, extrapolate)
    return result
