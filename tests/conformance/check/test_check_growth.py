"""What the check takes for a leak: growth that does not end."""
import ctypes
from itertools import count
from types import SimpleNamespace

import pytest

from cosim.conformance.probes import memory

BLOCK = 64  # bytes


@pytest.mark.parametrize("lives, found", [(10, False), (400, False), (10**6, True)])
def test_a_cache_that_fills_is_no_leak(lives, found, monkeypatch):
    """Something keeps a block for each of its first lives; what else this process keeps or frees is left out."""
    lived, said = count(), []
    held = [0]
    monkeypatch.setattr(memory, "allocated_bytes", lambda: held[0])
    monkeypatch.setattr(memory, "resident_bytes", lambda: 0)

    def life():
        held[0] += BLOCK * (next(lived) < lives)

    job = SimpleNamespace(cycles=100, patience=30.0)
    grown, done = memory.growth(SimpleNamespace(job=job, skip=lambda *words: said.append(words)), life, "lives")
    assert said == []
    assert (grown, done) == (1000 * BLOCK * found, 1000 if lives > 100 else 100)


@pytest.mark.skipif(memory.allocated_bytes() == 0, reason="this C library does not tell what it has given out")
def test_blocks_that_the_c_library_keeps_for_later_are_not_counted():
    """They were: a full cache of glibc's looked like a leak of 38 to 76 bytes for each of 200 lives."""
    libc = ctypes.CDLL(None)
    libc.malloc.restype, libc.free.argtypes = ctypes.c_void_p, (ctypes.c_void_p,)
    sizes = range(24, 1033, 16)
    memory.allocated_bytes()
    before = [libc.malloc(size) for size in sizes for _ in range(16)]  # more than the cache holds
    held = memory.allocated_bytes()
    for block in before:
        libc.free(block)
    given_back = held - memory.allocated_bytes()
    assert given_back == pytest.approx(16 * sum(size + 8 for size in sizes), rel=0.02)
