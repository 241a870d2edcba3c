"""Finds what occurs more than once: half of the rules of section 2.2 say that something is unique."""
from collections import Counter
from collections.abc import Hashable, Iterable
from typing import TypeVar

T = TypeVar("T", bound=Hashable)


def repeated(items: Iterable[T]) -> list[tuple[T, int]]:
    """Each item that occurs more than once, with how often, in the order of first occurrence."""
    return [(item, count) for item, count in Counter(items).items() if count > 1]
