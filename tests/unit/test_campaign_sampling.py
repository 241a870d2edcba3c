"""Draws of run k: from the seed and k alone, and distributed as the file says."""
import math
import tracemalloc
import warnings

import numpy as np
import pytest

from cosim.campaign.distributions import Choice, Integer, LogNormal, Normal, Uniform
from cosim.campaign.sampling import Draw, Sampler, keeps_signals, mixing
from cosim.campaign.spec import Correlation

UNIFORM = Uniform(distribution="uniform", low=-2, high=6)
POINTS = (np.arange(4000) + 0.5) / 4000


@pytest.mark.parametrize("sampling", ["random", "latin-hypercube", "sobol"])
def test_a_run_draws_the_same_alone_in_any_order_and_after_any_others(sampling):
    whole = [Sampler(sampling, 5, 64, 4).uniforms(k) for k in range(64)]
    back = Sampler(sampling, 5, 64, 4)
    for k in reversed(range(64)):
        assert np.array_equal(back.uniforms(k), whole[k])
    assert not np.array_equal(Sampler(sampling, 6, 64, 4).uniforms(3), whole[3])
    assert len({tuple(u) for u in whole}) == 64


@pytest.mark.parametrize("sampling", ["random", "latin-hypercube", "sobol"])
def test_the_points_of_a_task_are_those_of_its_runs(sampling):
    group = mixing(Correlation(draws=["c.a", "c.b"], coefficient=0.5), ["c.a", "c.b", "c.c"])
    sampler = Sampler(sampling, 5, 20, 3, (group,))
    assert np.array_equal(sampler.points(3, 11), [sampler.uniforms(k) for k in range(3, 11)])


@pytest.mark.parametrize("sampling", ["random", "sobol"])
def test_more_runs_do_not_change_the_first_ones(sampling):
    assert np.array_equal(Sampler(sampling, 5, 8, 3).uniforms(7), Sampler(sampling, 5, 800, 3).uniforms(7))


@pytest.mark.parametrize("seed,dimensions", [(1, 1), (5, 5), (2**63 - 1, 30)])
def test_a_part_of_a_sobol_sequence_is_that_part_of_the_whole(seed, dimensions):
    from scipy.stats import qmc

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        whole = qmc.Sobol(dimensions, rng=np.random.default_rng(seed)).random(1000)
    sampler = Sampler("sobol", seed, 1000, dimensions)
    for first, last in ((0, 1), (0, 1000), (1, 2), (1, 17), (511, 514), (999, 1000)):
        assert np.array_equal(sampler.points(first, last), whole[first:last])


def test_a_late_run_of_a_large_sobol_campaign_needs_no_memory():
    sampler = Sampler("sobol", 1, 4_000_000, 9)
    sampler.uniforms(0)  # what is imported and made once
    tracemalloc.start()
    point = sampler.uniforms(3_999_999)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert point.shape == (9,) and peak < 2e6


def test_a_latin_hypercube_has_one_run_in_each_stratum():
    points = np.array([Sampler("latin-hypercube", 1, 50, 3).uniforms(k) for k in range(50)])
    strata = np.sort((points * 50).astype(int), axis=0)
    assert np.array_equal(strata.T, [np.arange(50)] * 3)


@pytest.mark.parametrize("distribution,mean,std", [
    (UNIFORM, 2.0, 8 / 12**0.5),
    (Normal(distribution="normal", mean=3, std=2), 3.0, 2.0),
    (LogNormal(distribution="log-normal", median=2, sigma=0.5), 2 * np.exp(0.125),
     2 * np.exp(0.125) * np.expm1(0.25)**0.5),
    (Choice(distribution="choice", values=[0, 10], weights=[3, 1]), 2.5, 10 * (3 / 16)**0.5),
])
def test_quantiles_have_the_distribution_s_moments(distribution, mean, std):
    values = np.array([distribution.quantile(u) for u in POINTS])
    assert values.mean() == pytest.approx(mean, rel=5e-3) and values.std() == pytest.approx(std, rel=2e-2)


