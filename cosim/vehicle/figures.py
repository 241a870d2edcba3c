"""Pictures of a flight, one for each figure of the paper: Figures 2-7 (Case 1) and 8-13 (Case 2), and more."""
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from .. import pictures
from ..master.flight import Flight
from ..pictures import COMMAND, PNG, REFERENCE, Format
from ..text import without_math
from .signals import course, known

PLAIN: Mapping[str, Any] = {}


@dataclass(frozen=True)
class Panel:
    """One set of axes: the quantity's name with its unit, and the curves (label, signal or difference of two, line);
    `also` are drawn where the flight has them."""
    ylabel: str
    curves: tuple[tuple[str, str, Mapping[str, Any]], ...]
    degrees: bool = False
    also: tuple[tuple[str, str, Mapping[str, Any]], ...] = ()


GROUPS = ("thrust", "lift", "drag", "moment", "forces")  # of coefficients

PICTURES: list[tuple[str, str, tuple[Panel, ...]]] = [
    ("velocity", "Velocity tracking", (
        Panel("V (ft/s)", (("reference", "controller.V_reference", REFERENCE), ("V", "plant.V", PLAIN)),
              also=(("command", "scenario.V_command", COMMAND),)),
        Panel("V error (ft/s)", (("", "plant.V - controller.V_reference", PLAIN),)))),
    ("altitude", "Altitude tracking", (
        Panel("h (ft)", (("reference", "controller.h_reference", REFERENCE), ("h", "plant.h", PLAIN)),
              also=(("command", "scenario.h_command", COMMAND),)),
        Panel("h error (ft)", (("", "plant.h - controller.h_reference", PLAIN),)))),
    ("attitude", "Attitude angles", (
        Panel("γ (deg)", (("command", "controller.gamma_command", REFERENCE), ("γ", "plant.gamma", PLAIN)), True),
        Panel("γ less its command (deg)", (("", "plant.gamma - controller.gamma_command", PLAIN),), True),
        Panel("θ (deg)", (("", "plant.theta", PLAIN),), True),
        Panel("Q (deg/s)", (("", "plant.Q", PLAIN),), True))),
    ("inputs", "Control inputs", (
        Panel("fuel ratio Φ (1)", (("", "controller.fuel_ratio", PLAIN),)),
        Panel("elevator δₑ (deg)", (("", "controller.elevator", PLAIN),), True))),
    ("flexible", "Flexible states", (
        Panel("η₁ (√(slug ft))", (("", "plant.eta1", PLAIN),)),
        Panel("η₂ (√(slug ft))", (("", "plant.eta2", PLAIN),)))),
    ("phi_hat", "Adapted parameters of the networks", (
        Panel("φ̂₁, velocity (1/s)", (("", "controller.phi_hat_1", PLAIN),)),
        Panel("φ̂₂, altitude (1/s)", (("", "controller.phi_hat_2", PLAIN),)))),
]
# Not in the paper, so without a number.
MORE: list[tuple[str, str, tuple[Panel, ...]]] = [
    ("coefficients", "Scales of the coefficients", (
        Panel("scale (1)", tuple((group, f"scenario.scale_{group}", PLAIN) for group in GROUPS),
              also=tuple((f"{group}, estimated", f"controller.scale_{group}", PLAIN) for group in GROUPS)),)),
]


def available(flight: Flight, panels: tuple[Panel, ...]) -> bool:
    """Whether the flight has all signals that the panels need."""
    return all(known(flight, expression) for panel in panels for _, expression, _ in panel.curves)


def panel_of(flight: Flight, panel: Panel) -> pictures.Panel:
    """The panel with the flight's values; equal curves are one."""
    curves = []
    for label, expression, line in (*panel.curves, *panel.also):
        if known(flight, expression):
            found = course(flight, expression)
            values = np.degrees(found.values) if panel.degrees else found.values
            curves.append(pictures.Curve(label, found.time, values, line))
    return pictures.Panel(panel.ylabel, pictures.merged(curves))


def draw(flight: Flight, title: str, panels: tuple[Panel, ...], columns: int = 2) -> Figure:
    """One figure: panels above each other over the same time (s)."""
    return pictures.over_time([panel_of(flight, panel) for panel in panels], without_math(title), columns)


def write(out: Path, flight: Flight, name: str, first_figure: int | None = None, share: slice = slice(None),
          form: Format = PNG) -> list[Path]:
    """Draw every picture, or a share of them, that the flight has the signals for into `out`/figures; their paths.

    Those of the paper are numbered as there from `first_figure` on, or have plain names without one.
    """
    folder = out / "figures"
    folder.mkdir(exist_ok=True)
    numbers = dict(zip((key for key, _, _ in PICTURES), range(first_figure, 99))) if first_figure is not None else {}
    written = []
    for key, title, panels in (*PICTURES, *MORE)[share]:
        if not available(flight, panels):
            continue
        ending = f" (ended at {flight.reached:.2f} s)" if flight.message else ""
        figure = draw(flight, f"{name}: {title}{ending}", panels, form.columns)
        stem = f"figure_{numbers[key]:02d}_{key}" if key in numbers else key
        written.append(pictures.save(figure, folder / f"{stem}.{form.kind}", form))
    return written
