"""Texts, whole numbers and truths that change in flight go along their connections on every tick."""
from contextlib import closing
from functools import partial

import pytest
import small

from cosim.master import program as P
from cosim.master.algorithms.base import chosen_order, turn
from cosim.master.loaded import Master, open_files
from cosim.master.system import Component, Connection, System


@pytest.fixture(scope="module")
def build(tmp_path_factory):
    return partial(small.build, tmp_path_factory.mktemp("small"))


@pytest.mark.parametrize("plain", [False, True])
@pytest.mark.parametrize("apart", [False, True])
def test_what_changes_after_the_start_arrives(build, plain, apart):
    """Two of each kind, crossed: a's first text goes to c, b's to d."""
    kinds = {"text": ("first", "Höhe"), "whole": (5, -7), "truth": (True, False)}
    parts = [Component(name, build()) for name in "abcd"]
    links = [Connection(f"{a}.{kind}_out", f"{b}.{kind}_in") for kind in kinds for a, b in (("a", "d"), ("b", "c"))]
    system = System(parts, links)
    with open_files(system) as files, closing(Master(system, files, plain=plain, apart=apart)) as master:
        master.initialise(0.0, 1.0)
        tick = P.program(r for i in chosen_order(master, None) for r in turn(master, i, False))
        a, b, c, d = master.instances
        for k, instance in enumerate((a, b)):
            instance.set({f"{kind}_in": values[k] for kind, values in kinds.items()})
        master.run(tick, 0, 2, 0.0, 0.1)
        for receiver, k in ((d, 0), (c, 1)):
            assert receiver.get_any([f"{kind}_out" for kind in kinds]) == [values[k] for values in kinds.values()]
