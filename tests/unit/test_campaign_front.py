"""What the order of runs decides: the stop, and whose signals are kept. However the runs come, it is the same."""
from itertools import pairwise

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.campaign.front import FAILED_BIT, GOOD_BIT, JUDGED_BIT, Front, stopping
from cosim.campaign.sequential import Sequence
from cosim.campaign.spec import Signals, StopWhen
from cosim.campaign.statistics import Results
from cosim.campaign.store import grouped

LAWS = ["one", "two"]
RULE = StopWhen(probability="altitude", half_width=0.1)
RNG = np.random.default_rng(4)
GOOD = RNG.random((700, 2)) < (0.9, 0.6)
STATES = np.where(GOOD, JUDGED_BIT | GOOD_BIT, JUDGED_BIT | FAILED_BIT).astype(np.uint8)


def shown(spans, most=12.0, rule=RULE):
    front = Front(LAWS, most, rule)
    for first, last in spans:
        front.add(first, STATES[first:last].ravel())
    return front


WHOLE = shown([(0, 700)])


def test_it_stops_at_the_first_look_where_all_laws_are_narrow_enough():
    assert 200 < WHOLE.stopped < 400
    sequence = Sequence(0.1)

    def narrow(n):
        return [sequence.narrow(int(s), n, 0.95) for s in GOOD[:n].sum(axis=0)]

    assert narrow(WHOLE.stopped) == [True, True] and narrow(WHOLE.stopped - WHOLE.stopped // 50 - 1) == [True, False]


@settings(max_examples=5)
@given(st.sets(st.integers(1, 699)), st.randoms())
def test_the_order_of_tasks_and_their_sizes_do_not_matter(cuts, random):
    edges = [0, *sorted(cuts), 700]
    spans = list(pairwise(edges))
    random.shuffle(spans)
    front = shown(spans)
    assert front.stopped == WHOLE.stopped
    without = shown(spans, rule=None)
    failed = {law: np.flatnonzero(~GOOD[:, i])[11] for i, law in enumerate(LAWS)}
    assert without.stopped is None and without.end == 700 and without.last_kept == failed


def test_nothing_is_decided_beyond_a_gap():
    front = shown([(0, 50), (100, 700)])
    assert (front.stopped, front.end) == (None, 50)
    front.add(50, STATES[50:100].ravel())
    assert front.stopped == WHOLE.stopped
    front.add(0, STATES[:50].ravel())  # known already
    assert front.stopped == WHOLE.stopped


def test_failures_up_to_the_last_that_counts_keep_their_signals():
    front = shown([(0, 700)], most=3.0, rule=None)
    for i, law in enumerate(LAWS):
        failed = np.flatnonzero(~GOOD[:, i])
        assert [front.keeps(int(run), law) for run in failed[:5]] == [True] * 3 + [False] * 2
    assert shown([(0, 700)], most=np.inf, rule=None).last_kept == {} == shown([(0, 20)], most=300.0).last_kept


@pytest.mark.parametrize("given,most", [(True, np.inf), (False, 0), (20, 20), (0, 0), (1, 1)])
def test_true_is_all_failures_and_a_number_the_first(given, most):
    assert Signals(failures=given).most_failures == most


@pytest.mark.parametrize("rule,most,wanted", [
    (None, 0, False), (None, np.inf, False), (None, 5, True), (RULE, 0, True)])
def test_rows_are_only_shown_where_their_order_decides(rule, most, wanted):
    assert Front(LAWS, most, rule).wanted is wanted


def test_only_runs_that_flew_can_keep_signals_and_only_judged_ones_count():
    statuses = ["finished", "finished", "departed", "timed-out", "error", "crashed"]
    rows = pa.table({"status": statuses, "success": [True] + [False] * 5, "success.altitude": [True] * 2 + [False] * 4})
    found = Front(["one"], 5, RULE).states(rows)
    assert [bool(s & JUDGED_BIT) for s in found] == [True] * 3 + [False] * 3
    assert [bool(s & GOOD_BIT) for s in found] == [True, True] + [False] * 4
    assert [bool(s & FAILED_BIT) for s in found] == [False, True, True, True, False, False]
    assert set(Front(["one"], 5, RULE).columns) == set(rows.column_names)


@settings(max_examples=30)
@given(st.lists(st.integers(0, 9), max_size=30), st.integers(1, 12))
def test_rows_come_in_groups_of_one_size_however_they_came(sizes, size):
    edges = np.cumsum([0, *sizes])
    tables = (pa.table({"x": np.arange(a, b)}) for a, b in pairwise(edges))
    found = list(grouped(tables, size))
    assert all(t.num_rows == size for t in found[:-1]) and all(t["x"].num_chunks == 1 for t in found)
    assert [x for t in found for x in t["x"].to_pylist()] == list(range(edges[-1]))


@pytest.mark.parametrize("runs,why", [(400, "the interval is narrow enough"),
                                      (40, "all runs of the file are flown, and the half-width is still 0.")])
def test_the_report_says_why_a_campaign_ended_and_the_rule_s_own_intervals(runs, why):
    table = pa.table({"run": range(runs), "controller": ["one"] * runs, "status": ["finished"] * runs,
                      "success": GOOD[:runs, 1], "success.altitude": GOOD[:runs, 0]})
    results = Results.of("one", table, "controller", Sequence(0.1))
    found = stopping(StopWhen(probability="altitude", half_width=0.1, confidence=0.99), [results])
    assert found["why"].startswith(why) and found["after_runs"] == runs and found["confidence"] == 0.99
    assert found["intervals"]["one"] == list(Sequence(0.1).interval(int(GOOD[:runs, 0].sum()), runs, 0.99))
    assert results.interval == Sequence(0.1).interval(int(GOOD[:runs, 1].sum()), runs, 0.95)
