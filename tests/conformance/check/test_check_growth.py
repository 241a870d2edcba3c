"""What the check takes for a leak: growth that does not end."""
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
