"""How the Python flavour refuses a call.

For an exception pythonfmu's binary returns fmi2Fatal. It has no way to return fmi2Error, and with fmi2Discard (do_step
returns False) it also says that the FMU ends the simulation, which none of ours does. So a refusal is an exception.
`tests/conformance/contract.py` has what both flavours answer to each call.
"""
import ctypes
from collections.abc import Callable
from functools import wraps
from math import inf, isfinite
from typing import Any

from .interface import Variable


class Refused(Exception):
    """A call that is refused. pythonfmu shows the importer its repr: the sentence."""

    def __repr__(self) -> str:
        return str(self)


def refusing(method: Callable[..., Any]) -> Callable[..., Any]:
    """A method that pythonfmu's binary calls, and that may raise.

    For every exception the binary drops its references of instance, class and messages, and goes on using them. It is
    given those references here, so that fmi2Terminate, fmi2Reset and fmi2FreeInstance find what they need.
    """
    @wraps(method)
    def safe(self: Any, *arguments: object) -> object:
        try:
            return method(self, *arguments)
        except BaseException:
            for kept in (self, type(self), self.log_queue):
                ctypes.pythonapi.Py_IncRef(ctypes.py_object(kept))
            raise

    return safe


def with_unit(v: Variable, value: float) -> str:
    """A value with its unit, angles in degrees."""
    return f"{v.displayed(value):.6g}{v.unit_suffix}"


def out_of_range(v: Variable, value: float) -> str | None:
    """Why `value` may not stand for `v`, or None."""
    if not isfinite(value):
        return f"{v.name} = {value} is not a finite number"
    if v.minimum is not None and value < v.minimum:
        return f"{v.name} = {with_unit(v, value)} is below its minimum {with_unit(v, v.minimum)}"
    if v.maximum is not None and value > v.maximum:
        return f"{v.name} = {with_unit(v, value)} is above its maximum {with_unit(v, v.maximum)}"
    return None


def unwired(v: Variable, value: float) -> str | None:
    """A question about the input `v` if `value` is outside its range, or None. Importers write zeros where nothing is
    wired, and some do before they have the values."""
    return f"{v.name} = {with_unit(v, value)}: is it wired?" if out_of_range(v, value) else None


def startable(v: Variable) -> str:
    """With which values of the input `v` the model starts."""
    low, high = (f"{infinite if limit is None else v.displayed(limit):.6g}"
                 for infinite, limit in ((-inf, v.minimum), (inf, v.maximum)))
    return f"It starts with {v.name} from {low} to {high}{v.unit_suffix}, set before initialisation ends"
