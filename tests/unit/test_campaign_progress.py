"""What a campaign says while it runs, without a terminal."""
import time

import pytest

from cosim.campaign import progress
from cosim.campaign.progress import Count, duration, shown


@pytest.fixture
def clock(monkeypatch):
    """A clock that a test sets, s."""
    now = [100.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    return now


def test_a_line_has_counts_rate_share_and_time_left(clock):
    count = Count("case1", 6000, 1000, 500)
    assert count.line == "case1: 1,000 of 6,000 runs, 0.0 runs/s, 50.0 % of all so far successes, unknown time left"
    count.rows, count.successes, clock[0] = 2000, 700, 150.0
    assert count.line == "case1: 2,000 of 6,000 runs, 20.0 runs/s, 35.0 % of all so far successes, 0:03:20 left"


def test_nothing_flown_yet_is_no_division_by_zero(clock):
    assert Count("c", 10, 0, 0).line == "c: 0 of 10 runs, 0.0 runs/s, unknown time left"


def test_times_have_hours():
    assert [duration(s) for s in (0.4, 59.6, 3599, 100_000)] == ["0:00:00", "0:01:00", "0:59:59", "27:46:40"]


def test_without_a_terminal_there_is_a_line_from_time_to_time_even_if_nothing_is_added(capsys):
    with shown("case1", 10, 0, 0, every=0.05) as added:
        time.sleep(0.3)
        quiet = capsys.readouterr().err.splitlines()
        added(4, 1)
        time.sleep(0.3)
    later = capsys.readouterr().err.splitlines()
    time.sleep(0.2)
    assert quiet and set(quiet) == {"ahv: case1: 0 of 10 runs, 0.0 runs/s, unknown time left"}
    assert later[-1].startswith("ahv: case1: 4 of 10 runs, ") and "25.0 % of all so far successes" in later[-1]
    assert capsys.readouterr().err == ""  # and none once it is over


def test_a_line_comes_once_a_minute():
    assert progress.LINE_S == 60
