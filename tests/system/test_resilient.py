"""The law that keeps the vehicle: what it finds, what it holds back, the same flight however stepped."""
import numpy as np
import pytest
from evidence import GROUPS, Loaded, fly, summary

from cosim.master.flight import fly as fly_system
from cosim.vehicle import scenarios
from cosim.vehicle.closed_loop import planned

FORMS = ("quiet", "lean", "coupled")
SWING = 0.05 * np.pi  # rad/s, of Case 1's coefficients


def independent(seed, count):
    """Case 1's coefficients, every group with a phase of its own: values for `count` flights."""
    phases = np.random.default_rng(seed).uniform(-np.pi, np.pi, (count, len(GROUPS)))
    return [{"scenario": {f"scale_{group}_sine_phase": float(phase) for group, phase in zip(GROUPS, row)}}
            for row in phases]


def climbing(**scales):
    """400 ft up and down every 20 s with constant coefficients, for scales can only be found where something moves."""
    return {"scenario": {**{f"scale_{group}_base": scale for group, scale in scales.items()},
                         "h_command_square": 400.0, "h_command_square_period": 20.0}}


@pytest.fixture(scope="module")
def draws():
    """40 flights of each form with independent groups: form -> flights."""
    found = {}
    for form in FORMS:
        with Loaded("resilient", form) as loaded:
            found[form] = [loaded.fly("case1", values) for values in independent(18, 40)]
    return found


@pytest.mark.parametrize("form", FORMS)
def test_every_vehicle_is_kept(draws, form):
    flights = [summary(flight) for flight in draws[form]]
    assert all(flight.survived for flight in flights)
    assert sum(flight.h < 20 for flight in flights) >= 36


@pytest.mark.parametrize("form", FORMS)
def test_no_angle_of_attack_is_commanded_beyond_what_can_be_held(draws, form):
    bound = 0
    for flight in draws[form]:
        asked, limit = flight["controller.alpha_command"], flight["controller.alpha_limit"]
        assert (asked <= limit).all()
        protecting = flight["controller.protecting"] > 0
        assert np.array_equal(asked[protecting], limit[protecting])
        bound += protecting.any()
    assert bound >= 10, "the limit hardly ever bound: nothing was tested"


@pytest.mark.parametrize("form", ["quiet", "lean"])
@pytest.mark.parametrize("group, scale", [("lift", 0.7), ("lift", 1.3), ("moment", 0.7), ("moment", 1.3)])
def test_the_scales_found_are_the_true_ones_once_the_vehicle_has_moved(form, group, scale):
    flight = fly("hold", "resilient", form, climbing(**{group: scale}), stop=100)
    other = "moment" if group == "lift" else "lift"
    assert flight[f"controller.scale_{group}"][-1] == pytest.approx(scale, abs=0.02)
    assert flight[f"controller.scale_{other}"][-1] == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize("case, form, altitude", [("case1", "quiet", 3.07), ("case2", "quiet", 5.02),
                                                  ("case1", "lean", 2.41), ("case2", "lean", 4.88)])
def test_all_groups_together_are_flown_as_the_law_was_designed(case, form, altitude):
    assert summary(fly(case, "resilient", form)).h == pytest.approx(altitude, abs=0.01)


@pytest.mark.parametrize("form", ["quiet", "lean"])
def test_one_to_fifty_milliseconds_fly_the_same(form):
    heights = [summary(fly("case1", "resilient", form, step=step)).h for step in (0.001, 0.002, 0.01, 0.02, 0.05)]
    assert np.ptp(heights) < 0.1


@pytest.mark.parametrize("form", FORMS)
def test_both_flavours_fly_the_same(form, python_fmus):
    plan = scenarios.load("case1")
    presets = {**plan.presets, "controller": form}
    native, python = (fly_system(planned(plan, "resilient", presets, flavour, []), 0.01, 20)
                      for flavour in ("native", "python"))
    for column in native.columns:
        size = max(np.abs(native[column.name]).max(), 1e-3)
        assert np.abs(native[column.name] - python[column.name]).max() < 1e-9 * size, column.name


@pytest.mark.parametrize("case, form", [("case1", "quiet"), ("case2", "quiet"), ("case1", "lean"), ("case2", "lean")])
def test_a_step_of_delay_between_law_and_vehicle_costs_little(case, form):
    """Jacobi: the vehicle gets what was computed a step ago."""
    plan = scenarios.load(case)
    system = planned(plan, "resilient", {**plan.presets, "controller": form}, "native", [])
    found = [summary(fly_system(system, 0.01, plan.stop, algorithm)).h for algorithm in ("gauss-seidel", "jacobi")]
    assert found[1] == pytest.approx(found[0], abs=0.1)


def test_the_first_outputs_are_the_trim_and_nominal_flight_stays_there():
    flight = fly("hold", "resilient", stop=20)
    for name in ("fuel_ratio", "elevator"):
        assert np.ptp(flight[f"controller.{name}"]) < 1e-9
    assert np.abs(flight["plant.h"] - 85000).max() < 1e-6
