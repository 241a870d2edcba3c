"""Expressions on signals: every figure by hand on uneven rows, what is refused, and what has no value."""
import math
import pickle
import re

import numpy as np
import pytest
from flights import made
from hypothesis import given
from hypothesis import strategies as st
from places import ROOT

from cosim.master.course import Course
from cosim.master.evaluate import CONDITION, FIGURES, FUNCTIONS, NUMBER, SIGNAL, TRUTH
from cosim.master.measures import check, parse, values

TIME = [1.0, 2.0, 4.0, 5.0, 9.0]
FLOWN = {"tank.h": [0, 4, 2, 2, 6], "tank.set": 2.0, "tank.on": [1, 0, 1, 1, 0], "tank.mode": [0, 2, 2, 1, 2],
         "tank.angle": [0, math.pi, math.pi / 2, 0, -math.pi], "body.x[1]": [3, 1, 1, 1, 1],
         "tank.bad": [0, 1, math.nan, 2, 3], "tank.far": [1, math.inf, 0, 0, 0]}
FLIGHT = made(TIME, FLOWN)
METRICS = {"peak": 6.0, "fuel.left": 3.0, "none": None, "nan": math.nan}
ALL = set(FLOWN)


def worth(text, flight=FLIGHT):
    return parse(text).value(flight.course, METRICS)


@pytest.mark.parametrize("text,expected", [
    ("min(tank.h)", 0), ("max(tank.h)", 6), ("final(tank.h)", 6), ("max_abs(tank.h - 5)", 5),
    ("travel(tank.h)", 4 + 2 + 0 + 4),
    ("integral(tank.h)", 2 + 6 + 2 + 16), ("mean(tank.h)", 26 / 8),
    ("rms(tank.h)", math.sqrt((8 + 20 + 4 + 80) / 8)), ("rms(tank.h - tank.set)", math.sqrt((4 + 4 + 0 + 32) / 8)),
    ("max(abs(tank.h - tank.set))", 4), ("max(abs(tank.h - tank.set)) - peak", -2),
    ("final(degrees(tank.angle))", -180), ("degrees(max(tank.angle))", 180),
    ('max("body.x[1]")', 3), ('"fuel.left" + fuel.left', 6),
    ("max(2 * tank.h - tank.h / 4 + 1)", 11.5), ("min(-tank.h)", -6), ("max(tank.h * tank.h)", 36),
    ("max(tank.h ** 2)", 36), ("integral(max(tank.h - 3, 0))", (1 + 0) / 2 + 1 + 0 + 6),  # kinks lie at rows
    ("integral(min(tank.h, tank.set, 100))", 1 + 4 + 2 + 8), ("max(1, 2, peak)", 6), ("min(peak, 2)", 2),
    ("abs(-peak)", 6),
    # h crosses 3 at 1.75 on its way up, at 3 on its way down, at 6 for good
    ("time_above(tank.h, 3)", 0.25 + 1 + 3), ("time_on(tank.h > 3)", 4.25), ("time_on(3 < tank.h)", 4.25),
    ("time_on(tank.h < 3)", 8 - 4.25), ("time_on(not tank.h > 3)", 8 - 4.25), ("time_above(tank.h, peak)", 0),
    ("time_on(tank.h > 2)", 0.5 + 2 + 4), ("time_on(tank.h >= 2)", 0.5 + 2 + 1 + 4),
    ("time_on(tank.h > tank.set)", 6.5), ("time_on(1 < tank.h < 3)", 0.5 + 1 + 1 + 1),
    ("time_on(tank.h > 3 or tank.h < 1)", 4.25 + 0.25), ("time_on(tank.h > 3 and tank.h < 5)", 0.25 + 1 + 2),
    ("time_on(tank.on)", 2 + 1), ("time_on(not tank.on)", 1 + 4), ("time_on(tank.on == 1)", 3),
    ("time_on(tank.mode == 2)", 1 + 2 + 4), ("time_on(tank.mode != 2)", 1), ("time_on(tank.on and tank.h > 3)", 1),
    ("time_on((tank.h > 3) == (tank.h > 3))", 8), ("time_on((tank.h > 3) != tank.on)", 0.25 + 1 + 1 + 3),
    ("time_on(0 < 1 < tank.h)", 0.75 + 2 + 1 + 4), ("time_on(1 < 0 < tank.h)", 0),
    ("first(tank.h > 3)", 0.75), ("first(tank.h >= 4)", 1), ("first(tank.h > 4)", 7 - 1), ("first(tank.h <= 0)", 0),
    ("first(tank.h >= 6)", 8), ("first(tank.h > 6)", math.inf), ("first(not tank.on)", 0), ("first(tank.on)", 0),
    ("first(tank.mode == 1)", 3), ("first(tank.mode == 2)", 0), ("first(tank.h < 3 and tank.h > 1)", 0.25),
    ("first(tank.h == 2)", 1), ("first(tank.h >= 3 and tank.h <= 3)", 0.75),
    ("settling(tank.h, 6, 5)", 0.25), ("settling(tank.h, 6, 4)", 0.5), ("settling(tank.h, 3, 1)", math.inf),
    ("settling(tank.h, 3, 100)", 0), ("min(settling(tank.h, 3, 1), 20)", 20),
    ("max(tank.h) < 20 and first(tank.h > 3) < 1", True), ("max(tank.h) < 20 and not peak == 6", False),
    ("settling(tank.h, 3, 1) < 30", False),
])
def test_figures_of_uneven_rows_computed_by_hand(text, expected):
    found = worth(text)
    assert found == (expected if isinstance(expected, bool) or math.isinf(expected) else pytest.approx(expected))
    assert type(found) is (bool if isinstance(expected, bool) else float)
    assert check(parse(text), ALL, METRICS) == (TRUTH if isinstance(expected, bool) else NUMBER)


