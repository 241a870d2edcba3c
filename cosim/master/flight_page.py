"""A flight as a notebook shows it."""
import numpy as np

from .flight import Flight, outcome
from .text import html_table, html_text

MOST_ROWS = 200


def page(flight: Flight) -> str:
    """HTML: what happened, the components, and every signal with unit, first, last, least and largest value."""
    parts = html_table(("component", "model", "file", "made by"),
                       [(name, fmu["model"], fmu["file"], fmu["generation_tool"]) for name, fmu in flight.fmus.items()])
    more = len(flight.columns) - MOST_ROWS
    rest = f"<p>and {more} more signals</p>" if more > 0 else ""
    signals = html_table(("signal", "unit", "first", "last", "min", "max", "description"),
                         [row(flight, name) for name in list(flight)[:MOST_ROWS]])
    return f"<p><b>{html_text(outcome(flight))}</b></p>{parts}{signals}{rest}"


def row(flight: Flight, name: str) -> tuple[object, ...]:
    series = flight[name]
    values = np.asarray(series)
    ends = [float(x) for x in (values[0], values[-1], values.min(), values.max())] if len(values) else [None] * 4
    return name, series.unit, *ends, series.description
