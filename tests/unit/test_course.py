"""Figures of a signal belong to the time it took, not to the rows that show it."""
import numpy as np
import pytest
from flights import made

from cosim.errors import UsageError
from cosim.master.course import Course, terms
from cosim.vehicle.compare import settling

EVEN = np.linspace(0, 20, 20001)
CROWDED = 20 * np.linspace(0, 1, 20001)**3            # most rows at the beginning, where the signal is large
COARSE = np.array([0, 0.5, 1.0, 4.0, 4.25, 10.0])


def decay(time):
    return Course(time, 3 * np.exp(-time))


@pytest.mark.parametrize("time", [EVEN, CROWDED])
def test_averages_do_not_depend_on_where_the_rows_lie(time):
    assert decay(time).mean() == pytest.approx(3 * -np.expm1(-20) / 20, rel=1e-4)
    assert decay(time).rms() == pytest.approx(3 * np.sqrt(-np.expm1(-40) / 40), rel=1e-4)


def test_an_average_of_evenly_spaced_rows_counts_the_first_and_the_last_by_half():
    assert Course(np.arange(4.0), np.array([1.0, 2.0, 4.0, 8.0])).mean() == (0.5 + 2 + 4 + 4) / 3
    assert Course(np.arange(4.0), np.array([1.0, -2.0, 4.0, 8.0])).rms() == np.sqrt((0.5 + 4 + 16 + 32) / 3)


def test_a_single_row_is_its_own_average():
    alone = Course(np.zeros(1), np.array([-3.0]))
    assert (alone.mean(), alone.rms(), alone.travel(), alone.time_on(), alone.share_on()) == (-3, 3, 0, 0, 1)


def test_extremes_and_travel():
    course = Course(COARSE, np.array([1.0, -4.0, 2.0, 2.0, 3.0, 0.0]))
    assert (course.min(), course.max(), course.max_abs()) == (-4, 3, 4)
    assert course.travel() == 5 + 6 + 0 + 1 + 3


def test_a_truth_value_at_a_row_held_in_the_step_that_ended_there():
    course = Course(COARSE, np.array([1.0, 0.0, 1.0, 0.0, 1.0, 1.0]))
    assert course.time_on() == 0.5 + 0.25 + 5.75
    assert course.share_on() == 0.65


def test_values_between_rows_lie_on_a_straight_line_and_there_are_none_outside():
    course = Course(np.array([1.0, 2.0, 4.0]), np.array([10.0, 20.0, 0.0]))
    assert np.array_equal(course.at(np.array([0.9, 1.0, 1.5, 3.0, 4.0, 4.1])), [np.nan, 10, 15, 10, 0, np.nan],
                          equal_nan=True)


@pytest.mark.parametrize("values,expected", [
    ([0, 0, 0, 0, 0, 0], None), ([5, 5.5, 4.6, 5, 5, 5], 0.0), ([0, 2, 3, 6, 5, 5], 4.125),
    ([0, 4, 6, 5, 5, 5], 2.5), ([5, 5, 5, 5, 5, 9], None),
    ([0, np.inf, 5, 5, 5, 5], 1.0), ([0, 5, 5, 5, 5, -np.inf], None),
])
def test_settling_is_the_crossing_of_the_band_between_two_rows(values, expected):
    found = Course(COARSE, np.array(values, float)).settling(5.0, 0.5)
    assert found == (expected if expected is None else pytest.approx(expected))


@pytest.mark.parametrize("place", range(6))
def test_nothing_that_is_no_number_has_settled(place):
    values = np.full(6, 5.0)
    values[place] = np.nan
    assert np.isnan(Course(COARSE, values).settling(5.0, 0.5))
    assert place == 0 or settling(COARSE, np.array([0.0, 5, 5, 5, 5, 5]), values) is None


def test_settling_after_the_steps_of_a_command_is_that_of_the_slowest():
    time = np.array([0, 1, 2, 4, 5, 6, 7, 10.0])
    command = np.array([1, 1, 1, 3, 3, 3, 3, 3.0])
    found = np.array([0, 0.5, 1, 1, 2, 2, 3, 3.0])
    assert settling(time, command, found) == pytest.approx(2.96)
    assert settling(time[:3], command[:3], found[:3]) == pytest.approx(1.96)


@pytest.mark.parametrize("expression,expected", [
    ("a.x", [(1, "a.x")]), ("a.x - b.y", [(1, "a.x"), (-1, "b.y")]),
    ("a.x - b.y + c.z", [(1, "a.x"), (-1, "b.y"), (1, "c.z")]), ("a.x-b", [(1, "a.x-b")]),
])
def test_an_expression_is_a_sum_of_signals(expression, expected):
    assert terms(expression) == expected


def test_a_name_of_a_signal_is_never_taken_apart():
    assert terms("a.x - y", {"a.x - y"}) == [(1, "a.x - y")]


def test_a_difference_has_the_rows_at_which_both_are_known():
    """`slow` steps every 3 s, `slower` every 4 s; between, rows show what they had."""
    time = np.arange(13.0)
    flight = made(time, {"quick.x": time, "slow.x": 3 * (time // 3), "slower.x": 4 * (time // 4)},
                  {"slow": 3.0, "slower": 4.0})
    for expression, rows in (("quick.x", time), ("quick.x - slow.x", [0, 3, 6, 9, 12]),
                             ("slow.x", [0, 3, 6, 9, 12]), ("slow.x - slower.x + quick.x", [0, 12])):
        assert flight.course(expression).time.tolist() == list(rows)
    assert not flight.course("quick.x - slow.x").values.any()
    assert flight.plot("quick.x - slow.x").axes[0].lines[0].get_xdata().tolist() == [0, 3, 6, 9, 12]


def test_rows_at_which_a_component_steps_are_found_in_a_long_flight():
    time = np.arange(3_000_001) * 1e-4
    flight = made(time, {"slow.x": 0.0}, {"slow": 7e-4})
    assert np.array_equal(np.flatnonzero(flight.together(["slow.x"])), np.arange(0, 3_000_001, 7))


def test_a_course_of_what_is_not_there_is_refused():
    with pytest.raises(UsageError, match=r"has no signal a\.y; did you mean a\.x"):
        made([0, 1], {"a.x": 0.0}).course("a.x - a.y")
