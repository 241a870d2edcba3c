"""The margin of a success expression: positive where it holds, at most 0 where it does not."""
import math

import pytest

from cosim.campaign.margin import check, margin, of_flight, signed
from cosim.errors import UsageError
from cosim.master.measures import parse

M = {"altitude_error_ft.max_abs": 5.0, "elevator_deg.min": -3.0, "fuel_ratio.max": 0.0}
A, E, F = M


def nothing(name):
    raise UsageError(f"there is no {name}")


def of(text):
    return margin(text, nothing, M)


@pytest.mark.parametrize("text,expected", [
    (f"{A} < 20", 15), (f"{A} <= 20", 15), (f"{A} > 20", -15), (f"20 >= {A}", 15), (f"1 < {A} < 7", 2),
    (f"{A} < 20 and {E} > -4", 1), (f"{A} < 20 or {E} > -4", 15), (f"not {A} < 20", -15),
    (f"not ({A} < 20 and {E} > -2)", 1), (f"abs({E}) < 4", 1), (f"max({A}, 2 * 3) - 1 < 8", 3),
    (f"({A} < 20) == ({E} > -4)", 1), (f"({A} < 20) == ({E} > -2)", -1), (f"({A} < 20) != ({E} > -2)", 1),
    (f"1 / {F} < 3", -math.inf), (f"{F} < 1 or 1 / {F} < 3", 1), ("elevator_deg.max < 3", -math.inf),
])
def test_margins(text, expected):
    assert of(text) == expected
    assert (of(text) > 0) is parse(text).holds(nothing, M)


@pytest.mark.parametrize("text", [f"{A} == 5", f"{A} < 3 and {E} != 2", f"({A} < 3) == ({E} == 2)"])
def test_a_comparison_without_a_margin_is_refused(text):
    with pytest.raises(ValueError, match="is met or not, with nothing between: rare needs < or >"):
        check(text)


@pytest.mark.parametrize("text", [f"{A} < 5", f"({A} < 20) == ({E} > -4)", f"not {A} < 3 or {E} > 1"])
def test_other_expressions_have_a_margin(text):
    check(text)


def test_a_margin_agrees_with_the_criterion_at_its_limit():
    assert signed(0.0, True) > 0 >= signed(0.0, False)
    assert signed(-math.inf, True) > 0 >= signed(3.0, False)


def test_a_departed_run_failed_whatever_it_showed_and_the_earlier_the_worse():
    texts, success = {"altitude": f"{A} < 20"}, {"altitude": False}
    early, late = (of_flight(texts, success, nothing, M, share) for share in (0.1, 0.9))
    assert early < late < 0
    assert of_flight(texts, success, nothing, M, 1.0) <= 0


def test_several_criteria_have_the_least_margin():
    texts = {"a": f"{A} < 20", "b": f"{E} > -4"}
    assert of_flight(texts, {"a": True, "b": True}, nothing, M, None) == 1
