"""Loops that are settled before the start: gains that are wired to each other, y = x1 + d u."""
from functools import partial

import pytest
import small

from cosim.errors import RunError
from cosim.master.fly import fly
from cosim.master.system import Component, Connection, System


@pytest.fixture(scope="module")
def build(tmp_path_factory):
    return partial(small.build, tmp_path_factory.mktemp("small"), direct=True)


def started(system):
    """The first row, by name."""
    flight = fly(system, 0.1, 0.1)
    return {name: float(flight[name][0]) for name in flight}


def two(fmu, first, second, x1=1.0):
    parts = (Component("a", fmu, {"d": first, "x1": x1}), Component("b", fmu, {"d": second}))
    return System(parts, (Connection("a.y", "b.u"), Connection("b.y", "a.u")))


@pytest.mark.parametrize("x1", [1.0, 1e9, -1e-9])
def test_a_loop_that_needs_many_passes_is_settled_to_the_last_digits(build, x1):
    found = started(two(build(), 0.8, 0.8, x1))
    allowed = 1e-12 * max(1.0, abs(x1))
    assert found["a.y"] == pytest.approx(x1 / 0.36, rel=0, abs=allowed)
    assert found["b.y"] == pytest.approx(0.8 * x1 / 0.36, rel=0, abs=allowed)


def test_a_loop_that_needs_too_many_says_how_many(build):
    with pytest.raises(RunError, match=r"^The initial values do not settle: a\.y, b\.y still change after 200 passes"):
        started(two(build(), 0.99, 0.99))


def test_a_loop_is_settled_when_all_of_it_is(build):
    """p0 shows the same from the first pass on; what it shows reaches p2 in the second and p1 in the third."""
    fmu = build()
    parts = (Component("p0", fmu, {"x1": 1.0}), Component("p1", fmu, {"d": 1.0}), Component("p2", fmu, {"d": 1.0}))
    links = (Connection("p1.y", "p0.u"), Connection("p2.y", "p1.u"), Connection("p0.y", "p2.u"))
    found = started(System(parts, links))
    assert [found[f"{name}.y"] for name in ("p0", "p1", "p2")] == [1.0, 1.0, 1.0]


def test_a_loop_may_have_texts_in_it(build):
    fmu = build()
    links = [Connection(f"{a}.{n}_out", f"{b}.{n}_in") for a, b in ("ab", "ba") for n in ("text", "whole", "truth")]
    assert fly(System((Component("a", fmu), Component("b", fmu)), links), 0.1, 0.2).finished


def test_factor_and_offset_hold_in_the_loop(build):
    fmu = build()
    parts = (Component("a", fmu, {"d": 0.5, "x1": 1.0}), Component("b", fmu, {"d": 1.0}))
    found = started(System(parts, (Connection("a.y", "b.u", 2.0, 3.0), Connection("b.y", "a.u", 0.25, -1.0))))
    assert found["a.y"] == pytest.approx((1 + 0.5 * (0.75 - 1)) / 0.75, abs=1e-12)
    assert found["b.y"] == pytest.approx(2 * found["a.y"] + 3, abs=1e-12)
