"""Which comes first: groups of what needs each other, in the order of need."""
import random

from hypothesis import given
from hypothesis import strategies as st

from cosim.master.dependencies import looped, strongly_connected

GRAPHS = st.integers(1, 12).flatmap(lambda n: st.lists(st.tuples(st.integers(0, n - 1), st.integers(0, n - 1))).map(
    lambda edges: {i: [b for a, b in edges if a == i] for i in range(n)}))


def reached(needs, start):
    found, waiting = set(), [start]
    while waiting:
        for other in needs[waiting.pop()]:
            if other not in found:
                found.add(other)
                waiting.append(other)
    return found


@given(GRAPHS)
def test_groups_are_what_reaches_itself_around(needs):
    groups = strongly_connected(needs)
    assert sorted(n for g in groups for n in g) == sorted(needs)
    for group in groups:
        for a in group:
            around = {b for b in needs if b in reached(needs, a) and a in reached(needs, b)} | {a}
            assert around == set(group)


@given(GRAPHS)
def test_a_group_comes_after_all_that_it_needs(needs):
    place = {n: i for i, group in enumerate(strongly_connected(needs)) for n in group}
    assert all(place[b] <= place[a] for a in needs for b in needs[a])


def test_a_long_chain_is_no_matter():
    count = 5000
    names = list(range(count))
    random.Random(1).shuffle(names)
    needs = {i: [i + 1] if i + 1 < count else [] for i in names}
    assert [g[0] for g in strongly_connected(needs)] == list(reversed(range(count)))


def test_components_around_an_algebraic_loop():
    needs = {"a.y": ["a.u"], "a.u": ["b.y"], "b.y": ["b.u"], "b.u": ["a.y"], "c.u": ["a.y"], "c.y": ["c.u"]}
    assert looped(needs) == {"a", "b"}
    assert looped({**needs, "b.y": []}) == set()
