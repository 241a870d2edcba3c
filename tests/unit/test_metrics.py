"""The table of metrics: what each is computed from, and by which formula."""
import numpy as np
import pytest
from flights import made
from scipy.linalg import expm

from cosim.campaign.worker import ENVELOPE_POINTS, errors_over_time
from cosim.master.evaluate import TRUTH
from cosim.master.measures import check, parse
from cosim.vehicle.compare import BETTER, figures_of, verdict
from cosim.vehicle.metrics import HEADLINES, METRICS, OVER_TIME, measured, metrics, needed
from cosim.vehicle.signals import course, reference

TIME = np.array([0, 1, 2, 5, 10.0])
DEG = np.pi / 180
FLOWN = {
    "plant.h": [100, 101, 98, 98, 100], "plant.V": [50, 50, 51, 50, 50],
    "controller.h_reference": 100.0, "controller.V_reference": 50.0,
    "controller.elevator": [0, 2 * DEG, -1 * DEG, -1 * DEG, 3 * DEG],
    "controller.fuel_ratio": [0.2, 0.5, 0.4, 0.3, 0.3],
}
OURS = {
    "controller.phi_hat_1": [0, 1, 3, 2, 1], "controller.phi_hat_2": [0, 4, 3, 2, 1],
    "controller.protecting": [1, 0, 1, 1, 0],
    "controller.fuel_ratio_saturated": 0.0, "controller.elevator_saturated": [0, 1, 0, 1, 0],
    "plant.theta": 3 * DEG, "plant.gamma": [1 * DEG, 1 * DEG, 0, 1 * DEG, 1 * DEG], "controller.alpha_limit": 5 * DEG,
}
EXPECTED = {
    "altitude_error_ft.max_abs": 2.0, "altitude_error_ft.rms": np.sqrt((0.5 + 2.5 + 12 + 10) / 10),
    "velocity_error_fps.max_abs": 1.0, "velocity_error_fps.rms": np.sqrt((0.5 + 1.5) / 10),
    "elevator_deg.min": -1.0, "elevator_deg.max": 3.0, "elevator_deg.travel": 9.0,
    "fuel_ratio.min": 0.2, "fuel_ratio.max": 0.5,
}


def test_every_metric_of_a_flight_with_uneven_rows():
    found = measured(made(TIME, {**FLOWN, **OURS}))
    assert found == pytest.approx({**EXPECTED, "phi_hat.velocity_max": 3, "phi_hat.altitude_max": 4,
                                   "saturated_s.fuel_ratio": 0, "saturated_s.elevator": 1 + 3, "protected_s": 4,
                                   "alpha_margin_deg.min": 2}, abs=1e-9)
    assert list(found) == list(METRICS)


def test_a_law_without_a_signal_has_none_of_its_metrics():
    found = measured(made(TIME, FLOWN))
    assert {n: v for n, v in found.items() if v is not None} == pytest.approx(EXPECTED, abs=1e-9)
    nested = metrics(made(TIME, FLOWN))
    assert list(nested) == ["altitude_error_ft", "velocity_error_fps", "elevator_deg", "fuel_ratio", "phi_hat",
                            "saturated_s", "protected_s", "alpha_margin_deg"]
    assert nested["phi_hat"] == {"velocity_max": None, "altitude_max": None}
    assert nested["protected_s"] is None and nested["alpha_margin_deg"] == {"min": None}
    assert nested["elevator_deg"] == pytest.approx({"min": -1, "max": 3, "travel": 9})


def test_a_plant_with_sensors_is_judged_by_what_it_does_and_not_by_what_it_measures():
    seen = made(TIME, {**FLOWN, **OURS, "plant.h_true": 103.0, "plant.V_true": 54.0, "plant.theta_true": 5 * DEG,
                       "plant.gamma_true": 1 * DEG})
    found = measured(seen)
    assert (found["altitude_error_ft.max_abs"], found["velocity_error_fps.rms"]) == (3, 4)
    assert found["alpha_margin_deg.min"] == pytest.approx(1)


def test_a_controller_without_a_reference_is_judged_by_the_filtered_command():
    time = np.array([0, 1.0, 1.5, 4.0, 30.0])
    command = np.array([10, 20, 20, 20, 20.0])
    flight = made(time, {"plant.h": 10.0, "plant.V": 50.0, "scenario.h_command": command, "scenario.V_command": 50.0,
                         "controller.elevator": 0.0, "controller.fuel_ratio": 0.0})
    found = measured(flight)
    assert found["velocity_error_fps.max_abs"] == 0
    assert found["altitude_error_ft.max_abs"] == pytest.approx(np.max(np.abs(10 - reference(time, command, 10.0))))


