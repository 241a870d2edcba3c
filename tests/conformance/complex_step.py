"""The mathematics backend on complex numbers, and derivatives by the complex step: f'(x) d = Im f(x + i h d) / h.

There is no rounding of a difference. What compares looks at the real part, as the equations do on floats.
"""
import cmath
import math
from types import SimpleNamespace

H = 1e-40


class Complex(complex):
    """A complex number that can be compared."""

    def __lt__(self, other):
        return self.real < other.real

    def __gt__(self, other):
        return self.real > other.real

    def __le__(self, other):
        return self.real <= other.real

    def __ge__(self, other):
        return self.real >= other.real

    def __bool__(self):
        return self.real != 0


def of(function):
    return lambda *arguments: Complex(function(*arguments))


for name in ("add", "radd", "sub", "rsub", "mul", "rmul", "truediv", "rtruediv", "pow", "rpow", "neg"):
    setattr(Complex, f"__{name}__", of(getattr(complex, f"__{name}__")))

asin, cos, exp, log, sin, sqrt, tan = map(of, (cmath.asin, cmath.cos, cmath.exp, cmath.log, cmath.sin, cmath.sqrt,
                                               cmath.tan))


def floor(value):
    return math.floor(value.real)


def ceil(value):
    return math.ceil(value.real)


def fabs(value):
    return value if value.real >= 0 else -value


def where(condition, yes, no):
    return yes if condition else no


def fmin(a, b):
    return a if a.real < b.real else b


def fmax(a, b):
    return a if a.real > b.real else b


def clip(value, low, high):
    return low if value.real < low.real else high if value.real > high.real else value


def both(a, b):
    return a and b


def either(a, b):
    return a or b


def stepped(values, direction):
    """`values`, moved by the complex step along `direction`: both dicts, or both lists."""
    if isinstance(values, dict):
        return SimpleNamespace(**{k: v if isinstance(v, bool) else Complex(v, H * direction.get(k, 0.0))
                                  for k, v in values.items()})
    return [Complex(v, H * d) for v, d in zip(values, direction)]


def derivative(result):
    """The derivative of a result along the direction of its arguments."""
    return complex(result).imag / H
