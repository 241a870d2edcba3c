"""The figures of a flight: how well it tracked, and what that took."""
from typing import Any

import numpy as np

from ..master.flight import Flight


def error(values: np.ndarray) -> dict[str, float]:
    """Largest magnitude and root mean square."""
    return {"max_abs": float(np.max(np.abs(values))), "rms": float(np.sqrt(np.mean(values**2)))}


def truth(flight: Flight, name: str) -> np.ndarray:
    """A state of the plant as it is, where the plant also has a sensor's view of it."""
    true = f"plant.{name}_true"
    return flight[true if flight.has(true) else f"plant.{name}"]


def metrics(flight: Flight) -> dict[str, Any]:
    """Tracking errors (plant minus the controller's reference, at the same time), inputs, estimates."""
    elevator = np.degrees(flight["controller.elevator"])
    fuel_ratio = flight["controller.fuel_ratio"]
    result: dict[str, Any] = {
        "altitude_error_ft": error(truth(flight, "h") - flight["controller.h_reference"]),
        "velocity_error_fps": error(truth(flight, "V") - flight["controller.V_reference"]),
        "elevator_deg": {"min": float(elevator.min()), "max": float(elevator.max()),
                         "travel": float(np.abs(np.diff(elevator)).sum())},
        "fuel_ratio": {"min": float(fuel_ratio.min()), "max": float(fuel_ratio.max())},
    }
    result["phi_hat"] = {key: float(flight[name].max()) if flight.has(name) else None
                         for key, name in (("velocity_max", "controller.phi_hat_1"),
                                           ("altitude_max", "controller.phi_hat_2"))}
    return result
