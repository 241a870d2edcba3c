"""Signals of a flight over time, one panel for each unit and one for its differences."""
from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from matplotlib.figure import Figure  # without pyplot, which keeps every figure

from .. import pictures
from ..errors import UsageError
from ..pictures import PNG, Format
from ..text import without_math
from .course import terms

if TYPE_CHECKING:
    from .flight import Flight

CURVES, PANELS = 8, 6


class Picture(Figure):
    """A figure that a notebook shows by itself."""

    def _repr_png_(self) -> bytes:
        content = BytesIO()
        self.savefig(content, format="png")
        return content.getvalue()


class Curve(NamedTuple):
    """A signal, or a difference of two, over time (s), with its values in the unit that is shown."""
    label: str
    unit: str           # empty where there is none
    difference: bool    # much smaller than the signals, as a rule: not in the same panel
    time: np.ndarray
    values: np.ndarray


def curve(flight: "Flight", expression: str) -> Curve:
    """The curve of `a` or `a - b`. Raises UsageError for unknown signals, or different units."""
    signals = [flight[name] for _, name in terms(expression, flight)]
    course, first = flight.course(expression), signals[0]
    unit = "" if first.unit == "1" else first.display_unit
    for other in signals[1:]:
        if first.unit != other.unit and first.unit and other.unit:
            raise UsageError(f"{expression} cannot be drawn: {first.name} is in {first.unit}, {other.name} in "
                             f"{other.unit}.")
    offset = first.signal.display_offset if len(signals) == 1 else 0.0
    return Curve(expression, unit, len(signals) > 1, course.time,
                 course.values * first.signal.display_factor + offset)


def plot(flight: "Flight", names: Sequence[str]) -> Figure:
    """See `Flight.plot`."""
    if not names:
        raise UsageError("Name at least one signal to plot; list(flight) has all of them.")
    panels: dict[tuple[str, bool], list[Curve]] = {}
    for name in names:
        found = curve(flight, name)
        panels.setdefault((found.unit, found.difference), []).append(found)
    return drawn(flight, [(unit, curves) for (unit, _), curves in panels.items()])


def drawn(flight: "Flight", panels: Sequence[tuple[str, list[Curve]]], columns: int = 2) -> Figure:
    """A figure with these panels above each other: the unit and the curves of each. Equal curves are one."""
    shown = [pictures.Panel(without_math(unit or "1"), pictures.merged(
        [pictures.Curve(without_math(one.label), one.time, one.values) for one in curves]), 1.6)
        for unit, curves in panels]
    ended = f"ended at {flight.reached:.6g} s" if flight.message else ""
    return pictures.over_time(shown, ended, columns, kind=Picture)


def draw_all(flight: "Flight", folder: Path, form: Format = PNG) -> list[Path]:
    """Draw all signals into `folder`, which is made: signals that share a unit in one panel, at most CURVES in a panel
    and PANELS in a picture; the pictures' paths. A flight without signals has none.

    Raises OSError if a picture cannot be written.
    """
    by_unit: dict[str, list[Curve]] = {}
    for name in flight:
        found = curve(flight, name)
        by_unit.setdefault(found.unit, []).append(found)
    panels = [(unit, curves[i:i + CURVES]) for unit, curves in by_unit.items() for i in range(0, len(curves), CURVES)]
    folder.mkdir(exist_ok=True)
    written = []
    for i in range(0, len(panels), PANELS):
        stem = f"signals{f'_{i // PANELS + 1}' if len(panels) > PANELS else ''}"
        written.append(pictures.save(drawn(flight, panels[i:i + PANELS], form.columns), folder / stem, form))
    return written
