"""A picture of what was measured, what the fitted system shows, and the residuals."""
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure  # without pyplot, which keeps every figure

from ..pictures import MARKS, colour
from ..text import without_math

PANELS = 5   # signals in a picture
LEGEND = 7   # flights that it names


class Course(NamedTuple):
    """One signal of one flight: times (s), what was measured, before and after the fit; all of shape (rows,)."""
    flight: int
    time: np.ndarray
    measured: np.ndarray
    after: np.ndarray


class Panel(NamedTuple):
    """One signal: what it is called, the unit in which it is shown (empty without one), display = factor * value +
    offset, its noise level in its own unit."""
    name: str
    unit: str
    factor: float
    offset: float
    noise: float
    courses: list[Course]


def draw(folder: Path, panels: Sequence[Panel], flights: Sequence[str], title: str) -> None:
    """Write fit.png, or fit_1.png ... where there are more than PANELS signals. Raises OSError."""
    for first in range(0, len(panels), PANELS):
        part = panels[first:first + PANELS]
        figure = Figure(figsize=(11, 1.2 + 2.3 * len(part)), layout="constrained")
        axes = figure.subplots(len(part), 2, sharex=True, squeeze=False, width_ratios=(3, 2))
        for (left, right), panel in zip(axes, part):
            signal(left, panel)
            residuals(right, panel)
        for axis in axes[-1]:
            axis.set_xlabel("time (s)")
        figure.suptitle(without_math(title), fontsize="medium")
        handles = [left.plot([], [], MARKS[k % len(MARKS)], color=colour(k), markersize=4,
                             linestyle="-")[0] for k in range(min(len(flights), LEGEND)) for left in [axes[0, 0]]]
        names = [without_math(name) for name in flights[:LEGEND]]
        if len(flights) > LEGEND:
            names[-1] += f" ... {len(flights)} flights"
        figure.legend(handles, names, loc="outside lower center", ncols=min(len(names), 4), fontsize="small",
                      title="measured (marks) and fitted (lines)", title_fontsize="small")
        number = f"_{first // PANELS + 1}" if len(panels) > PANELS else ""
        figure.savefig(folder / f"fit{number}.png", dpi=110, pil_kwargs={"compress_level": 1})


def signal(axis: Axes, panel: Panel) -> None:
    """Marks for what was measured, lines for what the fitted system shows."""
    for one in panel.courses:
        own = colour(one.flight)
        axis.plot(one.time, panel.factor * one.measured + panel.offset, MARKS[one.flight % len(MARKS)], color=own,
                  markersize=2.5, alpha=0.5, markeredgewidth=0)
        axis.plot(one.time, panel.factor * one.after + panel.offset, color=own, linewidth=1.4)
    axis.set_ylabel(without_math(f"{panel.name}\n({panel.unit})" if panel.unit else panel.name), fontsize="small")
    axis.grid(True, alpha=0.3)
    axis.ticklabel_format(axis="y", useOffset=False)


def residuals(axis: Axes, panel: Panel) -> None:
    """Measured less fitted, with a band of two noise levels."""
    size = abs(panel.factor) * panel.noise
    axis.axhspan(-2 * size, 2 * size, color="0.9", zorder=0)
    axis.axhline(0.0, color="0.5", linewidth=0.8)
    for one in panel.courses:
        axis.plot(one.time, panel.factor * (one.measured - one.after), MARKS[one.flight % len(MARKS)],
                  color=colour(one.flight), markersize=2.5, alpha=0.6, markeredgewidth=0)
    unit = f" ({panel.unit})" if panel.unit else ""
    axis.set_ylabel(without_math(f"measured - fitted{unit}"), fontsize="small")
    axis.set_title(without_math(f"noise level {size:.3g} {panel.unit}".rstrip()) + ", band: two of it",
                   fontsize="small", loc="right")
    axis.grid(True, alpha=0.3)
