"""What a flight did at its actuators' limits is said in its remarks and its message."""
import numpy as np
import pytest
from flights import made

from cosim.vehicle.limits import explained

TIME = np.arange(0, 10.05, 0.1)
DEG = np.pi / 180


def flight(elevator_deg, message="", parameters=None, **more):
    """A flight whose elevator is at a limit of 20 deg where it is drawn so; `message`: why it ended early."""
    elevator = np.broadcast_to(np.asarray(elevator_deg, float), TIME.shape)
    found = made(TIME, {"controller.elevator": elevator * DEG, "controller.elevator_saturated": abs(elevator) >= 20,
                        **more})
    found.message, found.finished, found.parameters = message, not message, parameters or {}
    return explained(found)


def test_a_flight_within_its_limits_has_nothing_said_of_it():
    assert flight(5.0).warnings == [] and flight(5.0, "theta is below").message == "theta is below"


@pytest.mark.parametrize("seconds, said", [(0.9, []), (1.2, ["At a limit: the elevator for 1.2 s of the 10 s flown."])])
def test_more_than_a_tenth_at_a_limit_is_said(seconds, said):
    assert flight(np.where(abs(TIME - 3.05 - seconds / 2) < seconds / 2, 20.0, 5.0)).warnings == said


def test_both_actuators_are_in_one_sentence():
    said = flight(np.where(TIME > 5.05, 20.0, 5.0), **{"controller.fuel_ratio_saturated": TIME > 2.05}).warnings
    assert said == ["At a limit: the fuel ratio for 8 s and the elevator for 5 s of the 10 s flown."]


@pytest.mark.parametrize("course, end", [
    (np.where(TIME > 3.95, 20.0, 5.0), " The elevator reached its stop of 20 deg at t = 4 s and stayed there."),
    (np.where(TIME > 3.95, np.where(TIME > 6, -20.0, 20.0), 5.0),
     " The elevator reached its stop of 20 deg at t = 4 s and stayed at its stops."),
    (np.where((TIME > 1.95) & (abs(TIME - 3) > 0.5) & (abs(TIME - 7) > 0.05), -20.0, 5.0),  # off for 1 s, for one row
     " The elevator reached its stop of -20 deg at t = 3.6 s and stayed there."),
    (np.where((TIME > 3.95) & (TIME < 9.5), 20.0, 5.0), ""),
])
def test_a_departure_tells_since_when_the_elevator_was_at_its_stops(course, end):
    found = flight(course, "theta = -90.01 deg is below its minimum -90 deg at t = 10 s")
    assert found.message.partition("at t = 10 s")[2].removeprefix(".") == end


@pytest.mark.parametrize("more, said", [
    ({}, []), ({"elevator_trim": 0.5}, ["it needs an elevator of 28.65 deg (-20 to 20 deg is allowed)."]),
    ({"trim_residual": 1e-3}, ["The vehicle does not start in trim: no level flight was found at V = 7700 ft/s"]),
])
def test_a_start_without_a_trim_within_the_limits_is_said(more, said):
    plant = {"V_start": 7700.0, "h_start": 85000.0, "fuel_ratio_trim": 0.27, "elevator_trim": 0.2, "trim_residual": 0.0}
    limits = {"fuel_ratio_min": 0.05, "fuel_ratio_max": 1.5, "elevator_min": -20 * DEG, "elevator_max": 20 * DEG}
    found = flight(5.0, parameters={"plant": {**plant, **more}, "controller": limits}).warnings
    assert len(found) == len(said) and all(part in whole for part, whole in zip(said, found))