@pytest.mark.parametrize("distribution,quarter,middle,three_quarters", [
    (UNIFORM, 0.0, 2.0, 4.0),
    (Integer(distribution="integer", low=-1, high=2), 0.0, 1.0, 2.0),
    (Normal(distribution="normal", mean=3, std=2), 3 - 2 * 0.6744897501960817, 3.0, 3 + 2 * 0.6744897501960817),
    (LogNormal(distribution="log-normal", median=2, sigma=0.5), 2 * math.exp(-0.5 * 0.6744897501960817), 2.0,
     2 * math.exp(0.5 * 0.6744897501960817)),
    (Choice(distribution="choice", values=[3, 1, 2]), 3.0, 1.0, 2.0),
    (Choice(distribution="choice", values=[3, 1, 2], weights=[1, 0, 3]), 2.0, 2.0, 2.0),
])
def test_a_quantile_rises_with_its_probability(distribution, quarter, middle, three_quarters):
    assert [distribution.quantile(u) for u in (0.25, 0.5, 0.75)] == pytest.approx([quarter, middle, three_quarters])


def test_whole_numbers_are_all_equally_likely():
    values = [Integer(distribution="integer", low=-2, high=5).quantile(u) for u in POINTS]
    assert np.array_equal(np.unique(values, return_counts=True), [range(-2, 6), [500] * 8])
    assert [Integer(distribution="integer", low=-2, high=5).quantile(u) for u in (0.0, 1.0)] == [-2, 5]
    assert all(isinstance(x, float) for x in values)  # as the column of the results


def test_a_cut_off_normal_stays_inside():
    cut = Normal(distribution="normal", mean=0, std=1, low=-1, high=0.5)
    values = [cut.quantile(u) for u in (0.0, 1e-9, 0.5, 1 - 1e-9, 1.0)]
    assert values == sorted(values) and values[0] == -1 and values[-1] == 0.5
    assert values[2] == pytest.approx(-0.1889682322)
    rounded = Normal(distribution="normal", mean=2.64, std=2.68, low=-2.96, high=0.89)
    assert rounded.quantile(1.0) == 0.89  # not 0.8900000000000001


@pytest.mark.parametrize("low,high,middle", [
    (9, 10, 9.0757797137), (-10, -9, -9.0757797137), (9, None, 9.0757870651), (None, -9, -9.0757870651),
    (50, 60, 50.0138554869), (-60, -50, -50.0138554869), (-9, 10, 0.0),
])
def test_a_normal_cut_off_far_from_its_mean_keeps_its_shape(low, high, middle):
    cut = Normal(distribution="normal", mean=7, std=2, low=None if low is None else 7 + 2 * low,
                 high=None if high is None else 7 + 2 * high)
    assert (cut.quantile(0.5) - 7) / 2 == pytest.approx(middle, abs=1e-9)


def test_a_normal_cut_off_has_the_probabilities_of_its_density():
    from scipy.integrate import quad

    cut = Normal(distribution="normal", mean=7, std=2, low=25, high=27)

    def below(x):
        return quad(lambda t: math.exp(-(t * t - 81) / 2), 9, (x - 7) / 2)[0]

    for u in (0.01, 0.3, 0.9, 0.999):
        assert below(cut.quantile(u)) / below(27) == pytest.approx(u, abs=1e-9)


def test_a_draw_multiplies_its_nominal_value_and_a_period_becomes_a_frequency():
    assert Draw("a.x", ("a.x",), UNIFORM, factor=300.0).value(0.75) == 1200.0
    assert Draw("a.x", ("a.x",), UNIFORM, period=True).value(0.75) == pytest.approx(2 * math.pi / 4)
    assert Draw("a.x", ("a.x",), UNIFORM).extremes() == [-2.0, 6.0]
    assert Draw("a.x", ("a.x",), Integer(distribution="integer", low=1, high=9)).extremes() == [1.0, 9.0]
    assert Draw("a.x", ("a.x",), Normal(distribution="normal", mean=3, std=2, low=0, high=9)).extremes() == [0.0, 9.0]
    assert Draw("a.x", ("a.x",), Normal(distribution="normal", mean=3, std=2)).extremes() == [3.0]
    assert Draw("a.x", ("a.x",), LogNormal(distribution="log-normal", median=3, sigma=2)).extremes() == [3.0]
    words = Choice(distribution="choice", values=["p", "q", "r"], weights=[2, 0, 1])
    assert Draw("a.x", ("a.x",), words).extremes() == ["p", "r"]


