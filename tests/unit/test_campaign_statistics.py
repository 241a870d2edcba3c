"""What is said of the rows: how sure the share of successes is, what failure goes with, whose failures there are."""
from functools import lru_cache

import numpy as np
import pyarrow as pa
import pytest

from cosim.campaign.sampling import Sampler
from cosim.campaign.statistics import (
    MOST_PHASES,
    Results,
    explained,
    interval,
    interval_text,
    paired,
    rank_correlation,
    with_differences,
)
from cosim.vehicle.metrics import METRICS

RUNS, REPETITIONS, DRAWS = 200, 1000, 5


def of(law, table):
    return Results.of(law, table, "controller")


# --- intervals ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("successes,runs,low,high", [
    (0, 10, 0.0, 0.3084971078), (10, 10, 0.6915028922, 1.0), (1, 10, 0.0025285785, 0.4450161170),
    (5, 10, 0.1870860284, 0.8129139716), (0, 0, 0.0, 1.0), (1, 1, 0.025, 1.0),
])
def test_the_interval_is_clopper_and_pearson_s(successes, runs, low, high):
    assert interval(successes, runs) == pytest.approx((low, high), abs=1e-9)


@pytest.mark.parametrize("missed", [0.02, 0.177, 2.0])  # failures to expect
def test_the_interval_covers_where_failure_is_rare(missed):
    assert coverage(missed, interval) >= 0.95


def test_wilson_s_interval_would_not():
    from scipy.stats import binomtest

    assert coverage(0.176, lambda k, runs: binomtest(k, runs).proportion_ci(0.95, method="wilson")) < 0.85


def coverage(missed, ends, runs=2000):
    """How often an interval covers the probability of success, by the binomial distribution."""
    from scipy.stats import binom

    p = 1 - missed / runs
    return sum(float(binom.pmf(k, runs, p)) for k in range(1950, runs + 1) if within(p, ends(k, runs)))


def within(p, ends):
    return ends[0] <= p <= ends[1]


# Whether a run succeeds, of its draws (rows, DRAWS), and how probable that is. Even draws help some of these, not all.
SUCCESS = {
    "one draw": (lambda u: u[:, 0] < 0.8, 0.8),
    "two phases": (lambda u: np.cos(2 * np.pi * (u[:, 1] - u[:, 3])) < np.cos(0.3 * np.pi), 0.7),
    "a corner": (lambda u: (u[:, :3] < 0.8).all(axis=1), 0.512),
    "rarely not": (lambda u: u[:, 0] * 500 >= 1, 0.998),
    "a maze": (lambda u: np.floor(u * 64).sum(axis=1) % 2 == 0, 0.5),
}


@lru_cache
def successes(sampling):
    """How many runs succeed, in each of the repetitions, by the names of SUCCESS."""
    points = [Sampler(sampling, seed, RUNS, DRAWS).points(0, RUNS) for seed in range(REPETITIONS)]
    return {name: [int(success(u).sum()) for u in points] for name, (success, _) in SUCCESS.items()}


@pytest.mark.parametrize("name", SUCCESS)
@pytest.mark.parametrize("sampling", ["random", "latin-hypercube", "sobol"])
def test_the_interval_covers_with_every_sampling(sampling, name):
    p, counts, known = SUCCESS[name][1], successes(sampling)[name], lru_cache(interval)
    covered = np.mean([within(p, known(k, RUNS)) for k in counts])
    spread = np.std(counts) / (RUNS * p * (1 - p))**0.5
    print(f"{sampling}, {name}: covered {covered:.3f}, spread {spread:.2f} of the binomial's")
    assert covered >= 0.95 - 3 * (0.05 * 0.95 / REPETITIONS)**0.5
    if sampling == "random":
        assert 0.9 < spread < 1.1 and (covered < 0.99 or name == "rarely not")
    if sampling == "sobol" and name in ("one draw", "a corner"):
        assert spread < 0.6 and covered > 0.99  # wider than it need be


def test_only_independent_draws_have_an_interval_without_reserve():
    assert "wider" not in interval_text("random")
    assert all("at least 95 %" in interval_text(s) for s in ("random", "sobol", "latin-hypercube"))
    assert all(s in interval_text(s) and "wider" in interval_text(s) for s in ("sobol", "latin-hypercube"))


def test_of_samples_nobody_knows_whether_they_are_independent():
    assert "if the rows of draws.csv are independent" in interval_text("random", samples="draws.csv")


# --- correlations -------------------------------------------------------------------------------------------------