@pytest.mark.parametrize("time", [np.linspace(0, 90, 9001), np.array([0, 1, 1.25, 7, 20, 90.0])])
def test_the_filter_answers_the_same_whatever_the_rows(time):
    """Two steps of the command, at 0 and at 1 s, through x'' = 0.01 (command - x) - 0.18 x'."""
    A = np.array([[0, 1], [-0.01, -0.18]])

    def step(t):
        return (np.eye(2) - expm(A * t))[0, 0] if t > 0 else 0.0

    expected = [100 + 50 * step(t) - 80 * step(t - 1) for t in time]
    assert reference(time, np.where(time < 1, 150.0, 70.0), 100.0) == pytest.approx(np.array(expected), abs=1e-9)


def test_a_slow_controller_is_judged_when_it_has_stepped():
    """A reference that rises by 1 ft/s, tracked without any error by a vehicle that is recorded four times as often."""
    time = np.arange(0, 20.25, 0.25)
    flight = made(time, {**dict.fromkeys(FLOWN, 0.0), "plant.h": time, "controller.h_reference": time // 1},
                  {"controller": 1.0})
    assert measured(flight)["altitude_error_ft.max_abs"] == measured(flight)["altitude_error_ft.rms"] == 0


@pytest.mark.parametrize("shown,expected", [
    ({*FLOWN, "plant.Q", "plant.theta", "scenario.h_command"}, {*FLOWN}),
    ({*FLOWN, *OURS, "plant.Q"}, {*FLOWN, *OURS}),
    ({*FLOWN, "plant.h_true", "plant.V_true", "plant.theta", "plant.theta_true"},
     {*FLOWN, "plant.h_true", "plant.V_true"}),
    ({*FLOWN, "scenario.h_command", "scenario.V_command"} - {"controller.h_reference", "controller.V_reference"},
     {*FLOWN, "scenario.h_command", "scenario.V_command"} - {"controller.h_reference", "controller.V_reference"}),
])
def test_a_campaign_records_what_the_metrics_need(shown, expected):
    assert needed(shown) == expected


@pytest.mark.parametrize("name", METRICS)
def test_every_metric_can_be_a_criterion(name):
    expression = parse(f"{name} < 3")
    assert expression.names == (name,) and check(expression, (), METRICS) == TRUTH


def compared(**costs):
    """Rows of two laws of unequal height, with these costs of a step and their spreads."""
    made_of = {"plant.h": 0.0, "scenario.h_command": 100.0, "scenario.V_command": 50.0}
    return {law: {**figures_of(made(TIME, {**FLOWN, **made_of, "plant.h": height})), "cost_per_step_us": cost,
                  "cost_per_step_spread_us": {"from": cost - spread, "to": cost + spread}}
            for (law, (cost, spread)), height in zip(costs.items(), (101.0, 103.0))}


def test_a_flight_is_compared_by_its_headlines():
    assert len(BETTER) == len(HEADLINES) + 1 == 5
    assert verdict(compared(a=(2.0, 0.1), b=(1.0, 0.1))) == (
        "a has the smallest maximum altitude error (1 against 3 ft), rms altitude error (1 against 3 ft), maximum "
        "velocity error (1 against 1 ft/s), elevator travel (9 against 9 deg); b has the smallest cost per step "
        "(1 against 2 us).")


def test_costs_whose_spreads_overlap_are_no_difference():
    assert verdict(compared(a=(2.0, 0.6), b=(1.0, 0.6))).endswith(
        "(9 against 9 deg); no difference in cost per step was measured between a and b (2 and 1 us).")


def test_time_at_a_limit_is_counted_in_seconds_and_not_in_rows():
    flight = made(TIME, {**FLOWN, "scenario.h_command": 100.0, "scenario.V_command": 50.0,
                         "controller.elevator_saturated": [0, 1, 0, 1, 0], "controller.fuel_ratio_saturated": 1.0})
    found = figures_of(flight)
    assert (found["elevator_saturated_s"], found["fuel_saturated_s"]) == (4, 10)
    assert figures_of(made(TIME, {**FLOWN, "scenario.h_command": 100.0, "scenario.V_command": 50.0})
                      )["elevator_saturated_s"] is None


def test_errors_over_time_are_at_fixed_times_wherever_the_rows_lie():
    """An error that grows by 0.5 ft a second; 400 rows, most of them in the first seconds."""
    time = 20 * np.linspace(0, 1, 400)**3
    flight = made(time, {**dict.fromkeys(FLOWN, 0.0), "plant.h": 0.5 * time})
    courses = {name: course(flight, expression) for name, (_, expression) in OVER_TIME.items()}
    found = errors_over_time(courses, 0.01, 2000)
    assert found["time"] == pytest.approx(np.linspace(0, 20, ENVELOPE_POINTS + 1))
    assert found["altitude_error_ft"] == pytest.approx(0.5 * found["time"], abs=1e-6)
    short = errors_over_time(courses, 0.01, 10_000)
    assert short["time"] == pytest.approx(np.arange(21.0)) and len(short["velocity_error_fps"]) == 21
    assert errors_over_time(courses, 10.0, 3)["time"].tolist() == [0, 10, 20]
    later = errors_over_time({"h": flight.course("plant.h")}, 5.0, 100, 10.0)
    assert later["time"].tolist() == [10, 15, 20] and later["h"] == pytest.approx([5, 7.5, 10])
