"""Inputs over time from a table: a column for each input, a row for each time.

Between two rows an input that is continuous runs straight, any other holds; before the first row and after the last
one all hold. Of rows at the same time the last counts. A component is given what the table has at the start of its
step.
"""
from collections.abc import Mapping
from dataclasses import dataclass
from os import PathLike
from os.path import isfile
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import UsageError, did_you_mean
from .declared import NUMERIC, Variable
from .fmu import FmuFile
from .quantities import is_number
from .system import Connection, Value, as_path

TIME = "time"
LARGEST = 1 << 30  # bytes of a file


@dataclass(frozen=True)
class Table:
    """`values` at `times` (s), shape (rows,), by name: `component.variable`, or the variable alone where the system has
    one component. `path` is the file, for messages."""
    path: Path
    times: np.ndarray
    values: dict[str, np.ndarray]


@dataclass(frozen=True)
class Inputs:
    """Table columns that fit the inputs of a system: `rows` has shape (rows, inputs), `held` (inputs,) tells which are
    not interpolated."""
    times: np.ndarray
    names: list[str]           # component.variable of each input
    rows: np.ndarray
    held: np.ndarray

    def at(self, time: float) -> dict[str, dict[str, float]]:
        """Component -> input -> value at `time` (s)."""
        values = np.empty(len(self.names))
        found: dict[str, dict[str, float]] = {}
        look_up(self.times, self.rows, self.held, time, 0.0, np.arange(len(self.names), dtype=np.uint32), values)
        for name, value in zip(self.names, values.tolist()):
            component, _, variable = name.partition(".")
            found.setdefault(component, {})[variable] = value
        return found


def look_up(times: Any, rows: Any, held: Any, time: float, early: float, columns: Any, values: Any) -> None:
    """Write what the `columns` have at `time` into `values`; a row counts as reached `early` (s) before its time."""
    low, high = 0, len(times)  # the rows before `low` are reached, those from `high` on are not
    while low < high:
        middle = (low + high) // 2
        if times[middle] <= time + early:
            low = middle + 1
        else:
            high = middle
    last = max(low - 1, 0)
    share = 0.0
    if 0 < low < len(times):
        share = max(0.0, (time - times[last]) / (times[low] - times[last]))
    for i in range(len(columns)):
        c = columns[i]
        values[i] = rows[last, c]
        if share > 0.0 and not held[c]:
            values[i] += share * (rows[low, c] - rows[last, c])


def read_table(path: str | PathLike[str], gaps: bool = False) -> Table:
    """The table in a CSV file (commas, names in the first line) or a Parquet file. With `gaps`, cells may be empty, but
    not those of the time: they are NaN.

    Raises UsageError, one sentence, for a file that is none or has no number in some place.
    """
    import pyarrow as pa
    import pyarrow.csv
    import pyarrow.parquet

    path = as_path(path)
    if not isfile(path):
        raise UsageError(f"There is no table {path}.")
    if path.suffix.lower() not in (".csv", ".parquet"):
        raise UsageError(f"{path} is not a table that is read here: its name must end with .csv or .parquet.")
    try:
        if path.stat().st_size > LARGEST:
            raise UsageError(f"{path} is too large: a table has at most {LARGEST >> 20} MB.")
        found = (pyarrow.parquet.read_table(path.absolute()) if path.suffix.lower() == ".parquet" else
                 pyarrow.csv.read_csv(path.absolute(), convert_options=pyarrow.csv.ConvertOptions(
                     null_values=[""]) if gaps else None))
        names = [name.strip() for name in found.column_names]
    except (pa.ArrowException, ValueError, OSError) as error:
        raise UsageError(f"{path} cannot be read as a table: {' '.join(str(error).split()).rstrip('.')}.") from None
    for name in names:
        if names.count(name) > 1:
            raise UsageError(f"{path} has two columns called {name}.")
    if not names or names[0] != TIME:
        raise UsageError(f"The first column of {path} must be called {TIME}, in seconds"
                         + (f"; it is called {names[0] or 'nothing'}." if names else "; it has none."))
    if len(names) == 1:
        raise UsageError(f"{path} has no column beside {TIME}.")
    if not found.num_rows:
        raise UsageError(f"{path} has no rows.")
    columns = {name: numbers(found.column(i), name, path, gaps and name != TIME) for i, name in enumerate(names)}
    times = columns.pop(TIME)
    back = np.flatnonzero(np.diff(times) < 0)
    if len(back):
        row = int(back[0]) + 1
        raise UsageError(f"{path}: {TIME} goes back from {times[row - 1]:g} s to {times[row]:g} s in row {row + 1}; it "
                         f"must ascend.")
    return Table(path, times, columns)


