"""Delay margins of the sampled loops, computed by `ahv linearize` and confirmed by flying them: the FMU files with
a delay in one actuator or sensor settle just inside the margin and oscillate just outside."""
import json

import numpy as np
import pytest
from evidence import fly
from test_cases import ahv

INSIDE, OUTSIDE = 0.94, 1.06
LONGEST = 0.23  # s, what the instrumented plant can delay by


@pytest.fixture(scope="module", params=["neural", "backstepping"])
def linearized(request):
    return request.param, json.loads(ahv("linearize", "--controller", request.param, "--json"))


def late_motion(law, **delay):
    """Largest pitch rate (1e-4 rad/s) or velocity error (0.01 ft/s) in the last 20 s of 240 s after a small step;
    infinite where the flight departs."""
    flight = fly("hold", law, values={"plant": delay, "scenario": {"h_command_step": 10.0, "V_command_step": 1.0}},
                 plant="instrumented", stop=240.0)
    if not flight.finished:
        return np.inf
    late = flight.time > 220
    return max(np.abs(flight["plant.Q_true"][late]).max() / 1e-4,
               np.abs(flight["controller.V_error"][late]).max() / 1e-2)


@pytest.mark.parametrize("place", ["fuel_ratio", "elevator", "V", "h", "gamma", "Q"])
def test_the_delay_margin_is_confirmed_by_flying(linearized, place):
    law, found = linearized
    margin = found["margins"][place]["delay_s"]
    if margin * OUTSIDE > LONGEST:
        pytest.skip(f"{margin:.3f} s is more than can be flown")
    assert late_motion(law, **{f"{place}_delay": INSIDE * margin}) < 1
    assert late_motion(law, **{f"{place}_delay": OUTSIDE * margin}) > 1
