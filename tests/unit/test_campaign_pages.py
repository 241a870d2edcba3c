"""What the report's page has of runs and their curves, and what pages call things."""
import base64
from types import SimpleNamespace

import numpy as np
import pyarrow.parquet as pq
import pytest
from campaign_pages import made_up

from cosim.campaign import curves, shown
from cosim.campaign.labels import Label, labels_of, on_axes
from cosim.campaign.statistics import MOST_GROUPS, Results, explained
from cosim.pages.decimate import GAP, rounded


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
        "b.cost": "what $ it costs ($)", "c.x": "c.x", "other": "other"}


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    return made_up(tmp_path_factory.mktemp("made"), "<x>")


def chosen_of(store):
    runs = pq.read_table(store.file("runs"))
    return runs, shown.chosen(store.plan, runs, [Results.of(law, runs, "variant") for law in store.plan.laws])


def test_a_page_has_all_runs_the_worst_first(store):
    runs, there = chosen_of(store)
    assert there.numbers.tolist() == list(range(40)) and there.sentence == ""
    neural = [row for row in runs.to_pylist() if row["variant"] == "neural"]
    departed = sorted((row["departed_at_s"], row["run"]) for row in neural if not row["success"])
    assert there.worst["neural"][:len(departed)].tolist() == [run for _, run in departed]
    assert sorted(there.worst["neural"]) == sorted(there.worst["resilient"]) == list(range(40))
    assert there.worst["resilient"][0] == max(neural, key=lambda row: row["m"])["run"]


def test_of_too_many_runs_failures_come_first_up_to_half_and_the_page_says_so(store, monkeypatch):
    monkeypatch.setattr(shown, "MOST_RUNS", 24)
    runs, there = chosen_of(store)
    failed = {row["run"] for row in runs.to_pylist() if not row["success"]}
    assert len(there.numbers) == 24 and (np.diff(there.numbers) > 0).all() and failed < set(there.numbers.tolist())
    assert there.sentence.startswith("This page has 24 of 40 runs: failures first")
    assert there.tables["neural"]["run"].to_pylist() == there.numbers.tolist()
    assert sorted(there.worst["neural"]) == list(range(24))
    monkeypatch.setattr(shown, "MOST_RUNS", 8)
    few = chosen_of(store)[1].numbers
    assert len(few) == 8 and len(failed & set(few.tolist())) >= 4
    assert few.tolist() == chosen_of(store)[1].numbers.tolist()


def test_the_page_has_draws_in_full_once_for_all_variants(store):
    _, there = chosen_of(store)
    data = shown.packed(store.plan, there, ["a.x", "a.word"])
    first, second = (variant["draws"] for variant in data["variants"])
    assert first == second and len(data["columns"]) == 2
    assert np.frombuffer(base64.b64decode(data["columns"][first[0]["at"]]), "<f8").tolist() == \
        there.tables["neural"]["a.x"].to_pylist()
    assert first[1]["words"] == ["<x>", "b b"] and data["variants"][0]["command"][-1] == [
        "results/run/<x>-neural-", "run"]


def test_messages_that_differ_in_numbers_share_their_words_and_have_an_end():
    messages = shown.Messages()
    texts = ["at t = 3.5 s: -2 is below 0", None, "at t = 4 s: -17.25 is below 0", "other"]
    places = [messages.place(text) for text in texts]
    assert len(messages.templates) == 2 and messages.found[0] == "" and places[1] == 0
    assert messages.found[places[2]] == "0|4|-17.25|0"
    assert next(iter(messages.templates)) == ("at t = ", " s: ", " is below ", "")
    messages.left = 0
    assert messages.found[messages.place("x" * 1000)] == messages.found[messages.place("y" * 1000)] == "2"
    assert list(messages.templates)[2] == (shown.FULL,)


def test_whole_numbers_of_16_bits_are_the_values_as_a_screen_shows_them():
    values = np.array([3.0, np.nan, -1e5, np.inf, 7e4])
    [low], [step], steps = rounded(values, [0])
    assert steps[[1, 3]].tolist() == [GAP, GAP] and step == pytest.approx(1.7e5 / (GAP - 1))
    assert low + step * steps[[0, 2, 4]] == pytest.approx(values[[0, 2, 4]], abs=step / 2)
    lows, sizes, steps = rounded(np.array([2.0, 2.0, np.nan, 1.0, 3.0]), [0, 2, 3])
    assert lows.tolist() == [2, 0, 1] and steps.tolist() == [0, 0, GAP, 0, GAP - 1] and sizes[2] == 2 / (GAP - 1)


def test_curves_of_all_runs_fit_their_room(store, monkeypatch):
    _, there = chosen_of(store)
    errors = pq.read_table(store.file("errors"))
    whole = curves.packed(store, there, errors)
    assert len(whole["signals"]) == 12 and len(np.frombuffer(base64.b64decode(whole["errors"]["times"]), "<f4")) == 101
    monkeypatch.setattr(curves, "ERRORS", 2000)
    monkeypatch.setattr(curves, "POINTS", 5 * curves.FEWEST)
    small = curves.packed(store, there, errors)
    counts = [np.frombuffer(base64.b64decode(one["counts"]), "<u2").sum() for one in small["errors"]["variants"]]
    assert sum(counts) <= 2100 and len(small["signals"]) == 5
    assert small["signals"][0]["place"] == min(range(6), key=lambda k: there.worst["neural"].tolist().index(k))


def test_a_share_of_variance_is_sobol_s_index():
    """Ishigami's function, whose indices of first order are known: 0.314, 0.442 and 0. The second waves so quickly that
    the groups' means have less of it: sin(w) / w of its height, w being half a group's share of the wave in rad."""
    x = np.random.default_rng(1).uniform(-np.pi, np.pi, (20_000, 3))
    y = np.sin(x[:, 0]) + 7 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])
    width = 2 * np.pi / MOST_GROUPS
    seen = [0.314, 0.442 * (np.sin(width) / width) ** 2, 0.0]
    assert [explained(column, y) for column in x.T] == pytest.approx(seen, abs=0.015)


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