def test_rank_correlation_is_spearman_s():
    x = np.array([1.0, 2.0, 3.0, 4.0, 5.0])
    assert rank_correlation("a", x, np.exp(x)) == pytest.approx(1.0)
    assert rank_correlation("a", x, -x**3) == pytest.approx(-1.0)
    assert rank_correlation("a", x, np.array([2.0, 1.0, 4.0, 3.0, 5.0])) == pytest.approx(0.8)   # 1 - 6*4/(5*24)
    assert rank_correlation("a", x, np.array([0.0, 0.0, 0.0, 1.0, 1.0])) == pytest.approx(3 / 12**0.5)


def test_what_never_settled_comes_last_in_a_rank_correlation():
    x, y = np.arange(8.0), np.array([1.0, 2, 3, 4, np.inf, np.inf, np.inf, np.inf])
    assert rank_correlation("a", x, y) == pytest.approx(rank_correlation("a", x, np.minimum(y, 5)))
    assert rank_correlation("a", x, -y) == pytest.approx(-rank_correlation("a", x, y)) and y[-1] == np.inf
    assert rank_correlation("a", x, np.full(8, np.inf)) == 0.0


def test_rank_correlation_leaves_out_what_is_not_finite_and_is_0_for_what_does_not_vary():
    x, nan = np.array([1.0, 2.0, np.inf, 3.0, 4.0]), np.nan
    assert rank_correlation("a", x, np.array([1.0, 3.0, 0.0, nan, 9.0])) == pytest.approx(1.0)
    assert rank_correlation("a", x[:2], x[:2]) == 0.0
    assert rank_correlation("a", x, np.ones(5)) == rank_correlation("a", np.ones(5), x) == 0.0
    assert rank_correlation("a_sine_phase", x, np.ones(5)) == 0.0 == rank_correlation("a", x, np.full(5, nan))


def test_a_phase_s_correlation_does_not_depend_on_where_it_begins():
    phase = 2 * np.pi * np.arange(400) / 400
    found = [rank_correlation("s_sine_phase", phase, np.cos(phase - shift)) for shift in (0.0, 1.0, 2.5)]
    assert found == pytest.approx([found[0]] * 3, abs=1e-4) and 0.95 < found[0] < 1.0
    assert rank_correlation("s_sine_phase", phase, np.exp(5 * np.cos(phase))) == pytest.approx(found[0])  # ranks only
    assert rank_correlation("s_sine_phase", phase, np.cos(2 * phase)) < 1e-2
    half = rank_correlation("s_sine_phase", phase, (np.cos(phase) < 0).astype(float))
    assert half == pytest.approx(8**0.5 / np.pi, abs=1e-3)  # of a square wave with its first harmonic
    assert rank_correlation("s_sine_phase", np.array([0.0, 0.0, np.pi, np.pi]), np.array([1.0, 1, 2, 2])) \
        == pytest.approx(1.0)  # sine and cosine on one line


# --- rows ---------------------------------------------------------------------------------------------------------


def rows(law, statuses, met=True, **columns):
    """A table of runs, one of each of `statuses`."""
    n = len(statuses)
    return pa.table({
        "run": range(n), "controller": [law] * n, "status": statuses, "message": [""] * n,
        "success": [s == "finished" and bool(m) for s, m in zip(statuses, np.broadcast_to(met, n))],
        "departed_at_s": pa.array([t if s in ("departed", "timed-out") else None for t, s in enumerate(statuses)],
                                  pa.float64()),
        "plant.mass": pa.array(np.arange(n, dtype=float)),
        **{name: pa.array([float(v) for v in columns.get(name, range(n))], pa.float64()) for name in METRICS}})


STATUSES = ["finished", "error", "departed", "timed-out", "finished", "crashed", "error", "finished"]
MET = [True, True, True, True, False, True, True, True]


def test_failures_of_the_machinery_are_counted_apart_from_the_law_s():
    table = pa.concat_tables([rows("a", STATUSES, MET), rows("b", ["finished"] * 8)])
    found = of("a", table).summary(["plant.mass"], "altitude_error_ft.max_abs", METRICS, "law")
    assert (found["runs"], found["judged"], found["successes"]) == (8, 4, 2)
    assert found["failures"] == {"law": 2, "machinery": 4}
    assert found["probability"] == 0.5 and found["interval_95"] == list(interval(2, 4))
    assert found["statuses"] == {"crashed": 1, "departed": 1, "error": 2, "finished": 3, "timed-out": 1}
    assert list(found["statuses"]) == sorted(found["statuses"])
    assert found["metrics"]["elevator_deg.travel"] == {"median": 3.0, "p95": pytest.approx(6.55), "max": 7.0}
    # of runs 0, 2, 4, 7 the failures are 2 and 4; the machinery's do not drive anything
    assert found["drivers"]["plant.mass"]["failure"] == pytest.approx(0.0)
    other = of("b", table).summary([], "protected_s", METRICS, "law")
    assert (other["runs"], other["judged"], other["failures"]["machinery"], other["probability"]) == (8, 8, 0, 1.0)


