"""The sensors' noise: normal numbers, white, and independent from channel to channel and from seed to seed.

A statistic is judged by its own chance: z is its deviation over its standard deviation, were the numbers ideal.
"""
from functools import cache
from types import SimpleNamespace

import casadi
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ahv_plant_fmu.noise import LARGEST_SEED, samples
from fmus import floats, symbols

ARRAYS = SimpleNamespace(floor=np.floor, sqrt=np.sqrt, where=np.where)
CHANNELS = 5
SEEDS = (1, 2, 1000, 2**25, int(LARGEST_SEED))


def drawn(seed, count):
    """(channels, steps) samples of one seed."""
    return np.array(samples(ARRAYS, float(seed), np.arange(float(count)), CHANNELS))


def correlations(first, others):
    """Of one sequence with each of others, all channels and steps one after the other."""
    def whitened(values):
        values = values.ravel() - values.mean()
        return values / np.linalg.norm(values)

    return np.array([whitened(first) @ whitened(other) for other in others])


@pytest.fixture(scope="module", params=SEEDS)
def long(request):
    return drawn(request.param, 200_000)


@pytest.mark.slow
def test_a_thousand_pairs_of_neighbouring_seeds_do_not_correlate():
    n, kept, found = 8_000, drawn(1, 8_000), []
    for seed in range(2, 1002):
        following = drawn(seed, n)
        found += list(correlations(kept, [following]))
        kept = following
    assert np.abs(found).max() < 0.02
    assert np.std(found) * np.sqrt(n * CHANNELS) == pytest.approx(1.0, abs=0.1)  # and what there is, is chance


@pytest.mark.parametrize("seed", [1, 100, 2**24, 2**25 - 1, 123_456_789])
def test_seeds_that_are_multiples_or_differ_in_one_bit_do_not_correlate(seed):
    others = [2 * seed, 3 * seed, *(seed ^ 2**bit for bit in range(31)), int(LARGEST_SEED) - seed]
    assert np.abs(correlations(drawn(seed, 12_000), [drawn(s, 12_000) for s in others])).max() < 0.02


def test_moments_are_those_of_the_normal_distribution(long):
    x, n = long.ravel(), long.size
    z = [x.mean() * np.sqrt(n), (x.var() - 1) * np.sqrt(n / 2), (x**3).mean() * np.sqrt(n / 15),
         ((x**4).mean() - 3) * np.sqrt(n / 96)]
    assert np.abs(z).max() < 4, z
    for beyond, share in ((1.0, 0.3173105), (2.0, 0.0455003), (3.0, 0.0026998), (4.0, 6.334e-5)):
        assert abs((np.abs(x) > beyond).sum() - n * share) < 4 * np.sqrt(n * share), beyond


def test_channels_are_independent(long):
    n = long.shape[1]
    for values in (long, long**2):
        at_once = np.corrcoef(values)[np.triu_indices(CHANNELS, 1)]
        assert np.abs(at_once).max() * np.sqrt(n) < 4
        next_step = np.corrcoef(values[:, 1:], values[:, :-1])[:CHANNELS, CHANNELS:]
        assert np.abs(next_step).max() * np.sqrt(n) < 4


def test_the_spectrum_is_flat(long):
    n, bands = long.shape[1], 100
    for channel in long:
        power = np.abs(np.fft.rfft(channel)[1:-1]) ** 2 / n
        of_band = power[:power.size // bands * bands].reshape(bands, -1)
        assert np.abs(of_band.mean(axis=1) - 1).max() * np.sqrt(of_band.shape[1]) < 4.5


@cache
def traced():
    """`samples` through CasADi."""
    seed, step = casadi.SX.sym("seed"), casadi.SX.sym("step")
    return casadi.Function("samples", [seed, step], [casadi.vertcat(*samples(symbols, seed, step, CHANNELS))])


@given(st.integers(1, int(LARGEST_SEED)), st.integers(-10**9, 10**12))
def test_both_backends_draw_the_same_bits(seed, step):
    assert traced()(seed, step).full().ravel().tolist() == samples(floats, float(seed), float(step), CHANNELS)


def test_of_a_seed_the_whole_part_counts():
    assert samples(floats, 7.9, 3.0, CHANNELS) == samples(floats, 7.0, 3.0, CHANNELS)
    assert samples(floats, 8.0, 3.0, CHANNELS) != samples(floats, 7.0, 3.0, CHANNELS)


def test_fewer_channels_are_the_first_of_more():
    assert samples(floats, 7.0, 3.0, 3) == samples(floats, 7.0, 3.0, 4)[:3]
