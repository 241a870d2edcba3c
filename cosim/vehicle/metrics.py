"""The figures of a flight: how well it tracked, and what that took."""
from typing import Any

import numpy as np

from ..master.flight import Flight
from .signals import signal, truth


def error(values: np.ndarray) -> dict[str, float]:
    """Largest magnitude and root mean square."""
    return {"max_abs": float(np.max(np.abs(values))), "rms": float(np.sqrt(np.mean(values**2)))}


def tracking_errors(flight: Flight) -> dict[str, np.ndarray]:
    """Plant minus the controller's reference, at the same time: ft and ft/s, shape (rows,)."""
    return {name: truth(flight, state) - signal(flight, f"controller.{state}_reference")
            for name, state in (("altitude_error_ft", "h"), ("velocity_error_fps", "V"))}


def protection(flight: Flight) -> dict[str, Any]:
    """How long (s) the law held the angle of attack back, and the least of its limit minus the angle of attack (deg).

    None for a law that does not say them.
    """
    held = margin = None
    if flight.has("controller.protecting"):
        held = float(np.diff(flight.time) @ flight["controller.protecting"][1:])  # a row shows the step before it
    if flight.has("controller.alpha_limit"):
        alpha = truth(flight, "theta") - truth(flight, "gamma")
        margin = float(np.degrees(flight["controller.alpha_limit"] - alpha).min())
    return {"protected_s": held, "alpha_margin_deg": {"min": margin}}


def metrics(flight: Flight) -> dict[str, Any]:
    """Tracking errors, what they took of the inputs, what protection and networks did (None for other laws)."""
    elevator = np.degrees(flight["controller.elevator"])
    fuel_ratio = flight["controller.fuel_ratio"]
    result: dict[str, Any] = {
        **{name: error(values) for name, values in tracking_errors(flight).items()},
        "elevator_deg": {"min": float(elevator.min()), "max": float(elevator.max()),
                         "travel": float(np.abs(np.diff(elevator)).sum())},
        "fuel_ratio": {"min": float(fuel_ratio.min()), "max": float(fuel_ratio.max())},
    }
    result["phi_hat"] = {key: float(flight[name].max()) if flight.has(name) else None
                         for key, name in (("velocity_max", "controller.phi_hat_1"),
                                           ("altitude_max", "controller.phi_hat_2"))}
    return {**result, **protection(flight)}
