"""Pictures of a flight, one for each figure of the paper: Figures 2-7 (Case 1) and 8-13 (Case 2)."""
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure  # without pyplot, which is slow to import and keeps every figure

from ..master.flight import Flight
from ..text import without_math
from .signals import course, known


@dataclass(frozen=True)
class Panel:
    """One set of axes: the curves (label, signal or difference of two, style) and the quantity's name."""
    ylabel: str
    curves: tuple[tuple[str, str, str], ...]
    degrees: bool = False


PICTURES: list[tuple[str, str, tuple[Panel, ...]]] = [
    ("velocity", "Velocity tracking", (
        Panel("V (ft/s)", (("reference", "controller.V_reference", "k--"), ("V", "plant.V", "C0"))),
        Panel("V error (ft/s)", (("", "plant.V - controller.V_reference", "C3"),)))),
    ("altitude", "Altitude tracking", (
        Panel("h (ft)", (("reference", "controller.h_reference", "k--"), ("h", "plant.h", "C0"))),
        Panel("h error (ft)", (("", "plant.h - controller.h_reference", "C3"),)))),
    ("attitude", "Attitude angles", (
        Panel("γ (deg)", (("command $γ_d$", "controller.gamma_command", "k--"), ("γ", "plant.gamma", "C0")), True),
        Panel("θ (deg)", (("", "plant.theta", "C0"),), True),
        Panel("Q (deg/s)", (("", "plant.Q", "C0"),), True))),
    ("inputs", "Control inputs", (
        Panel("fuel ratio Φ", (("", "controller.fuel_ratio", "C0"),)),
        Panel("elevator $δ_e$ (deg)", (("", "controller.elevator", "C0"),), True))),
    ("flexible", "Flexible states", (
        Panel("$η_1$", (("", "plant.eta1", "C0"),)),
        Panel("$η_2$", (("", "plant.eta2", "C0"),)))),
    ("phi_hat", "Adapted parameters of the networks", (
        Panel("$\\hat\\varphi_1$ (velocity)", (("", "controller.phi_hat_1", "C0"),)),
        Panel("$\\hat\\varphi_2$ (altitude)", (("", "controller.phi_hat_2", "C0"),)))),
]


def available(flight: Flight, panels: tuple[Panel, ...]) -> bool:
    """Whether the flight has all signals of the panels."""
    return all(known(flight, expression) for panel in panels for _, expression, _ in panel.curves)


def draw(flight: Flight, title: str, panels: tuple[Panel, ...]) -> Figure:
    """One figure: panels above each other over the same time (s)."""
    height = 2.2 * len(panels) + 1
    figure = Figure(figsize=(8, height))
    axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False)
    # Fixed margins, in inches: finding them from the texts would take as long as all the drawing.
    figure.subplots_adjust(left=0.12, right=0.98, bottom=0.5 / height, top=1 - 0.4 / height, hspace=0.08)
    for axis, panel in zip(axes[:, 0], panels):
        for label, expression, style in panel.curves:
            found = course(flight, expression)
            y = np.degrees(found.values) if panel.degrees else found.values
            axis.plot(found.time, y, style, label=label, linewidth=1.2)
        axis.set_ylabel(panel.ylabel)
        axis.yaxis.set_label_coords(-0.09, 0.5)
        axis.grid(True, alpha=0.3)
        axis.ticklabel_format(axis="y", useOffset=False)
        if len(panel.curves) > 1:
            axis.legend(loc="best", fontsize="small")
    axes[-1, 0].set_xlabel("time (s)")
    axes[-1, 0].set_xlim(flight.time[0], max(flight.time[-1], 1e-9))
    axes[0, 0].set_title(without_math(title))
    return figure


def write(out: Path, flight: Flight, name: str, first_figure: int | None = None, share: slice = slice(None)
          ) -> list[Path]:
    """Draw every picture, or a share of them, that the flight has the signals for into `out`/figures; their paths.

    Files are numbered as in the paper from `first_figure` on, or have plain names without one.
    """
    folder = out / "figures"
    folder.mkdir(exist_ok=True)
    written = []
    for number, (key, title, panels) in [*enumerate(PICTURES, first_figure or 0)][share]:
        if not available(flight, panels):
            continue
        ending = f" (ended at {flight.reached:.2f} s)" if flight.message else ""
        figure = draw(flight, f"{name}: {title}{ending}", panels)
        path = folder / (f"{key}.png" if first_figure is None else f"figure_{number:02d}_{key}.png")
        figure.savefig(path, dpi=120, pil_kwargs={"compress_level": 1})
        written.append(path)
    return written
