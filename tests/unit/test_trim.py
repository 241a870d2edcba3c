"""Level flight: Table 1 of the paper."""
from math import degrees

import pytest
from oracle import starts

import ahv_plant_fmu.model as plant
from ahv_plant_fmu.trim import level_trim
from fmus import floats


def trim(V=7700.0, h=85000.0, **changed):
    return level_trim(floats, V, h, starts(plant, "parameter", **changed))


def test_reproduces_table_1_to_every_printed_digit():
    found = trim()
    assert f"{degrees(found.theta):.4f}" == "1.6325"
    assert f"{found.eta1:.4f}" == "0.9700"
    assert f"{found.eta2:.4f}" == "0.7967"
    assert f"{found.fuel_ratio:.5f}" == "0.26703"
    assert f"{degrees(found.elevator):.3f}" == "12.511"


def test_table_1_needs_g_of_32():
    assert f"{degrees(trim(gravity=32.174).theta):.4f}" == "1.6459"


@pytest.mark.parametrize("V", [7500, 8500, 9500, 11000])
@pytest.mark.parametrize("h", [80000, 90000, 100000])
def test_every_state_derivative_vanishes_over_the_envelope(V, h):
    assert trim(V, h).residual < 1e-9
