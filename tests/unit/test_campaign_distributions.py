"""The distributions of a campaign file: quantiles as scipy's, and what is refused."""
import numpy as np
import pytest
from pydantic import TypeAdapter, ValidationError
from scipy import stats

from cosim.campaign.distributions import Scalar

PROBABILITIES = (0.0, 1e-9, 0.003, 0.25, 0.5, 0.8, 0.999, 1 - 1e-9, 1.0)
MEASURED = [3.0, -1.0, 4.0, 1.5, 4.0]


def made(distribution, **fields):
    """A distribution as a campaign file says it."""
    return TypeAdapter(Scalar).validate_python({"distribution": distribution, **fields})


def scipy(name, low=None, high=None, **parameters):
    """One of scipy's distributions."""
    return made("scipy", name=name, parameters=parameters, low=low, high=high)


@pytest.mark.parametrize("one,other", [
    (made("triangular", low=-1, mode=2, high=5), stats.triang(0.5, -1, 6)),
    (made("triangular", low=0, mode=0, high=2), stats.triang(0, 0, 2)),
    (made("triangular", low=0, mode=2, high=2), stats.triang(1, 0, 2)),
    (made("uniform", low=-1, high=2), stats.uniform(-1, 3)),
    (made("normal", mean=3, std=2), stats.norm(3, 2)),
    (made("normal", mean=3, std=2, low=2), stats.truncnorm(-0.5, np.inf, 3, 2)),
    (made("log-normal", median=2, sigma=0.5), stats.lognorm(0.5, scale=2)),
    (scipy("beta", a=2, b=5, loc=1, scale=3), stats.beta(2, 5, 1, 3)),
    (scipy("gamma", a=2.5, scale=0.1), stats.gamma(2.5, scale=0.1)),
    (scipy("weibull_min", c=1.5, scale=300), stats.weibull_min(1.5, scale=300)),
    (scipy("expon", scale=4), stats.expon(scale=4)),
    (scipy("gumbel_r", loc=10, scale=2), stats.gumbel_r(10, 2)),
    (scipy("poisson", mu=3.5), stats.poisson(3.5)),
    (scipy("norm", loc=7, scale=2, low=4, high=9), stats.truncnorm(-1.5, 1, 7, 2)),
    (scipy("expon", scale=2, low=1), stats.expon(loc=1, scale=2)),
    (scipy("expon", scale=2, high=6), stats.truncexpon(3, scale=2)),
    (scipy("pareto", b=2, low=1, high=50), stats.truncpareto(2, 50)),
])
def test_quantiles_are_scipy_s(one, other):
    assert [one.quantile(u) for u in PROBABILITIES] == pytest.approx(list(other.ppf(PROBABILITIES)), rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("low,high", [(1.0, 4.0), (None, 2.0), (9.0, None), (500.0, 600.0), (1e-4, 2e-4)])
def test_a_log_normal_cut_off_has_the_probabilities_of_the_whole_one(low, high):
    cut, whole = made("log-normal", median=2, sigma=0.8, low=low, high=high), stats.lognorm(0.8, scale=2)
    a, b = low or 0.0, high or np.inf
    for u in (0.01, 0.5, 0.99):
        x = cut.quantile(u)
        share = (whole.sf(a) - whole.sf(x)) / (whole.sf(a) - whole.sf(b)) if a > 2 else \
            (whole.cdf(x) - whole.cdf(a)) / (whole.cdf(b) - whole.cdf(a))
        assert share == pytest.approx(u, rel=1e-8)
    assert [cut.quantile(0.0), cut.quantile(1.0)] == pytest.approx([a, b], rel=1e-15)
    assert a <= cut.quantile(0.0) and cut.quantile(1.0) <= b


@pytest.mark.parametrize("low,high", [(40, 42), (-42, -40)])
def test_a_cut_far_out_in_a_tail_keeps_its_shape(low, high):
    """There the density falls like exp(-|x|), and the probabilities are below 1e-17: of that no double near 1 knows."""
    one, near, sign = scipy("logistic", low=low, high=high), min(low, high, key=abs), np.sign(low)
    values = [one.quantile(u) for u in (0.0, 0.25, 0.5, 0.75, 1.0)]
    assert values == sorted(set(values)) and (values[0], values[-1]) == (low, high)
    assert values[2] == pytest.approx(near - sign * np.log((1 + np.exp(-2)) / 2), abs=1e-9)


def test_whole_numbers_cut_off_keep_their_probabilities():
    one, whole = scipy("poisson", mu=3, low=2, high=5), stats.poisson(3)
    values = [one.quantile(u) for u in (np.arange(40_000) + 0.5) / 40_000]
    kinds, counts = np.unique(values, return_counts=True)
    shares = whole.pmf([2, 3, 4, 5]) / whole.pmf([2, 3, 4, 5]).sum()
    assert kinds.tolist() == [2, 3, 4, 5] and counts / 40_000 == pytest.approx(shares, abs=1e-4)
    assert one.single and not scipy("expon").single


@pytest.mark.parametrize("interpolated,method", [(False, "inverted_cdf"), (True, "linear")])
def test_measured_numbers_have_numpy_s_quantiles(interpolated, method):
    one = made("empirical", values=MEASURED, interpolated=interpolated)
    for u in (0.0, 0.1, 0.33, 0.5, 0.77, 0.99, 1.0):
        assert one.quantile(u) == pytest.approx(np.quantile(MEASURED, u, method=method), rel=1e-15)
    assert one.extremes() == ([-1.0, 4.0] if interpolated else [-1.0, 1.5, 3.0, 4.0]) and one.single != interpolated
    assert made("empirical", values=[7], interpolated=interpolated).quantile(0.4) == 7


@pytest.mark.parametrize("one,values", [
    (scipy("beta", a=2, b=3), [0, 1]), (scipy("beta", a=2, b=3, low=0.2), [0.2, 1]), (scipy("expon"), [np.log(2)]),
    (scipy("expon", high=3), [0, 3]), (scipy("norm", low=-1), [stats.truncnorm(-1, np.inf).median()]),
    (made("log-normal", median=2, sigma=1, low=1, high=3), [1, 3]), (made("triangular", low=1, mode=1, high=2), [1, 2]),
])
def test_the_ends_of_what_is_bounded_are_to_be_allowed_and_else_the_middle(one, values):
    assert one.extremes() == pytest.approx(values)


@pytest.mark.parametrize("one,levels", [
    (made("uniform", low=0.2, high=0.6, points=9), [0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5, 0.55, 0.6]),
    (made("uniform", low=1e-300, high=1e300, points=2), [1e-300, 1e300]),
    (made("integer", low=-1, high=2), [-1.0, 0.0, 1.0, 2.0]), (made("choice", values=["b", "a"]), ["b", "a"]),
])
def test_the_levels_of_a_grid_are_the_decimals_that_a_user_would_write(one, levels):
    assert one.levels() == levels


@pytest.mark.parametrize("fields,reason", [
    ({"distribution": "scipy", "name": "weibul_min"}, "scipy.stats has no distribution weibul_min; did you mean weibu"),
    ({"distribution": "scipy", "name": "ttest_ind"}, "scipy.stats has no distribution ttest_ind"),
    ({"distribution": "scipy", "name": "beta", "parameters": {"a": 2}}, "beta needs the parameter b"),
    ({"distribution": "scipy", "name": "beta", "parameters": {"a": 2, "b": 1, "c": 1}},
     "beta has no parameter c; there are a, b, loc, scale"),
    ({"distribution": "scipy", "name": "poisson", "parameters": {"mu": 2, "scale": 1}},
     "poisson has no parameter scale; there are mu, loc"),
    ({"distribution": "scipy", "name": "beta", "parameters": {"a": -2, "b": 1}}, "beta does not allow a = -2, b = 1"),
    ({"distribution": "scipy", "name": "norm", "parameters": {"scale": 0}}, "norm does not allow scale = 0"),
    ({"distribution": "scipy", "name": "norm", "low": 2, "high": 1}, "low must be below high"),
    ({"distribution": "scipy", "name": "beta", "parameters": {"a": 2, "b": 1}, "low": 1.5}, "beta has no values"),
    ({"distribution": "triangular", "low": 0, "mode": 3, "high": 2}, "mode must lie between low and high"),
    ({"distribution": "log-normal", "median": 1, "sigma": 1, "low": 0}, "greater than 0"),
    ({"distribution": "empirical"}, "either values, or a file and its column, is wanted"),
    ({"distribution": "empirical", "file": "a.csv"}, "either values, or a file and its column, is wanted"),
    ({"distribution": "empirical", "values": [1], "file": "a.csv", "column": "x"}, "either values, or a file"),
    ({"distribution": "empirical", "values": [1, float("nan")]}, "finite number"),
])
def test_what_is_no_distribution_is_refused(fields, reason):
    with pytest.raises(ValidationError, match=reason):
        made(**fields)


@pytest.mark.parametrize("one,reason", [
    (made("uniform", low=0, high=1), "points is missing"), (made("normal", mean=0, std=1), "a grid takes values"),
    (made("choice", values=[1, 2], weights=[1, 2]), "weights mean nothing in a grid"),
    (made("choice", values=[1, 1]), "a value is given twice"),
    (made("integer", low=0, high=10**7), "at most 1,000,000"),
])
def test_what_has_no_levels_is_refused_in_a_grid(one, reason):
    with pytest.raises(ValueError, match=reason):
        one.levels()
