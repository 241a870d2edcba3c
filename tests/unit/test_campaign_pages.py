"""What pages call things, and the small pictures of listed runs."""
import re
from types import SimpleNamespace

import numpy as np
import pytest

from cosim.campaign.curves import HEIGHT, MOST_POINTS, WIDTH, small, thinned
from cosim.campaign.labels import Label, labels_of, on_axes
from cosim.campaign.statistics import MOST_GROUPS, explained


def fmu(**variables):
    return SimpleNamespace(variables={name: SimpleNamespace(unit=unit, description=description)
                                      for name, (unit, description) in variables.items()})


def test_what_fmus_say_of_variables_is_on_axes_where_it_is_short_and_no_other_s():
    files = {"a": fmu(m=("kg", "mass"), k=("1", "stiffness  of\nthe spring"), q=(None, "")),
             "b": fmu(m=("kg", "mass"), long=("s", "x" * 61), cost=("$", "what $ it costs"))}
    names = ["a.m", "b.m", "a.k", "a.q", "b.long", "b.cost", "c.x", "other"]
    labels = labels_of(names, files)
    assert labels["a.m"] == Label("a.m", "kg", "mass") and labels["c.x"] == Label("c.x")
    assert on_axes(names, labels) == {
        "a.m": "a.m (kg)", "b.m": "b.m (kg)", "a.k": "stiffness of the spring", "a.q": "a.q", "b.long": "b.long (s)",
        "b.cost": r"what \$ it costs (\$)", "c.x": "c.x", "other": "other"}


def points(svg):
    return np.array([pair.split(",") for pair in re.search("points='(.*?)'", svg)[1].split()], float)


def test_a_small_picture_shows_the_whole_curve_with_its_ends_in_words():
    found = small("h <ft>", np.array([2.0, 3, 4]), np.array([1.0, 3, 2]))
    assert points(found).tolist() == [[0, HEIGHT], [WIDTH / 2, 0], [WIDTH, HEIGHT / 2]]
    assert "h &lt;ft&gt;<br>1 to 3, 2 to 4 s" in found
    assert points(small("h", np.array([1.0]), np.array([5.0]))).tolist() == [[0, HEIGHT]]
    assert small("h", np.array([1.0]), np.array([np.nan])) == ""


def test_many_rows_keep_their_extremes():
    time = np.arange(10_000.0)
    values = np.sin(time)
    values[[17, 8123]] = 40, -40
    t, v = thinned(time, values)
    assert len(t) <= MOST_POINTS + 2 and {40, -40} <= set(v) and (t[0], t[-1]) == (0, 9999) and (np.diff(t) > 0).all()


def test_a_share_of_variance_is_sobol_s_index():
    """Ishigami's function, whose indices of first order are known: 0.314, 0.442 and 0. The second waves so quickly that
    the groups' means have less of it: sin(w) / w of its height, w being half a group's share of the wave in rad."""
    x = np.random.default_rng(1).uniform(-np.pi, np.pi, (20_000, 3))
    y = np.sin(x[:, 0]) + 7 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])
    width = 2 * np.pi / MOST_GROUPS
    seen = [0.314, 0.442 * (np.sin(width) / width) ** 2, 0.0]
    assert [explained(column, y) for column in x.T] == pytest.approx(seen, abs=0.015)


def test_a_hundred_runs_see_most_of_a_share():
    """Of the share of y > 6 that Ishigami's second variable explains, 0.33, groups that were too large saw a half."""
    x = np.random.default_rng(3).uniform(-np.pi, np.pi, (60, 100, 3))
    y = np.sin(x[..., 0]) + 7 * np.sin(x[..., 1]) ** 2 + 0.1 * x[..., 2] ** 4 * np.sin(x[..., 0])
    found = [explained(one[:, 1], (of > 6).astype(float)) for one, of in zip(x, y)]
    assert 0.22 < np.mean(found) < 0.33


def test_failures_at_both_ends_and_words_that_fail_are_seen():
    draws = np.random.default_rng(2)
    x, word, other = draws.uniform(-1, 1, 2000), draws.choice(["a", "b", "c"], 2000), draws.random(2000)
    assert explained(x, (abs(x) > 0.8).astype(float)) > 0.8
    assert explained(word, (word == "b").astype(float)) == pytest.approx(1.0)
    assert explained(other, (abs(x) > 0.8).astype(float)) < 0.01
    assert explained(np.array(["a", "b"] * 500)[draws.permutation(1000)], x[:1000]) < 0.01


@pytest.mark.parametrize("runs", [0, 1, 2, 5, 30, 200])
def test_by_chance_nothing_is_explained_however_few_runs_there_are(runs):
    draws = np.random.default_rng(3)
    found = [explained(draws.random(runs), (draws.random(runs) < 0.3).astype(float)) for _ in range(200)]
    assert 0 <= np.mean(found) < (0.06 if runs < 100 else 0.02) and max(found) <= 1
    assert explained(np.full(runs, 2.0), draws.random(runs)) == explained(draws.random(runs), np.ones(runs)) == 0
    assert explained(draws.random(runs), np.full(runs, np.nan)) == 0
