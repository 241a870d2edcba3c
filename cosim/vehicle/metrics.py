"""The figures of a flight: how well it tracked, and what that took. Adding one: a line in METRICS."""
from collections.abc import Container, Set
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from ..master.flight import Flight
from ..master.measures import Expression, values
from .signals import COMMANDS, SENSED, course, known

ALTITUDE_ERROR = "plant.h_true - controller.h_reference"
VELOCITY_ERROR = "plant.V_true - controller.V_reference"
ALPHA_MARGIN = "controller.alpha_limit - plant.theta_true + plant.gamma_true"
# Drawn over time: name -> what is on the axis, and the signal.
OVER_TIME = {"altitude_error_ft": ("altitude error (ft)", ALTITUDE_ERROR),
             "velocity_error_fps": ("velocity error (ft/s)", VELOCITY_ERROR)}


@dataclass(frozen=True)
class Metric:
    """One figure of a flight, in `unit`: an expression on its signals, see master.measures."""
    unit: str
    text: str
    headline: str = ""   # in words, of those that laws are judged by: verdicts name them, histograms show them

    @cached_property
    def expression(self) -> Expression:
        """The expression."""
        return Expression(self.text)

    def known(self, signals: Container[str]) -> bool:
        """Whether `signals`, or a flight, have all that it is computed from."""
        return all(known(signals, name) for name in self.expression.names)


METRICS = {
    "altitude_error_ft.max_abs": Metric("ft", f"max_abs({ALTITUDE_ERROR})", "maximum altitude error"),
    "altitude_error_ft.rms": Metric("ft", f"rms({ALTITUDE_ERROR})", "rms altitude error"),
    "velocity_error_fps.max_abs": Metric("ft/s", f"max_abs({VELOCITY_ERROR})", "maximum velocity error"),
    "velocity_error_fps.rms": Metric("ft/s", f"rms({VELOCITY_ERROR})"),
    "elevator_deg.min": Metric("deg", "degrees(min(controller.elevator))"),
    "elevator_deg.max": Metric("deg", "degrees(max(controller.elevator))"),
    "elevator_deg.travel": Metric("deg", "travel(degrees(controller.elevator))", "elevator travel"),
    "fuel_ratio.min": Metric("1", "min(controller.fuel_ratio)"),
    "fuel_ratio.max": Metric("1", "max(controller.fuel_ratio)"),
    "phi_hat.velocity_max": Metric("1", "max(controller.phi_hat_1)"),
    "phi_hat.altitude_max": Metric("1", "max(controller.phi_hat_2)"),
    "saturated_s.fuel_ratio": Metric("s", "time_on(controller.fuel_ratio_saturated)"),
    "saturated_s.elevator": Metric("s", "time_on(controller.elevator_saturated)"),
    "protected_s": Metric("s", "time_on(controller.protecting)"),
    "alpha_margin_deg.min": Metric("deg", f"degrees(min({ALPHA_MARGIN}))"),
}
HEADLINES = tuple(name for name, metric in METRICS.items() if metric.headline)


def needed(signals: Set[str]) -> set[str]:
    """Which of `signals` (component.variable) the metrics are computed from."""
    found: set[str] = set()
    for name in (n for metric in METRICS.values() if metric.known(signals) for n in metric.expression.names):
        found |= {name, SENSED.get(name, name)} & signals or {COMMANDS[name]}
    return found


def measured(flight: Flight) -> dict[str, float | None]:
    """Every metric by its name; None where the flight does not have its signals."""
    found = values({name: metric.expression for name, metric in METRICS.items() if metric.known(flight)},
                   lambda name: course(flight, name), {})
    return {name: found.get(name) for name in METRICS}


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