@pytest.mark.parametrize("coefficient", [0.5, -0.5])
def test_a_matrix_correlates_the_draws_that_it_names_in_its_order(coefficient):
    from scipy.stats import norm

    matrix = [[1, coefficient, 0], [coefficient, 1, 0], [0, 0, 1]]
    group = mixing(Correlation(draws=["a.z", "a.x", "a.y"], matrix=matrix), ["a.x", "a.y", "a.z"])
    found = np.corrcoef(norm.ppf(Sampler("sobol", 2, 4096, 3, (group,)).points(0, 4096)).T)
    assert found == pytest.approx(np.array([[1, 0, coefficient], [0, 1, 0], [coefficient, 0, 1]]), abs=0.02)


@pytest.mark.parametrize("group,reason", [
    ({"draws": ["a.x", "b.x"], "coefficient": 0.5}, "b.x is not drawn; there are a.x, a.y"),
    ({"draws": ["a.x", "a.y"], "matrix": [[1, 0.5]]}, "2 rows of 2 numbers"),
    ({"draws": ["a.x", "a.y"], "matrix": [[1, 0.5], [0.4, 1]]}, "symmetric"),
    ({"draws": ["a.x", "a.y"], "matrix": [[1, 0.5], [0.5, 2]]}, "symmetric"),
    ({"draws": ["a.x", "a.y"], "matrix": [[1, float("nan")], [float("nan"), 1]]}, "symmetric"),
    ({"draws": ["a.x", "a.y"], "matrix": [[1, 1.5], [1.5, 1]]}, "negative eigenvalue -0.5"),
])
def test_what_can_be_no_correlation_is_refused(group, reason):
    with pytest.raises(ValueError, match=reason):
        mixing(Correlation(**group), ["a.x", "a.y"])


@pytest.mark.parametrize("coefficient", [-0.6, 0.0, 0.8, 1.0])
def test_correlated_draws_keep_their_own_distribution(coefficient):
    from scipy.stats import norm

    group = mixing(Correlation(draws=["a.x", "a.z"], coefficient=coefficient), ["a.x", "a.y", "a.z"])
    points = np.array([Sampler("random", 2, 1, 3, (group,)).uniforms(k) for k in range(3000)])
    scores = norm.ppf(points)
    assert np.corrcoef(scores[:, 0], scores[:, 2])[0, 1] == pytest.approx(coefficient, abs=0.05)
    assert abs(np.corrcoef(scores[:, 0], scores[:, 1])[0, 1]) < 0.05
    assert points.mean(axis=0) == pytest.approx(0.5, abs=0.02)


def test_the_share_of_runs_with_signals_is_chosen_by_run():
    chosen = [keeps_signals(1, k, 0.2) for k in range(2000)]
    assert 340 < sum(chosen) < 460 and chosen == [keeps_signals(1, k, 0.2) for k in range(2000)]
    draws = np.array([Sampler("random", 1, 1, 1).uniforms(k)[0] for k in np.flatnonzero(chosen)])
    assert 0.4 < draws.mean() < 0.6  # it has nothing to do with what the run draws
    assert not any(keeps_signals(1, k, 0.0) for k in range(50)) and all(keeps_signals(1, k, 1.0) for k in range(50))


def test_a_seed_draws_the_same_with_every_version():
    """Published rows can be flown again."""
    assert Sampler("random", 5, 8, 2).points(0, 2).tolist() == [[0.7337459554446363, 0.5905206445727093],
                                                               [0.8965164783651571, 0.5549668734028189]]
    assert Sampler("random", 5, 8, 2).uniforms(10**6).tolist() == [0.8711637955461395, 0.74245612142611]
