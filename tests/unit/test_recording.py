"""Rows in memory: in one place, or in parts."""
import numpy as np
import pytest

from cosim.master.recording import Recorder, Whole
from cosim.master.wiring import Signal

COLUMNS = [Signal("a.x", "m", ""), Signal("a.y", "m", "")]


def recorded(recorder, counts):
    """What a recorder has after rows written as the loop writes them, `counts` at a time."""
    done = 0
    for count in counts:
        rows, times = recorder.room(count + 1)  # the loop asks for one more than it may need
        values = np.arange(done, done + count, dtype=float)
        times[:count], rows[:count] = 0.1 * values, np.column_stack((values, -values))
        recorder.took(count)
        done += count
    recorder.add(0.1 * done, np.array([done, -done]))
    return recorder.finish()


@pytest.mark.parametrize("counts", [[1], [3, 0, 4], [1, 5, 20, 40], []])
def test_rows_in_one_place_are_those_in_parts(counts):
    time, rows = recorded(Recorder(COLUMNS), counts)
    whole = Whole(COLUMNS, 8)
    for _ in range(2):  # a flight, and another one in the same place
        found_time, found = recorded(whole.restart(), counts)
        assert np.array_equal(found_time, time) and np.array_equal(found, rows)
        assert found.shape == (sum(counts) + 1, 2) and found.base is whole.rows


def test_rows_that_fit_are_never_moved():
    whole = Whole(COLUMNS, 12)
    place = whole.rows
    recorded(whole, [3, 7])
    assert whole.rows is place