def numbers(column: Any, name: str, path: Path, gaps: bool = False) -> np.ndarray:
    """A column as finite numbers, shape (rows,); false and true are 0 and 1, with `gaps` empty cells are NaN. Raises
    UsageError for anything else."""
    import pyarrow as pa

    kind = column.type
    if gaps and pa.types.is_null(kind):
        return np.full(len(column), np.nan)
    if not (pa.types.is_integer(kind) or pa.types.is_floating(kind) or pa.types.is_boolean(kind)):
        texts = column.to_pylist()
        row = next((i for i, x in enumerate(texts) if not is_number(str(x))), 0)
        raise UsageError(f"{path}: {name} in row {row + 1} is {texts[row]!r}; it must be a number.")
    if pa.types.is_boolean(kind):
        column = column.cast(pa.uint8())
    empty = column.is_null().to_numpy()
    if empty.any() and not gaps:
        raise UsageError(f"{path}: {name} in row {int(empty.argmax()) + 1} is empty; it must be a number.")
    values = np.asarray(column.to_numpy()).astype(float)
    odd = np.flatnonzero(~np.isfinite(values) & ~empty)
    if len(odd):
        row = int(odd[0])
        raise UsageError(f"{path}: {name} in row {row + 1} is {values[row]}; it must be a finite number.")
    return np.ascontiguousarray(values)


def inputs_of(table: Table, files: Mapping[str, FmuFile], targets: Mapping[str, Connection]) -> Inputs:
    """The columns of `table` as inputs of the FMUs in `files` (component -> file); `targets` are the connected ones.

    Raises UsageError for a column that is no input, for one that is connected, and for a value that its FMU does not
    take.
    """
    known = {f"{c}.{n}" for c, file in files.items() for n in file.names("input")
             if file.variables[n].family in NUMERIC}
    names, held = [], []
    for column, values in table.values.items():
        only = next(iter(files))
        full = f"{only}.{column}" if column not in known and len(files) == 1 else column
        if full not in known:
            shorter = [name.partition(".")[2] for name in known] if len(files) == 1 else known
            raise UsageError(f"{table.path}: {column or 'a column without a name'} is no input that takes numbers"
                             f"{did_you_mean(column, shorter)}")
        if full in names:
            raise UsageError(f"{table.path} has {full} twice.")
        if full in targets:
            raise UsageError(f"{table.path} has the input {full}, which {targets[full].source} feeds.")
        component, _, variable = full.partition(".")
        check_values(table, column, values, files[component], variable, component)
        names.append(full)
        held.append(not files[component].variables[variable].smooth)
    rows = np.ascontiguousarray(np.column_stack(list(table.values.values())))
    return Inputs(table.times, names, rows, np.array(held, bool))


def check_values(table: Table, column: str, values: np.ndarray, file: FmuFile, variable: str, component: str) -> None:
    """Raises UsageError, with the row, for a value that the input does not take."""
    for value in np.unique(values) if not file.variables[variable].smooth else (values.min(), values.max()):
        try:
            file.checked(variable, as_value(float(value), file.variables[variable]), component)
        except UsageError as error:
            row = int(np.flatnonzero(values == value)[0])
            raise UsageError(f"{table.path}, {column} in row {row + 1}: {error}") from None


def as_value(value: float, variable: Variable) -> Value:
    """A number of a table as its input takes it."""
    if variable.family == "Boolean":
        return bool(value) if value in (0.0, 1.0) else value
    return int(value) if variable.family != "Real" and value == int(value) else value
