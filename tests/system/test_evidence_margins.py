"""Delay margins of the sampled loops, computed by `ahv linearize` and confirmed by flying them: the FMU files with
a delay in one actuator or sensor settle just inside the margin and oscillate just outside."""
import json

import numpy as np
import pytest
from claims import ALTITUDES, SPEEDS, growth
from command import ahv
from evidence import fly
from exact_linear import GROUPS

from ahv_ctrl_fmu import backstepping_model, neural_model

INSIDE, OUTSIDE = 0.94, 1.06


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


@pytest.mark.parametrize("place", ["fuel_ratio", "elevator", "V", "gamma", "Q"])
def test_the_delay_margin_is_confirmed_by_flying(linearized, place):
    law, found = linearized
    margin = found["margins"][place]["delay_s"]
    assert late_motion(law, **{f"{place}_delay": INSIDE * margin}) < 1
    assert late_motion(law, **{f"{place}_delay": OUTSIDE * margin}) > 1


CORNERS = [(float(V), float(h)) for V in SPEEDS[::4] for h in ALTITUDES[::4]]


def test_robust_is_stable_over_the_envelope_calibrated_and_the_rival_not_in_thin_air():
    found = {(model, preset): {c: growth(model, model.PRESETS[preset], *c) for c in CORNERS}
             for model, preset in ((neural_model, "robust"), (neural_model, "calibrated"),
                                   (backstepping_model, "calibrated"))}
    robust, calibrated, rival = found.values()
    assert all(g < 0 for g in robust.values())
    for law in (calibrated, rival):
        assert all(g < 0 for (V, h), g in law.items() if h < 90000) and law[7500.0, 100000.0] > 0
    assert all(g < 0 for (V, h), g in calibrated.items() if h <= 90000)


def test_every_coefficient_at_0_6_to_1_4_at_the_first_trim():
    for scale in (0.6, 0.8, 1.0, 1.2, 1.4):
        scales = dict.fromkeys(GROUPS, scale)
        assert growth(neural_model, neural_model.PRESETS["robust"], scale=scales) < 0
        for law in (neural_model, backstepping_model):
            assert (growth(law, law.PRESETS["calibrated"], scale=scales) < 0) == (scale > 0.7)


def test_what_cannot_be_linearized_is_said_in_one_sentence():
    said = ahv("linearize", "--V", 7500, "--h", 105000, status=1)
    assert "controller.elevator = 0.349066 does not answer any input of controller: it is at a limit" in said
    assert "no preset nix" in ahv("linearize", "--preset", "nix", status=2)
