"""What a flight did at the limits of its actuators, in sentences for people."""
from math import degrees

import numpy as np

from ..master.flight import Flight
from .closed_loop import LIMITS
from .metrics import measured
from .trim import ARRIVED, beyond

SHARE = 0.1   # of the flight that an actuator may be at a limit without a word
PAUSE = 0.25  # s off a limit that do not count: on the way from one limit to the other
ACTUATORS = {"fuel_ratio": "fuel ratio", "elevator": "elevator"}


def explained(flight: Flight) -> Flight:
    """`flight` itself: its `remarks` say where it sat at a limit and what its start lacks, its `message`, if it ended
    early, since when the elevator was at its stops."""
    flight.remarks = [*flight.remarks, *start_of(flight), *saturation_of(flight)]
    if not flight.finished and (since := stuck(flight)):
        flight.message = f"{flight.message.rstrip('.')}. {since}"
    return flight


def start_of(flight: Flight) -> list[str]:
    """A sentence if level flight at the start needs more than the controller's limits allow, or was not found."""
    plant, controller = (flight.parameters.get(name, {}) for name in ("plant", "controller"))
    needed = ("V_start", "h_start", "fuel_ratio_trim", "elevator_trim", "trim_residual")
    if not (set(needed) <= set(plant) and {name for pair in LIMITS for name in pair} <= set(controller)):
        return []
    V, h, fuel_ratio, elevator, residual = (float(plant[name]) for name in needed)
    if not residual <= ARRIVED:
        return [f"The vehicle does not start in trim: no level flight was found at V = {V:g} ft/s, h = {h:g} ft."]
    said = beyond({"V_fps": V, "h_ft": h, "fuel_ratio": fuel_ratio, "elevator_deg": degrees(elevator)}, controller)
    return [said] if said else []


def saturation_of(flight: Flight) -> list[str]:
    """A sentence if an actuator was at a limit for more than SHARE of the flight."""
    found = measured(flight)
    flown = float(flight.time[-1] - flight.time[0]) if len(flight.time) else 0.0
    long = [f"the {word} for {seconds:.4g} s" for name, word in ACTUATORS.items()
            if (seconds := found[f"saturated_s.{name}"] or 0.0) > SHARE * flown]
    return [f"At a limit: {' and '.join(long)} of the {flown:.4g} s flown."] if long else []


def stuck(flight: Flight) -> str:
    """A sentence if the elevator was at its stops when the flight ended; empty if it was not."""
    flag, signal = "controller.elevator_saturated", "controller.elevator"
    if flag not in flight or signal not in flight:
        return ""
    rows = np.flatnonzero(np.asarray(flight[flag]))
    if not len(rows):
        return ""
    following = np.append(rows[1:], len(flight.time) - 1)
    paused = (following - rows > 1) & (flight.time[following] - flight.time[rows] > PAUSE)
    since = rows[np.flatnonzero(paused)[-1] + 1] if paused[:-1].any() else rows[0]
    if paused[-1] or flight.time[-1] - flight.time[since] < PAUSE:
        return ""
    stops = np.degrees(np.asarray(flight[signal])[rows[rows >= since]])
    stayed = "stayed there" if np.ptp(stops) < 1e-6 else "stayed at its stops"
    return f"The elevator reached its stop of {stops[0]:.4g} deg at t = {flight.time[since]:.4g} s and {stayed}."
