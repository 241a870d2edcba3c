"""The figures of a flight: how well it tracked, and what that took. Adding one: a line in METRICS."""
from collections.abc import Callable, Set
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..master.course import Course
from ..master.flight import Flight
from .signals import COMMANDS, SENSED, course, known, names

ALTITUDE_ERROR = "plant.h_true - controller.h_reference"
VELOCITY_ERROR = "plant.V_true - controller.V_reference"
ALPHA_MARGIN = "controller.alpha_limit - plant.theta_true + plant.gamma_true"
# Drawn over time: name -> what is on the axis, and the signal.
OVER_TIME = {"altitude_error_ft": ("altitude error (ft)", ALTITUDE_ERROR),
             "velocity_error_fps": ("velocity error (ft/s)", VELOCITY_ERROR)}


@dataclass(frozen=True)
class Metric:
    """One figure of a flight: `formula` of the course of `signal`, in `unit` (deg: the signal is in rad)."""
    unit: str
    formula: Callable[[Course], float]
    signal: str
    headline: str = ""   # in words, of those that laws are judged by: verdicts name them, histograms show them


METRICS = {
    "altitude_error_ft.max_abs": Metric("ft", Course.max_abs, ALTITUDE_ERROR, "maximum altitude error"),
    "altitude_error_ft.rms": Metric("ft", Course.rms, ALTITUDE_ERROR, "rms altitude error"),
    "velocity_error_fps.max_abs": Metric("ft/s", Course.max_abs, VELOCITY_ERROR, "maximum velocity error"),
    "velocity_error_fps.rms": Metric("ft/s", Course.rms, VELOCITY_ERROR),
    "elevator_deg.min": Metric("deg", Course.min, "controller.elevator"),
    "elevator_deg.max": Metric("deg", Course.max, "controller.elevator"),
    "elevator_deg.travel": Metric("deg", Course.travel, "controller.elevator", "elevator travel"),
    "fuel_ratio.min": Metric("1", Course.min, "controller.fuel_ratio"),
    "fuel_ratio.max": Metric("1", Course.max, "controller.fuel_ratio"),
    "phi_hat.velocity_max": Metric("1", Course.max, "controller.phi_hat_1"),
    "phi_hat.altitude_max": Metric("1", Course.max, "controller.phi_hat_2"),
    "saturated_s.fuel_ratio": Metric("s", Course.time_on, "controller.fuel_ratio_saturated"),
    "saturated_s.elevator": Metric("s", Course.time_on, "controller.elevator_saturated"),
    "protected_s": Metric("s", Course.time_on, "controller.protecting"),
    "alpha_margin_deg.min": Metric("deg", Course.min, ALPHA_MARGIN),
}
HEADLINES = tuple(name for name, metric in METRICS.items() if metric.headline)


def needed(signals: Set[str]) -> set[str]:
    """Which of `signals` (component.variable) the metrics are computed from."""
    found: set[str] = set()
    for name in (n for metric in METRICS.values() if known(signals, metric.signal) for n in names(metric.signal)):
        found |= {name, SENSED.get(name, name)} & signals or {COMMANDS[name]}
    return found


def measured(flight: Flight) -> dict[str, float | None]:
    """Every metric by its name; None where the flight does not have its signals."""
    courses: dict[tuple[str, bool], Course] = {}
    found: dict[str, float | None] = {}
    for name, metric in METRICS.items():
        key = metric.signal, metric.unit == "deg"
        if key not in courses and known(flight, metric.signal):
            shown = course(flight, metric.signal)
            courses[key] = Course(shown.time, np.degrees(shown.values)) if key[1] else shown
        found[name] = metric.formula(courses[key]) if key in courses else None
    return found


def metrics(flight: Flight) -> dict[str, Any]:
    """The same as run.json has them: `altitude_error_ft.rms` as {"altitude_error_ft": {"rms": ...}}."""
    result: dict[str, Any] = {}
    for name, value in measured(flight).items():
        quantity, _, kind = name.partition(".")
        if kind:
            result.setdefault(quantity, {})[kind] = value
        else:
            result[quantity] = value
    return result
