"""Measured flights: tables whose columns drive inputs of the system, or are compared with its signals."""
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import inf
from pathlib import Path

import numpy as np

from ..errors import UsageError, did_you_mean
from ..master.declared import NUMERIC
from ..master.fmu import FmuFile
from ..master.system import Connection
from ..master.table import Table, inputs_of, read_table

SIGNALS = ("output", "local", "input")  # causalities of what can be compared


@dataclass(frozen=True)
class Measured:
    """One flight's data: `signals` (component.variable -> shape (rows,), NaN in gaps) at `times` (s), and a table of
    the inputs that drive it, if there are any. `file` is what the user calls it."""
    file: str
    times: np.ndarray
    signals: dict[str, np.ndarray]
    inputs: Table | None
    remarks: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class Known:
    """What a table's columns may be: numeric variables by component.variable. `alone` is the component of a system of
    one FMU, whose variables need no component."""
    files: Mapping[str, FmuFile]
    targets: Mapping[str, Connection]
    alone: str | None

    def full(self, name: str) -> str:
        """`component.variable` of a variable's name."""
        return f"{self.alone}.{name}" if self.alone and name in self.files[self.alone].variables else name

    def numeric(self, causalities: Iterable[str]) -> dict[str, str]:
        """The numeric variables of these causalities: component.variable -> causality."""
        return {f"{c}.{n}": v.causality for c, file in self.files.items() for n, v in file.variables.items()
                if v.family in NUMERIC and v.causality in causalities}

    @cached_property
    def driven(self) -> set[str]:
        """The inputs that nothing feeds."""
        return set(self.numeric(["input"])) - set(self.targets)

    @cached_property
    def compared(self) -> set[str]:
        """The signals that can be compared."""
        return set(self.numeric(SIGNALS)) - self.driven

    def shown(self, names: Iterable[str]) -> list[str]:
        """Names as the user says them."""
        prefix = f"{self.alone}." if self.alone else ""
        return [name.removeprefix(prefix) for name in names]


def owner(word: str, files: Sequence[str]) -> tuple[int | None, str]:
    """The place in `files` of the FILE of a word FILE:REST, and REST; None and the word itself for a word without FILE.
    The file's name without its folder will do where it is the only one.

    Raises UsageError for a file that is not among them.
    """
    short = [Path(file).name for file in files]
    for place, file in enumerate(files):
        for prefix in (file, *([short[place]] if short.count(short[place]) == 1 else [])):
            if word.startswith(f"{prefix}:"):
                return place, word[len(prefix) + 1:]
    file, colon, _ = word.partition("=")[0].rpartition(":")
    if colon and Path(file).suffix.lower() in (".csv", ".parquet"):
        raise UsageError(f"{word}: there is no data file {file}{did_you_mean(file, files)}")
    return None, word


def noise_levels(words: Iterable[str], known: Known) -> dict[str, float | None]:
    """Component.variable -> noise level of NAME[:SIGMA] words; None where there is no SIGMA.

    Raises UsageError for an unknown signal, an input that can be driven, or a level that is no positive number.
    """
    found: dict[str, float | None] = {}
    for word in words:
        name, colon, level = word.rpartition(":")
        full = known.full(name if colon else word)
        if known.full(word) in known.compared:
            full, level = known.full(word), ""
        if full in known.driven:
            raise UsageError(f"--signal {word}: {full} is an input that nothing feeds; the data drive it.")
        if full not in known.compared:
            raise UsageError(f"--signal {word}: there is no such signal"
                             f"{did_you_mean(name if colon else word, known.shown(known.compared))}")
        if full in found:
            raise UsageError(f"--signal {word}: {full} is named twice.")
        try:
            size = float(level) if level or (colon and full != known.full(word)) else None
        except ValueError:
            size = 0.0
        if size is not None and not 0 < size < inf:
            raise UsageError(f"--signal {word}: the noise level must be a positive number, in the signal's unit.")
        found[full] = size
    return found


def read_flight(file: str, known: Known, chosen: Iterable[str], start: float) -> Measured:
    """The measured flight in a table; of `chosen` signals (component.variable) only these are compared, else all that
    the table has. `start` (s) is where the flight begins.

    Raises UsageError, one sentence, for a table that is none, has no signal, or has values that do not fit.
    """
    table = read_table(file, gaps=True)
    if len(table.times) < 2:
        raise UsageError(f"{file} has one row; a fit needs at least two.")
    if table.times[0] < start:
        raise UsageError(f"{file} begins at {table.times[0]:g} s, before the flight, which begins at {start:g} s; "
                         f"--start sets another.")
    if table.times[-1] <= start:
        raise UsageError(f"{file} ends at {table.times[-1]:g} s, where the flight begins.")
    wanted, signals, inputs, remarks = set(chosen), {}, {}, []
    for column, values in table.values.items():
        full = known.full(column)
        if full in known.driven:
            inputs[full] = filled(values, full, file, known)
        elif full not in known.compared:
            remarks.append(left_out(file, column, full, known))
        elif (not wanted or full in wanted) and np.isfinite(values).any():
            signals[full] = values
    if table.times[0] - start > table.times[-1] - table.times[0]:
        remarks.append(f"{file} begins at {table.times[0]:g} s, long after the flight, which begins at {start:g} s; "
                       f"--start sets another.")
    if not signals:
        first = next(column for column in table.values)
        which = f"one of {', '.join(known.shown(sorted(wanted)))}" if wanted else "a signal of the system with a value"
        near = did_you_mean(first, known.shown(sorted(known.compared))) if not wanted else "."
        raise UsageError(f"{file}: no column is {which}; its columns are {', '.join(table.values)}{near}")
    driving = replace(table, values=inputs) if inputs else None
    if driving:
        inputs_of(driving, known.files, known.targets)
    return Measured(file, table.times, signals, driving, remarks)


def left_out(file: str, column: str, full: str, known: Known) -> str:
    """A sentence about a column that is no signal."""
    if full in known.numeric(["parameter", "calculatedParameter", "structuralParameter"]):
        return f"{file}: {column} is a parameter and no signal; it is left out. --set {file}:{column}=VALUE sets it."
    return (f"{file}: {column or 'a column without a name'} is no signal of the system and is left out"
            f"{did_you_mean(column, known.shown(sorted(known.compared | known.driven)))}")


def filled(values: np.ndarray, name: str, file: str, known: Known) -> np.ndarray:
    """An input's column without gaps: straight across them if it is continuous, else what it held before.

    Raises UsageError if it has no value at all.
    """
    there = np.flatnonzero(np.isfinite(values))
    if not len(there):
        raise UsageError(f"{file}: the input {name} has no value.")
    component, _, variable = name.partition(".")
    rows = np.arange(len(values))
    if known.files[component].variables[variable].smooth:
        return np.interp(rows, there, values[there])
    return values[there[np.maximum(np.searchsorted(there, rows, "right") - 1, 0)]]
