"""The mathematics backend on CasADi symbols: the same names as `fmus.floats`."""
from casadi import asin, ceil, cos, exp, fabs, floor, fmax, fmin, if_else, logic_and, logic_or, sin, sqrt, tan  # noqa: F401

both = logic_and
either = logic_or


def where(condition, yes, no):
    return if_else(condition, yes, no)


def clip(value, low, high):
    return if_else(value < low, low, if_else(value > high, high, value))
