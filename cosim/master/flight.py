"""What a flight left: the signals over time, and how it ended."""
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from ..errors import Interrupted, UsageError, did_you_mean
from .course import Course, terms
from .series import Series
from .wiring import Signal


class NoSuchSignal(UsageError, KeyError):
    """A name that is none of a flight's signals."""
    __str__ = UsageError.__str__  # KeyError would put the sentence in quotes


@dataclass(repr=False)
class Flight:
    """What a run left: one row of `signals` per recorded tick that was completed, the first at the start time.

    `flight["component.variable"]` is one signal, `"component.variable" in flight` and `list(flight)` tell which there
    are. Values are in the units that the FMUs declare. A row shows what each component had last at its time. Rows need
    not be evenly spaced: `course` gives figures that are weighted by time.
    """
    time: np.ndarray                 # (rows,), s
    signals: np.ndarray              # (rows, columns)
    columns: list[Signal]
    finished: bool
    message: str                     # why it ended before its stop, or what failed after; empty if nothing did
    startup_s: float                 # loading and initialising
    wall_s: float                    # ticking
    parameters: dict[str, dict[str, Any]]
    fmus: dict[str, dict[str, str]]
    ticks: int = 0                   # steps that were taken
    reached: float = 0.0             # the end of the last of them, s; it may not be recorded
    lateness: dict[str, float] | None = None   # of a paced run
    ended_at: float | None = None    # s, where an FMU ended the simulation, which counts as finished
    periods: dict[str, float] = field(default_factory=dict)   # s, of the components that do not step in every tick
    remarks: list[str] = field(default_factory=list)   # sentences of whoever had it flown, for `warnings`
    interrupted: int = 0             # the signal that asked for an end, before or after it came to it; 0 if none did

    @cached_property
    def places(self) -> dict[str, int]:
        """Signal name -> its column."""
        return {c.name: i for i, c in enumerate(self.columns)}

    def __getitem__(self, name: str) -> Series:
        """The signal called `component.variable`: an array of shape (rows,) with `.unit`.

        Raises UsageError, which is a KeyError too, if there is no such signal.
        """
        if name not in self.places:
            raise NoSuchSignal(f"This flight has no signal {name}{did_you_mean(name, self.places)}")
        place = self.places[name]
        return Series.of(self.signals[:, place], self.columns[place])

    def __contains__(self, name: object) -> bool:
        return name in self.places

    def __iter__(self) -> Iterator[str]:
        return iter(self.places)

    def has(self, name: str) -> bool:
        """Whether there is a signal called `name`."""
        return name in self

    def together(self, names: Iterable[str]) -> np.ndarray:
        """Which rows, shape (rows,), have the values of these signals at the same time: those at which all of their
        components have just stepped. All rows, if they step in every tick."""
        found = np.ones(len(self.time), bool)
        for period in {self.periods.get(name.partition(".")[0], 0.0) for name in names} - {0.0}:
            elapsed = self.time - self.time[0]
            found &= np.abs(elapsed - np.round(elapsed / period) * period) < 1e-6 * period
        return found

    def course(self, expression: str) -> Course:
        """The course of a signal, or of sums and differences such as `plant.h - controller.h_reference`.

        It has the rows at which all of them are known (see `together`). Raises UsageError for an unknown signal.
        """
        parts = terms(expression, self)
        values = sum(sign * np.asarray(self[name]) for sign, name in parts)
        rows = self.together(name for _, name in parts)
        return Course(self.time[rows], np.asarray(values)[rows])

    def to_arrow(self) -> Any:
        """A pyarrow.Table: time (s) and every signal, with unit and description in each field's metadata."""
        from .results import table

        return table(self)

    def to_pandas(self) -> Any:
        """A pandas.DataFrame: a row per recorded tick, indexed by time (s); `.attrs["units"]` has the units.

        Raises UsageError if pandas is not installed.
        """
        try:
            import pandas
        except ImportError:
            raise UsageError("to_pandas needs pandas, which is not installed: pip install pandas.") from None
        frame = pandas.DataFrame(self.signals, pandas.Index(self.time, name="time"), list(self.places))
        frame.attrs["units"] = {c.name: c.unit for c in self.columns}
        return frame

    def plot(self, *names: str) -> Any:
        """A matplotlib Figure of these signals over time (s), one panel for each unit, in the FMUs' display units.

        A name may be a difference, such as `plant.h - controller.h_reference`; differences have panels of their own.
        Raises UsageError for an unknown signal, no signal at all, or a difference of signals in different units.
        """
        from .plot import plot

        return plot(self, names)

    @property
    def warnings(self) -> list[str]:
        """What a reader should know of the numbers: remarks, and the signals that are not finite, in one sentence."""
        strange = ~np.isfinite(self.signals)
        found = np.flatnonzero(strange.any(axis=0)).tolist()
        if not found:
            return self.remarks
        first, names = int(strange.any(axis=1).argmax()), [self.columns[i].name for i in found]
        more = f" and {len(names) - 5} more signals" if len(names) > 5 else ""
        return [*self.remarks,
                f"{', '.join(names[:5])}{more} {'is' if len(names) == 1 else 'are'} nan or infinite, first at "
                f"t = {self.time[first]:.6g} s: figures made of them tell nothing."]

    def fail(self, why: str) -> None:
        """The flight is not finished, also for the reason `why`, a sentence."""
        self.finished = False
        self.message = f"{self.message.rstrip('.')}; {why}" if self.message else why

    def check_interrupted(self) -> None:
        """Raises Interrupted if a signal asked for an end. For programs that fly many."""
        if self.interrupted:
            raise Interrupted(self.message or "Interrupted when the flight had ended.", self.interrupted)

    @property
    def outcome(self) -> str:
        """What happened, in one sentence."""
        until = f"{self.reached:.6g} s"
        ended = f"ended early: {self.message.rstrip('.')}" if self.message else "finished"
        return f"Flight of {', '.join(self.fmus)} to {until} in {self.ticks} steps, {ended}."

    def __repr__(self) -> str:
        signals = "1 signal" if len(self.columns) == 1 else f"{len(self.columns)} signals"
        return f"<{self.outcome} {len(self.time)} rows of {signals}.>"

    def _repr_html_(self) -> str:
        from .flight_page import page

        return page(self)
