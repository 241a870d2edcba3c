"""A flight as a notebook shows it."""
from typing import TYPE_CHECKING

import numpy as np

from ..text import html_table, html_text

if TYPE_CHECKING:
    from .flight import Flight

MOST_ROWS = 200


def page(flight: "Flight") -> str:
    """HTML: what happened, the components, and every signal with unit, first, last, least and largest value."""
    parts = html_table(("component", "model", "file", "made by"),
                       [(name, fmu["model"], fmu["file"], fmu["generation_tool"]) for name, fmu in flight.fmus.items()])
    more = len(flight.columns) - MOST_ROWS
    rest = f"<p>and {more} more signals</p>" if more > 0 else ""
    signals = html_table(("signal", "unit", "first", "last", "min", "max", "description"),
                         [row(flight, name) for name in list(flight)[:MOST_ROWS]])
    return f"<p><b>{html_text(flight.outcome)}</b></p>{parts}{signals}{rest}"


def row(flight: "Flight", name: str) -> tuple[object, ...]:
    """One signal with unit, first, last, least and largest value, and description."""
    series = flight[name]
    values = np.asarray(series)
    ends = [float(x) for x in (values[0], values[-1], values.min(), values.max())] if len(values) else [None] * 4
    return name, series.unit, *ends, series.description
