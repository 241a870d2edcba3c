"""The rule that ends a campaign: its intervals keep their confidence although the outcomes decide when it ends."""
from itertools import pairwise

import numpy as np
import pytest

from cosim.campaign.sequential import Sequence, looks
from cosim.campaign.statistics import interval


def stops(p, half_width, repetitions, most, seed=1, confidence=0.95):
    """(runs at the stop, whether the interval there covers p, whether the interval of any look up to then did not)."""
    random, sequence = np.random.default_rng(seed), Sequence(half_width)
    successes, before = np.zeros(repetitions, int), 0
    at, covered = np.zeros(repetitions, int), np.ones(repetitions, bool)
    ever = np.zeros(repetitions, bool)
    flying = np.arange(repetitions)
    for look in looks(0, most):
        successes[flying] += random.binomial(look - before, p, len(flying))
        before = look
        values, back = np.unique(successes[flying], return_inverse=True)
        low, high = (end[back] for end in sequence.intervals(values, np.full_like(values, look), confidence))
        at[flying], covered[flying] = look, (low <= p) & (p <= high)
        ever[flying] |= ~covered[flying]
        flying = flying[(high - low) / 2 > half_width]
        if not len(flying):
            break
    return at, covered, ever


@pytest.mark.parametrize("p", [0.0, 0.03, 0.5, 0.9])
def test_the_interval_at_the_stop_covers_the_probability(p):
    at, covered, _ = stops(p, 0.1, 200, 10_000)
    assert covered.mean() > 0.95 and at.max() < 400


@pytest.mark.slow
@pytest.mark.parametrize("half_width", [0.1, 0.03, 0.01])
@pytest.mark.parametrize("p", [0.0, 0.002, 0.01, 0.03, 0.1, 0.3, 0.5, 0.8, 0.95, 0.99, 0.998, 1.0])
def test_ten_thousand_times_the_interval_at_the_stop_covers_the_probability(p, half_width):
    at, covered, ever = stops(p, half_width, 10_000, 100_000)
    print(f"\np = {p:5.3f}, half-width {half_width:5.3f}: {at.mean():8.0f} runs, covered "
          f"{100 * covered.mean():6.2f} %, at all looks {100 * (1 - ever.mean()):6.2f} %")
    assert ever.mean() <= 0.05 and covered.mean() >= 0.95


def test_the_confidence_is_that_which_is_asked_for():
    shares = [stops(0.4, 0.1, 200, 1000, confidence=c)[2].mean() for c in (0.5, 0.9)]
    assert 0.1 < shares[0] <= 0.5 and 0 < shares[1] <= 0.1  # some are wrong, and not more than said


@pytest.mark.parametrize("half_width", [0.2, 0.01, 0.001])
def test_the_interval_holds_all_candidates_that_are_not_excluded_and_no_other(half_width):
    sequence = Sequence(half_width)
    rare = np.logspace(-12, -2, 400)
    p = np.unique([*rare, *np.linspace(0.01, 0.99, 500), *(1 - rare)])[:, None]
    for runs in (10, 300, 20_000):
        successes = np.unique(np.round([0, 1, 2, 5, *np.linspace(0, runs, 12)]))[None]
        inside = sequence.log_ratio(p, successes, np.full_like(successes, runs)) < np.log(20)
        low, high = sequence.intervals(successes[0], np.full_like(successes[0], runs), 0.95)
        assert np.array_equal(inside, (low < p) & (p < high))


def test_the_interval_is_wider_than_one_for_a_fixed_number_of_runs_and_holds_the_share():
    for successes, runs in ((0, 10), (3, 10), (10, 10), (60, 2000), (1990, 2000)):
        low, high = Sequence(0.02).interval(successes, runs)
        fixed = interval(successes, runs)
        assert 0 <= low <= fixed[0] <= successes / runs <= fixed[1] <= high <= 1
        mirrored = Sequence(0.02).interval(runs - successes, runs)
        assert (1 - high, 1 - low) == pytest.approx(mirrored, abs=1e-12)


@pytest.mark.parametrize("share", [0.0, 0.02, 0.5, 0.97, 1.0])
def test_it_is_narrow_enough_once_the_half_width_is_as_was_asked_for(share):
    found = [Sequence(0.1).interval(round(share * n), n, 0.9) for n in range(5, 220, 31)]
    assert [Sequence(0.1).narrow(round(share * n), n, 0.9) for n in range(5, 220, 31)] == [
        (high - low) / 2 <= 0.1 for low, high in found]


def test_nothing_is_known_without_runs_and_much_after_many():
    assert Sequence(0.1).interval(0, 0) == (0.0, 1.0)
    low, high = Sequence(0.001).interval(9_000_000, 10_000_000)
    assert low < 0.9 < high and high - low < 1e-3


def test_looks_are_the_same_wherever_one_begins():
    every = list(looks(0, 5000))
    assert every[:3] == [10, 11, 12] and all(b - a <= max(1, a / 50) for a, b in pairwise(every))
    assert [n for first in range(0, 5000, 7) for n in looks(first, min(first + 7, 5000))] == every
