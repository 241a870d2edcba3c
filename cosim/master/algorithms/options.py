"""The options of algorithms: what they are called, their defaults, and how the word of a value is read."""
from collections.abc import Callable
from math import inf
from typing import Any

from ..quantities import is_number

MOST = 10**12   # of passes, or of ticks in a step
LEAST = 1e-15   # relative error
Options = dict[str, tuple[Any, Callable[[str], Any] | None]]  # name -> (default, reader); None: read by `method`


def whole(word: str) -> int:
    """A whole number from 1 on. Raises ValueError, which says so, for anything else."""
    if not (word.isdecimal() and 1 <= int(word[:20]) <= MOST):
        raise ValueError(f"a whole number from 1 to {MOST}")
    return int(word)


def positive(word: str) -> float:
    """A positive finite number. Raises ValueError, which says so, for anything else."""
    if not (is_number(word) and 0 < float(word) < inf):
        raise ValueError("a positive number")
    return float(word)


def tolerance(word: str) -> float:
    """An error that steps can be short enough for. Raises ValueError, which says so, for anything else."""
    if not (is_number(word) and LEAST <= float(word) < inf):
        raise ValueError(f"a number from {LEAST:g} on, since doubles have no more digits")
    return float(word)


def linear(word: str) -> bool:
    """How inputs are held through a step: constant, or by their last slope. Raises ValueError for another word."""
    if word not in ("constant", "linear"):
        raise ValueError("constant or linear")
    return word == "linear"


def names(word: str) -> list[str]:
    """Components in an order, joined by +."""
    return word.split("+")


HOLD: Options = {"hold": (False, linear)}
ORDER: Options = {"order": (None, names)}
