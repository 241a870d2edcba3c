"""What a page is given: flights, and what a room knows of its own ones."""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..master.course import Course
from ..master.flight import Flight

NARROW = 1 / 400  # of a flight: windows that are nearer to each other look like one


@dataclass(frozen=True)
class Mark:
    """Something that happened: at `begin` (s), or from there to `end`. Marks of a kind are shown or hidden at once."""
    kind: str
    text: str
    begin: float
    end: float | None = None


@dataclass(frozen=True)
class Curve:
    """A curve that is no signal of the flight, such as an error."""
    course: Course
    unit: str
    description: str = ""


@dataclass(frozen=True)
class Panel:
    """Curves over each other, by name, with a title. Names that no flight has are left out."""
    title: str
    curves: tuple[str, ...]


@dataclass(frozen=True)
class Flown:
    """A flight as pages show it: its name there, what run.json says of it, and what its room adds."""
    name: str
    flight: Flight
    record: Mapping[str, Any]
    curves: Mapping[str, Curve] = field(default_factory=dict)
    marks: Sequence[Mark] = ()


def windows(kind: str, text: str, time: np.ndarray, holds: np.ndarray) -> list[Mark]:
    """A mark for each time during which a condition holds; both arguments have shape (rows,). What holds at a row held
    in the step that ended there. Times that are NARROW apart are one mark, whose text says so."""
    rows = np.flatnonzero(np.asarray(holds) != 0)
    if not len(rows):
        return []
    span = float(time[-1] - time[0])
    begins, ends = time[np.maximum(rows - 1, 0)], time[rows]
    apart = np.flatnonzero(begins[1:] - ends[:-1] > NARROW * span)
    first, last = np.concatenate(([0], apart + 1)), np.concatenate((apart, [len(rows) - 1]))
    return [Mark(kind, text if np.all(begins[i + 1:j + 1] <= ends[i:j]) else f"{text}, with pauses", float(begins[i]),
                 float(ends[j])) for i, j in zip(first, last)]


def ending(flight: Flight) -> list[Mark]:
    """The mark of a flight that ended early."""
    return [] if flight.finished else [Mark("end", f"Ended: {flight.message}", flight.reached)]
