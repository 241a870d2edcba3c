"""Rare failures: estimates against exact probabilities, and what cannot be estimated."""
import sys

import numpy as np
import pytest
from scipy.stats import norm

from cosim.campaign.rare import Level, by_families, estimate
from cosim.campaign.rare_rules import whole_tasks
from cosim.campaign.spec import Rare
from cosim.errors import UsageError

METHODS = ("subset-simulation", "cross-entropy")


def linear(_, z):
    """The margin is 0 on a plane 3.5 standard deviations away."""
    return 3.5 - z.sum(axis=1) / np.sqrt(z.shape[1])


@pytest.mark.parametrize("method", METHODS)
def test_a_plane_in_five_dimensions_has_its_exact_probability(method):
    found = estimate(Rare(method=method, runs_per_level=2000), 5, 1, linear)
    exact = norm.sf(3.5)
    assert abs(found.probability / exact - 1) < 3 * found.variation < 0.75
    assert found.interval[0] < exact < found.interval[1]
    assert found.runs == len(found.margins) == 2000 * len(found.levels) <= 10_000
    assert found.plain_runs == pytest.approx((1 - found.probability) / (found.probability * found.variation**2))
    assert found.plain_runs > 10 * found.runs
    thresholds = [level.threshold for level in found.levels]
    assert thresholds == sorted(thresholds, reverse=True) and thresholds[-1] == 0 < thresholds[-2]


@pytest.mark.parametrize("method", METHODS)
def test_the_same_seed_gives_the_same_points_and_another_seed_others(method):
    first, again, other = (estimate(Rare(method=method, runs_per_level=200), 3, seed, linear) for seed in (7, 7, 8))
    assert first.points.tobytes() == again.points.tobytes() and first.probability == again.probability
    assert first.points[:200].tobytes() != other.points[:200].tobytes()


def test_the_variation_is_that_of_families():
    """The four of ten runs up to 3 begin chains of two; a step beyond 3 stays where it was. Of the last level's
    failures one is of the first family, two are of the second, one is of the fourth."""
    margins = np.array([9, 1, 2, 8, 2.5, 7, 3, 9, 9, 9, 4, -1, 5, 0, -2, -3, 6, 2.0])
    levels = (Level(0, 10, 3.0, 0.4, 0.0, ()), Level(10, 18, 0.0, 0.2, 0.5, ()))
    assert by_families(margins, levels, 4) ** 2 == pytest.approx((1 + 4 + 1) / 4**2 - 1 / 10)


def test_what_fails_often_needs_one_level_of_plain_runs():
    found = estimate(Rare(), 2, 1, lambda _, z: 0.5 - z[:, 0])
    assert len(found.levels) == 1 and found.probability == pytest.approx((found.margins <= 0).mean())
    assert found.plain_runs == pytest.approx(1000)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("margins,reason", [
    (lambda _, z: np.full(len(z), 5.0), "one and the same margin, 5"),
    (lambda _, z: np.where(z[:, 0] > 6, -1.0, 5.0), "one and the same margin, 5"),   # a cliff that nothing announces
    (lambda _, z: 1 + np.exp(-z[:, 0]), "no failure was reached within most_levels = 4"),
    (lambda _, z: np.full(len(z), np.nan), "one and the same margin"),               # no run was judged
])
def test_where_nothing_leads_to_a_failure_there_is_no_estimate_but_the_reason(method, margins, reason):
    found = estimate(Rare(method=method, runs_per_level=200, most_levels=4), 2, 1, margins)
    assert found.probability is found.variation is found.plain_runs is None
    assert reason in found.reason and found.interval == (0, 1)


@pytest.mark.parametrize("method", METHODS)
def test_how_far_a_failure_lies_beyond_its_limit_does_not_matter(method):
    ways = [lambda _, z: linear(0, z), lambda _, z: np.where((m := linear(0, z)) <= 0, -np.inf, m),
            lambda _, z: np.where((m := linear(0, z)) <= 0, -1e-9, m)]
    found = [estimate(Rare(method=method, runs_per_level=500), 3, 2, margins) for margins in ways]
    assert found[0].probability == found[1].probability == found[2].probability > 0


