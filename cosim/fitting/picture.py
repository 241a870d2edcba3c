"""A picture of what was measured, what the fitted system shows, and the residuals."""
from collections.abc import Sequence
from pathlib import Path
from textwrap import fill
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure  # without pyplot, which keeps every figure
from matplotlib.lines import Line2D

from .. import pictures
from ..pictures import COLOURS, LINES, MARKS, PNG, Format, colour
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


def draw(folder: Path, panels: Sequence[Panel], flights: Sequence[str], title: str, form: Format = PNG) -> None:
    """Write fit.png, or fit_1.png ... where there are more than PANELS signals. Raises OSError."""
    names = [without_math(name) for name in flights[:LEGEND]]
    if len(flights) > LEGEND:
        names[-1] += f" ... {len(flights)} flights"
    wide = form.columns == 2
    for first in range(0, len(panels), PANELS):
        part = panels[first:first + PANELS]
        with pictures.style():
            rows = len(part) if wide else 2 * len(part)
            figure = Figure(figsize=(pictures.WIDTHS[form.columns], 0.9 + 1.6 * rows), layout="constrained")
            axes = figure.subplots(rows, 2 if wide else 1, sharex=True, squeeze=False,
                                   width_ratios=(3, 2) if wide else None).reshape(len(part), 2)
            for (left, right), panel in zip(axes, part):
                signal(left, panel)
                residuals(right, panel)
            for axis in axes[-1] if wide else axes[-1, 1:]:
                axis.set_xlabel("time (s)")
            figure.suptitle(fill(without_math(title), 100 if wide else 50))
            handles = [Line2D([], [], **fitted(k), marker=mark_of(k)) for k in range(len(names))]
            figure.legend(handles, names, loc="outside lower center", ncols=min(len(names), 4 if wide else 2),
                          title="measured (marks) and fitted (lines)")
        number = f"_{first // PANELS + 1}" if len(panels) > PANELS else ""
        pictures.save(figure, folder / f"fit{number}.{form.kind}", form)


def mark_of(flight: int) -> str:
    """The mark of what a flight measured."""
    return MARKS[flight % len(MARKS)]


def fitted(flight: int) -> dict[str, Any]:
    """The line of what the fitted system shows in a flight. Where colours begin again, line styles do not."""
    return {"color": colour(flight), "linestyle": LINES[(flight + flight // len(COLOURS)) % len(LINES)],
            "linewidth": 1.2}


def signal(axis: Axes, panel: Panel) -> None:
    """Marks for what was measured, lines for what the fitted system shows."""
    for one in panel.courses:
        axis.plot(one.time, panel.factor * one.measured + panel.offset, mark_of(one.flight), color=colour(one.flight),
                  alpha=0.6, markeredgewidth=0)
        axis.plot(one.time, panel.factor * one.after + panel.offset, **fitted(one.flight))
    axis.set_ylabel(without_math(f"{panel.name}\n({panel.unit or '1'})"))
    axis.yaxis.set_major_formatter(pictures.number)


def residuals(axis: Axes, panel: Panel) -> None:
    """Measured less fitted, with a band of two noise levels."""
    size = abs(panel.factor) * panel.noise
    axis.axhspan(-2 * size, 2 * size, color="0.9", zorder=0)
    axis.axhline(0.0, color="0.5", linewidth=0.8)
    for one in panel.courses:
        axis.plot(one.time, panel.factor * (one.measured - one.after), mark_of(one.flight), color=colour(one.flight),
                  alpha=0.7, markeredgewidth=0)
    axis.set_ylabel(without_math(f"measured less fitted\n({panel.unit or '1'})"))
    axis.yaxis.set_major_formatter(pictures.number)
    axis.set_title(without_math(f"noise level {size:.3g} {panel.unit}".rstrip()) + ", band: two of it", loc="right",
                   fontsize=7)
