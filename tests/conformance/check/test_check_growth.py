"""What the check takes for a leak: growth that does not end."""
import ctypes
from itertools import count
from types import SimpleNamespace

import pytest

from cosim.conformance.probes.memory import growth

LIBC = ctypes.CDLL(None)
LIBC.malloc.restype = ctypes.c_void_p
BLOCK = 64  # bytes


def bench(cycles, said):
    return SimpleNamespace(job=SimpleNamespace(cycles=cycles, patience=30.0), skip=lambda *words: said.append(words))


@pytest.mark.parametrize("lives, found", [(10, False), (400, False), (10**6, True)])
def test_a_cache_that_fills_is_no_leak(lives, found):
    said, lived = [], count()
    grown, done = growth(bench(100, said), lambda: next(lived) < lives and LIBC.malloc(BLOCK), "lives")
    assert bool(grown) == found and said == []
    assert done == (1000 if lives > 100 else 100)
    assert not found or BLOCK <= grown / done < 2 * BLOCK