def test_a_last_level_that_failed_as_a_whole_adds_no_variance():
    """OpenTURNS finds a negative variance of its own there."""
    found = estimate(Rare(), 2, 65, lambda _, z: 3.2 - np.abs(z[:, 0]))
    assert found.levels[-1].threshold == 0 and found.levels[-1].probability == pytest.approx(1e-3, rel=0.02)
    assert found.interval[0] < 2 * norm.sf(3.2) < found.interval[1]


def test_runs_that_were_not_judged_are_no_failures():
    found = estimate(Rare(), 2, 1, lambda _, z: np.where(z[:, 1] > 0, np.nan, 3 - z[:, 0]))
    assert found.interval[0] < norm.sf(3) / 2 < found.interval[1]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("error", [KeyboardInterrupt, ZeroDivisionError])
def test_an_error_of_the_system_comes_through_and_nothing_is_printed(method, error, capfd):
    def margins(first, z):
        if first >= 200:
            raise error("here")
        return linear(first, z)

    with pytest.raises(error, match="here"):
        estimate(Rare(method=method, runs_per_level=200), 2, 1, margins)
    assert capfd.readouterr() == ("", "")


def test_the_random_numbers_of_others_are_left_alone():
    import openturns

    openturns.RandomGenerator.SetSeed(5)
    expected = openturns.RandomGenerator.Generate()
    openturns.RandomGenerator.SetSeed(5)
    estimate(Rare(runs_per_level=100), 2, 1, linear)
    assert openturns.RandomGenerator.Generate() == expected


def test_without_openturns_one_sentence_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "openturns", None)
    with pytest.raises(UsageError, match="rare needs OpenTURNS, which is not installed: install the extra `rare`"):
        estimate(Rare(), 2, 1, linear)


@pytest.mark.parametrize("method,wanted", [(m, w) for m in METHODS for w in (1, 7, 60, 1000)])
def test_tasks_fill_blocks_exactly(method, wanted):
    rare = Rare(method=method, runs_per_level=1010)
    size = 101 if method == "subset-simulation" else 1010
    assert size % whole_tasks(rare, wanted) == 0 and whole_tasks(rare, wanted) <= wanted


CASES = {  # name: (dimensions, margins, exact probability)
    "a plane, five dimensions": (5, linear, norm.sf(3.5)),
    "two regions": (2, lambda _, z: 3.2 - np.abs(z[:, 0]), 2 * norm.sf(3.2)),
    "a cliff": (3, lambda _, z: np.where(z[:, 0] > 3, -1.0, 5 - z[:, 0]), norm.sf(3.0)),
}
COVERED = {  # of 200 intervals at least: of subset simulation's bound 95 %, of cross-entropy's what docs/ say
    "subset-simulation": dict.fromkeys(CASES, 0.95),
    "cross-entropy": {"a plane, five dimensions": 0.87, "two regions": 0.87}}


@pytest.mark.slow
@pytest.mark.parametrize("method,case", [(m, c) for m in COVERED for c in COVERED[m]])
def test_intervals_cover_the_exact_probability(method, case):
    dimensions, margins, exact = CASES[case]
    found = [estimate(Rare(method=method), dimensions, seed, margins) for seed in range(200)]
    there = [f for f in found if f.probability]
    covered = np.mean([f.interval[0] <= exact <= f.interval[1] for f in there])
    shares = np.array([f.probability / exact for f in there])
    said = np.median([f.variation for f in there])
    print(f"{method}, {case}: {len(there)} estimates, {100 * covered:.1f} % covered, mean / exact {shares.mean():.3f}, "
          f"variation {shares.std():.3f}, said {said:.3f}, plain runs saved "
          f"{np.median([f.plain_runs / f.runs for f in there]):.0f}")
    assert len(there) == 200 and covered >= COVERED[method][case]
    assert abs(shares.mean() - 1) < 0.08 and shares.std() < (1.3 if method == "subset-simulation" else 1.5) * said
