"""The mathematics backend on plain floats: what a model's equations may call, and nothing more.

`fmus.symbols` has the same names on CasADi symbols.
"""
from math import asin, ceil, cos, exp, fabs, floor, sin, sqrt, tan  # noqa: F401


def where(condition, yes, no):
    return yes if condition else no


def fmin(a, b):
    return a if a < b else b


def fmax(a, b):
    return a if a > b else b


def clip(value, low, high):
    return low if value < low else high if value > high else value


def both(a, b):
    return a and b


def either(a, b):
    return a or b
