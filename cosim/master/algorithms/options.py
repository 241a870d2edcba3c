"""The options of algorithms: what they are called, their defaults, and how the word of a value is read."""
from collections.abc import Callable
from typing import Any

Options = dict[str, tuple[Any, Callable[[str], Any] | None]]  # name -> (default, reader); None: read by `method`


def whole(word: str) -> int:
    """A whole number from 1 on. Raises ValueError for anything else."""
    if int(word) < 1:
        raise ValueError
    return int(word)


def positive(word: str) -> float:
    """A positive finite number. Raises ValueError for anything else."""
    if not 0 < float(word) < float("inf"):
        raise ValueError
    return float(word)


def linear(word: str) -> bool:
    """How inputs are held through a step: constant, or by their last slope. Raises KeyError for another word."""
    return {"constant": False, "linear": True}[word]


def names(word: str) -> list[str]:
    """Components in an order, joined by +."""
    return word.split("+")


HOLD: Options = {"hold": (False, linear)}
ORDER: Options = {"order": (None, names)}
