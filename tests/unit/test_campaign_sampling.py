"""Draws of run k: from the seed and k alone, and distributed as the file says."""
import numpy as np
import pytest

from cosim.campaign.sampling import Sampler, keeps_signals, mixing, quantile
from cosim.campaign.spec import Choice, Correlation, LogNormal, Normal, Uniform

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


@pytest.mark.parametrize("sampling", ["random", "sobol"])
def test_more_runs_do_not_change_the_first_ones(sampling):
    assert np.array_equal(Sampler(sampling, 5, 8, 3).uniforms(7), Sampler(sampling, 5, 800, 3).uniforms(7))


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
    values = np.array([quantile(distribution, u) for u in POINTS])
    assert values.mean() == pytest.approx(mean, rel=5e-3) and values.std() == pytest.approx(std, rel=2e-2)


def test_a_cut_off_normal_stays_inside():
    cut = Normal(distribution="normal", mean=0, std=1, low=-1, high=0.5)
    values = [quantile(cut, u) for u in (0.0, 1e-9, 0.5, 1 - 1e-9, 1.0)]
    assert values == sorted(values) and values[0] == -1 and values[-1] == 0.5


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
    assert not any(keeps_signals(1, k, 0.0) for k in range(50)) and all(keeps_signals(1, k, 1.0) for k in range(50))