def test_a_law_that_was_never_judged_has_no_probability():
    r = of("a", rows("a", ["error", "crashed", "timed-out"]))
    found = r.summary(["plant.mass"], "protected_s", METRICS, "law")
    assert found["probability"] is None and found["interval_95"] == [0.0, 1.0] and found["metrics"] == {}
    assert found["failures"] == {"law": 0, "machinery": 3} and r.worst("protected_s") == []
    assert [row["status"] for row in r.others.to_pylist()] == ["error", "crashed", "timed-out"]


def test_the_worst_are_the_earliest_departures_then_by_metric():
    statuses = ["finished", "departed", "timed-out", "finished", "departed", "finished"]
    r = of("a", rows("a", statuses, **{"protected_s": [5, 1, 9, 7, 2, np.nan]}))
    assert [row["run"] for row in r.worst("protected_s")] == [1, 4, 3, 0, 5]
    assert [row["run"] for row in r.worst("protected_s", 2)] == [1, 4]
    assert [row["run"] for row in r.worst("protected_s", least=True)] == [1, 4, 0, 3, 5]


def test_drivers_come_with_the_strongest_first():
    met = [False, False, False, True, True, True]
    r = of("a", rows("a", ["finished"] * 6, met, **{"fuel_ratio.max": [3, 1, 2, 6, 5, 4],
                                                 "fuel_ratio.min": [2, 1, 1, 2, 1, 2],
                                                 "protected_s": [1, 2, 3, 4, 5, 6]}))
    found = r.drivers(["fuel_ratio.min", "fuel_ratio.max", "no.column", "plant.mass"], "protected_s")
    assert list(found) == ["plant.mass", "fuel_ratio.max", "fuel_ratio.min"]
    assert found["plant.mass"] == {"failure": pytest.approx(-9 / 105**0.5), "protected_s": pytest.approx(1.0),
                                   "failure_explained": 0.0}  # too few runs to say


def test_the_points_of_a_grid_have_no_interval():
    found = Results.of("a", rows("a", ["finished"] * 4), "controller", drawn=False).summary([], None, [], "law")
    assert found["probability"] == 1.0 and found["interval_95"] is None


def test_whole_numbers_are_draws_with_an_order():
    table = rows("a", ["finished"] * 4, [True, True, False, False]).append_column(
        "p.n", pa.array([-2**62, 1, 2, 2**62], pa.int64()))
    assert of("a", table).drivers(["p.n"], None)["p.n"]["failure"] == pytest.approx(2 / 5**0.5)


def test_a_hundred_runs_see_most_of_a_share():
    """Of the share of y > 6 that Ishigami's second variable explains, 0.33, groups that were too large saw a half."""
    x = np.random.default_rng(3).uniform(-np.pi, np.pi, (60, 100, 3))
    y = np.sin(x[..., 0]) + 7 * np.sin(x[..., 1]) ** 2 + 0.1 * x[..., 2] ** 4 * np.sin(x[..., 0])
    found = [explained(one[:, 1], (of > 6).astype(float)) for one, of in zip(x, y)]
    assert 0.22 < np.mean(found) < 0.33


def test_pairs_are_of_the_same_draws_where_both_laws_were_judged():
    a = of("a", rows("a", ["error", "finished", "finished", "departed", "departed", "finished", "finished"]))
    b = of("b", rows("b", ["finished", "departed", "crashed", "finished", "departed", "departed", "finished"]))
    assert paired(a, b) == {"both": 1, "only a": 2, "only b": 1, "neither": 1, "not judged": 2}
    assert paired(b, a) == {"both": 1, "only b": 1, "only a": 2, "neither": 1, "not judged": 2}


def test_differences_of_phases_are_draws_too():
    phases = {f"scenario.p{i}_sine_phase": [0.5 * i, 6.0] for i in range(MOST_PHASES + 1)}
    table, draws = with_differences(pa.table({**phases, "plant.mass": [1.0, 2.0]}), ["plant.mass", *phases])
    added = draws[1 + len(phases):]
    assert len(added) == MOST_PHASES * (MOST_PHASES - 1) // 2
    assert added[0] == "scenario.p0 - p1_sine_phase" and f"scenario.p0 - p{MOST_PHASES}_sine_phase" not in draws
    assert table[added[0]].to_pylist() == pytest.approx([2 * np.pi - 0.5, 0.0])
