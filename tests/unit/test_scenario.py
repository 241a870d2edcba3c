"""The signals of the paper's cases."""
from math import pi, sin

import pytest
from oracle import starts

import cosim.vehicle.scenario_model as scenario
from fmus import floats


def signals(case, t):
    return scenario.outputs(floats, t, [], None, starts(scenario, "parameter", **scenario.PRESETS[case]))


@pytest.mark.parametrize("t", [0.0, 0.01, 5.0, 33.3, 100.0])
def test_case_1(t):
    found = signals("case1", t)
    assert (found["V_command"], found["h_command"]) == (7900, 85800)
    for scale in scenario.SCALES:
        assert found[scale] == pytest.approx(1 + 0.4 * sin(0.05 * pi * t), abs=1e-12)             # (68)


@pytest.mark.parametrize("t,V,h", [(0, 8033.33, 85800), (99.99, 8033.33, 85800), (100, 8366.66, 85000),
                                   (150, 8366.66, 85000), (200, 8699.99, 85800), (300, 8699.99, 85000)])
def test_commands_of_case_2(t, V, h):
    found = signals("case2", t)
    assert found["V_command"] == pytest.approx(V, abs=1e-9)
    assert found["h_command"] == h


@pytest.mark.parametrize("t", [10.0, 49.99, 50.0, 77.7, 100.0, 103.0, 155.5, 249.0, 295.0, 300.0])
def test_scales_of_case_2(t):
    inside = any(a <= t < a + 50 for a in (50, 150, 250))
    assert signals("case2", t)["scale_drag"] == pytest.approx(1 + (0.4 * sin(0.1 * pi * t) if inside else 0), abs=1e-12)


def test_hold_changes_nothing():
    assert signals("hold", 0.0) == signals("hold", 123.4)
    assert signals("hold", 0.0)["V_command"] == 7700


def test_an_edge_is_not_missed_by_a_clock_that_was_added_up():
    clock = 0.0
    for _ in range(10_000):
        clock += 0.01
    assert clock != 100.0
    assert signals("case2", clock) == pytest.approx(signals("case2", 100.0))
