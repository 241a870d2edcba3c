"""What a page shows of our flights: which curves, which errors, and what happened when."""
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..errors import UsageError
from ..master.flight import Flight
from ..pages.flown import Curve, Flown, Mark, Panel, windows
from .scenario_model import SCALES
from .signals import course, known

ERRORS = {"V error": ("plant.V - controller.V_reference", "ft/s"),
          "h error": ("plant.h - controller.h_reference", "ft")}
PANELS = (
    Panel("Velocity", ("plant.V", "controller.V_reference")),
    Panel("Velocity error", ("V error",)),
    Panel("Altitude", ("plant.h", "controller.h_reference")),
    Panel("Altitude error", ("h error",)),
    Panel("Flight path angle", ("plant.gamma", "controller.gamma_command")),
    Panel("Pitch angle and angle of attack", ("plant.theta", "plant.alpha")),
    Panel("Pitch rate", ("plant.Q",)),
    Panel("Fuel ratio", ("controller.fuel_ratio",)),
    Panel("Elevator", ("controller.elevator",)),
    Panel("Flexible modes", ("plant.eta1", "plant.eta2")),
    Panel("Adapted parameters", ("controller.phi_hat_1", "controller.phi_hat_2")),
    Panel("Scales of the coefficients", tuple(f"scenario.{name}" for name in SCALES)),
    Panel("Scales of the coefficients as flown", tuple(f"plant.{name}" for name in SCALES)),
)
FLAGS = (("controller.fuel_ratio_saturated", "saturation of the fuel ratio"),
         ("controller.elevator_saturated", "saturation of the elevator"),
         ("controller.protecting", "protection"))
COMMANDS = (("scenario.V_command", "velocity", "ft/s"), ("scenario.h_command", "altitude", "ft"))
FEW = 10    # so many steps may be in a flight of a few rows
STEP = 1.0  # ft/s, ft: a smaller change from row to row is no step


def looked_at(name: str, flight: Flight, record: Mapping[str, Any]) -> Flown:
    """A flight of the closed loop as a page shows it; `record` is what run.json says of it."""
    curves = {label: Curve(course(flight, text), unit, text) for label, (text, unit) in ERRORS.items()
              if known(flight, text)}
    return Flown(name, flight, record, curves, [*marks(flight), *by_hand(record.get("live", []))])


def marks(flight: Flight) -> list[Mark]:
    """Saturation, protection, steps of the commands, and windows of uncertainty."""
    found = uncertain(flight)
    for name, text in FLAGS:
        if name in flight:
            found += windows(text, text, flight.time, np.asarray(flight[name]))
    for name, what, unit in COMMANDS:
        if name in flight:
            found += steps(flight, name, what, unit)
    return found


def by_hand(made: Any) -> list[Mark]:
    """The steps of a live flight, as run.json lists them. Raises UsageError for anything else."""
    try:
        return [Mark("step made by hand", f"{step['input']} {step['value']:+.4g}" if step["value"] else
                     f"{step['input']} back", float(step["time"])) for step in made]
    except (TypeError, KeyError, ValueError):
        raise UsageError("live in a run.json is no list of steps, each with time, input and value.") from None


def steps(flight: Flight, name: str, what: str, unit: str) -> list[Mark]:
    """The rows from which a command is another one."""
    values = np.asarray(flight[name])
    component, _, variable = name.partition(".")
    base = flight.parameters.get(component, {}).get(f"{variable}_base")
    if isinstance(base, int | float):
        values = np.concatenate(([base], values))  # the first step may be at the start
    time = np.concatenate((flight.time[:len(values) - len(flight.time)], flight.time))
    rows = np.flatnonzero(np.abs(np.diff(values)) > STEP) + 1
    if len(rows) > max(FEW, len(values) // 20):  # it moves all the time
        return []
    return [Mark("step of a command", f"{what} command from {values[row - 1]:.7g} to {values[row]:.7g} {unit}",
                 float(time[row])) for row in rows]


def uncertain(flight: Flight) -> list[Mark]:
    """The windows in which coefficients are not nominal, each with the range of every group's scale."""
    scales = {name: np.asarray(flight[f"scenario.{name}"]) for name in SCALES if f"scenario.{name}" in flight}
    if not scales:
        return []
    away = np.any([np.abs(values - 1.0) > 1e-12 for values in scales.values()], axis=0)
    found = []
    for window in windows("uncertainty of the coefficients", "", flight.time, away):
        rows = (flight.time >= window.begin) & (flight.time <= (window.end or 0.0))
        ranges: dict[str, list[str]] = {}
        for name, values in scales.items():
            text = f"{values[rows].min():.3g} to {values[rows].max():.3g}"
            ranges.setdefault(text, []).append(name.removeprefix("scale_"))
        told = "; ".join(f"{', '.join(groups)} {text}" for text, groups in ranges.items())
        found.append(Mark(window.kind, f"scales of the coefficients: {told}", window.begin, window.end))
    return found