SINGLE = made([7.0], {"tank.h": 3.0, "tank.on": 1.0})


@pytest.mark.parametrize("text,expected", [
    *((f"{name}(tank.h)", 3) for name in ("min", "max", "final", "mean", "rms", "max_abs")),
    ("integral(tank.h)", 0), ("travel(tank.h)", 0), ("time_above(tank.h, 2)", 0), ("time_on(tank.on)", 0),
    ("first(tank.h > 2)", 0), ("first(tank.h > 3)", math.inf), ("first(tank.on)", 0), ("settling(tank.h, 3, 1)", 0),
    ("settling(tank.h, 9, 1)", math.inf), ("first(tank.on and tank.h >= 3)", 0),
])
def test_figures_of_a_single_row(text, expected):
    assert worth(text, SINGLE) == expected


def test_signals_of_components_with_steps_of_their_own_are_taken_together_when_both_are_known():
    time = np.arange(13.0)
    flight = made(time, {"quick.x": time, "slow.x": 3 * (time // 3), "slower.x": 4 * (time // 4)},
                  {"slow": 3.0, "slower": 4.0})
    assert worth("max_abs(quick.x - slow.x)", flight) == 0
    assert worth("time_on(slow.x > 4 and slower.x < 6)", flight) == 2
    assert worth("final(slow.x - slower.x + quick.x)", flight) == 12
    early = made(time[:12], {"quick.x": time[:12], "slow.x": 3 * (time[:12] // 3)}, {"slow": 3.0})
    assert (worth("final(slow.x)", early), worth("final(quick.x)", early)) == (9, 11)
    assert worth("time_on(quick.x > 1 or slow.x > 100)", early) == 8  # both are known up to 9 s


@pytest.mark.parametrize("text,reason", [
    ("max(tank.missing)", "has no signal tank.missing"), ("1 + none", "there is no none"),
    ("2 > nan", "there is no nan"), ("1 / (peak - 6)", "division by zero"),
    ("(-peak) ** 0.5", "is not a real number"), ("max(tank.bad) < 2", "not a number"),
    ("first(tank.bad > 2)", "not a finite number at t = 4 s"), ("time_above(tank.far, 0)", "finite number at t = 2 s"),
    ("time_on(tank.bad) > 0", "not a finite number at t = 4 s"), ("first(tank.bad != 7) < 9", "number at t = 4 s"),
    ("time_on(7 == tank.bad) < 9", "finite number at t = 4 s"), ("time_on(not tank.far) < 9", "number at t = 2 s"),
    ("settling(tank.bad, 0, 9) < 9", "not a number"), ("max(0, mean(tank.bad)) < 9", "not a number"),
    ("min(0, 1, mean(tank.bad), 2) < 9", "not a number"),
])
def test_what_has_no_value_says_why_and_does_not_hold(text, reason):
    with pytest.raises(ValueError, match=reason) as error:
        worth(text)
    assert len(str(error.value).splitlines()) == 1 and not str(error.value).endswith(".")
    assert parse(text).holds(FLIGHT.course, METRICS) is False


def test_what_is_computed_from_no_number_is_no_number():
    assert math.isnan(worth("max(tank.bad)")) and math.isnan(worth("max((tank.h - 3) ** 0.5)"))
    assert worth("max(1 / tank.h)") == math.inf


NAMES = {"tank.h", "tank.set", "tank.on", "body.x[1]"}


@pytest.mark.parametrize("text,found", [
    ("tank.h", SIGNAL), ("tank.h - 1", SIGNAL), ("-abs(tank.h)", SIGNAL), ("max(tank.h, 3)", SIGNAL),
    ("tank.h > 3", CONDITION), ("tank.on and tank.h > 3", CONDITION), ("1 < tank.h < peak", CONDITION),
    ("max(tank.h) > 3", TRUTH), ("not peak > 3", TRUTH), ("3", NUMBER), ("peak", NUMBER),
])
def test_kinds(text, found):
    assert check(parse(text), NAMES, METRICS) == check(parse(text), NAMES, METRICS, found) == found


REFUSED = {
    "max(tank.hh) < 3": "there is no metric or signal tank.hh; did you mean tank.h?",
    "max(tanc.h) < 3": "there is no metric or signal tanc.h; did you mean tank.h?",
    "peek < 3": "there is no metric or signal peek; did you mean peak?",
    'max("body.x[2]") < 3': r"there is no metric or signal body.x\[2\]; did you mean body.x\[1\]?",
    "max(zzz) < 3": "there is no metric or signal zzz; there are peak, fuel.left, none, nan$",
    "max(body.x[1]) < 3": r"body.x\[1\] is not allowed in an expression; a signal of that name is written in quotes",
    "maximum(tank.h) < 3": "there is no function maximum; did you mean max?",
    "time_abov(tank.h, 3) < 3": "there is no function time_abov; did you mean time_above?",
    "time_above(tank.h) < 3": "time_above takes a signal and a level, not 1",
    "settling(tank.h, 3) < 3": "settling takes a signal, a target and a band, not 2",
    "rms() < 3": "rms takes a signal, not 0", "mean(tank.h, tank.set) < 3": "mean takes a signal, not 2",
    "first() < 3": "first takes a condition, not 0",
    "mean(3) < 3": "in mean\\(3\\), 3 is not a signal", "mean(peak) < 3": "in mean\\(peak\\), peak is not a signal",
    "max(peak) < 3": "max takes two numbers or more, not 1", "max() < 3": "max takes two numbers or more, not 0",
    "first(3) < 3": "in first\\(3\\), 3 is not true or false at each time",
    "first(peak > 3) < 3": "peak > 3 is not true or false at each time",
    "mean(tank.h > 3) < 3": "tank.h > 3 is true or false at each time, not a signal",
    "max(tank.h > 3) < 3": "tank.h > 3 is true or false at each time, not a signal",
    "time_above(tank.h, tank.set) < 3": "tank.set is a signal, not a number",
    "settling(tank.h, tank.set, 3) < 3": "tank.set is a signal, not a number",
    "abs(tank.h > 3) < 3": "tank.h > 3 is true or false at each time, not a number",
    "-(tank.h > 3) < 3": "tank.h > 3 is true or false at each time, not a number",
    "(tank.h > 3) + 1 < 3": "tank.h > 3 is true or false at each time, not a number",
    "(tank.h > 3) < 3": "tank.h > 3 is true or false at each time, not a number",
    "time_on((tank.h > 3) == 1) < 3": "1 is not true or false at each time",
    "time_on(tank.h > 3 and peak > 2) < 3": "peak > 2 is not true or false at each time",
    "peak > 2 and tank.h > 3": "tank.h > 3 is true or false at each time, not of the whole run$",
    "time_on(not peak) < 3": "peak is not true or false",
    "tank.h": r"'tank.h' is a signal: say which number of it, such as max\(tank.h\)$",
    "tank.h - tank.set": r"is a signal: say which number of it, such as max\(tank.h - tank.set\)$",
    "tank.h > 3": r"is true or false at each time: say how long it holds, or from when on: time_on\(tank.h > 3\)",
    "max(tank.h)": "is neither true nor false: compare something", "1 + ": "is not an expression",
    "max(key=tank.h) < 3": "is not allowed", "max(*tank.h) < 3": "is not allowed", "tank.h() < 3": "is not allowed",
    "tank.h[0] < 3": "written in quotes", "max(tank.h).real < 3": "is not allowed", "'' < 3": "metric or signal",
    "b'a' < 3": "is not allowed", "f'{tank.h}' < 3": "is not allowed", "max(tank.h) < 3; 1": "is not an expression",
    "max([tank.h]) < 3": "is not allowed", "__import__('os') < 3": r"__import__\('os'\) is not allowed",
    "max.__call__(1, 2) < 3": "is not allowed", "... < 3": "is not allowed",
    "max(tank.h for h in tank) < 3": "is not allowed",
}


@pytest.mark.parametrize("text,reason", REFUSED.items(), ids=list(REFUSED))
def test_what_is_no_success_is_refused_in_one_line(text, reason):
    with pytest.raises(ValueError, match=reason) as error:
        check(parse(text), NAMES, METRICS, TRUTH)
    assert len(str(error.value).splitlines()) == 1 and str(error.value).startswith("'")


def test_a_truth_is_no_number():
    with pytest.raises(ValueError, match="'peak > 3' is true or false, not a number"):
        check(parse("peak > 3"), NAMES, METRICS, NUMBER)


def test_an_expression_travels_by_its_text_and_names_what_it_needs():
    expression = parse(' max("body.x[1]" - tank.h) / peak + min(tank.h) ')
    assert expression.names == ("body.x[1]", "tank.h", "peak")
    again = pickle.loads(pickle.dumps(expression))
    assert again == expression and again.value(FLIGHT.course, METRICS) == expression.value(FLIGHT.course, METRICS)


def test_metrics_may_name_those_before_them_and_signals_are_asked_for_once():
    asked = []

    def course(name):
        asked.append(name)
        return FLIGHT.course(name)

    texts = {"high": "max(tank.h)", "low": "min(tank.h)", "span": "high - low", "void": "1 / low", "worse": "void + 1",
             "late": "first(tank.h > 100)", "absent": "max(tank.missing)", "share": "span / peak"}
    found = values({name: parse(text) for name, text in texts.items()}, course, METRICS)
    assert found == {"high": 6, "low": 0, "span": 6, "late": math.inf, "share": 1}
    assert asked == ["tank.h", "tank.missing"]


ROWS = st.lists(st.tuples(st.floats(0.01, 3), st.integers(-4, 4)), min_size=1, max_size=8)


@given(ROWS, st.integers(-3, 3), st.sampled_from(["<", "<=", ">", ">="]))
def test_conditions_agree_with_the_straight_lines_at_every_moment(rows, level, sign):
    steps, heights = zip(*rows)
    flight = made(np.cumsum(steps), {"a.x": heights, "a.level": level, "a.x2": heights[::-1]})
    span = flight.time[-1] - flight.time[0]
    text = f"a.x {sign} a.level"
    on, off = (worth(f"time_on({condition})", flight) for condition in (text, f"not {text}"))
    assert on + off == pytest.approx(span)
    other = "a.x2 > 0"
    both, either = (worth(f"time_on({text} {word} {other})", flight) for word in ("and", "or"))
    assert both + either == pytest.approx(on + worth(f"time_on({other})", flight))  # inclusion and exclusion
    assert worth(f"first(not ({text} and {other}))", flight) == worth(f"first(not {text} or not {other})", flight)
    begin = worth(f"first({text})", flight)
    assert begin <= span - on + 1e-9 if on else True
    moments = np.linspace(flight.time[0], flight.time[-1], 701)
    line = Course(flight.time, np.asarray(flight["a.x"])).at(moments)
    held = eval(f"line {sign} level", {"line": line, "level": level})
    assert abs(np.mean(held) * span - on) <= span * (2 * len(rows) + 2) / 700
    if held.any():
        assert begin <= moments[held.argmax()] - flight.time[0] + 1e-9


@given(ROWS)
def test_time_weighs_averages(rows):
    steps, heights = zip(*rows)
    flight = made(np.cumsum(steps), {"a.x": heights})
    span = flight.time[-1] - flight.time[0]
    assert worth("integral(a.x)", flight) == pytest.approx(span * worth("mean(a.x)", flight) if span else 0, abs=1e-9)
    assert worth("min(a.x) - 1e-9 <= mean(a.x) <= max(a.x) + 1e-9 and rms(a.x) <= max_abs(a.x) + 1e-9", flight)


def test_the_page_names_every_function_with_what_it_takes():
    page = (ROOT / "docs" / "campaigns.md").read_text()
    calls = [parse(text.replace("…", "s")) for row in re.findall(r"^\| (`\w+\(.*?) \|", page, re.MULTILINE)
             for text in re.findall(r"`(.*?)`", row)]
    assert {call.text.partition("(")[0] for call in calls} == {*FUNCTIONS, *FIGURES}
    for call in calls:
        check(call, {"s", "c"}, {"x", "y", "target", "band", "level"}, NUMBER if "s" in call.names[0] else None)
