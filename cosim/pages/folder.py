"""Folders of results as flights again."""
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import UsageError
from ..master.flight import Flight
from ..master.folder import kind_of
from ..master.publish import KINDS, OWN, ROWS, read
from ..master.results import SIGNALS
from ..master.wiring import Signal

READ = {"run", "simulate"}


def results(folder: Path) -> dict[Path, tuple[Flight, dict[str, Any]]]:
    """The flights in a folder that `ahv run`, `simulate` or `compare` wrote, by their folders, with their run.json.

    Raises UsageError, one sentence, if there is none or its files cannot be read.
    """
    if not folder.is_dir():
        raise UsageError(f"There is no folder {folder}.")
    kind = kind_of(folder)
    if kind == "compare":
        found = {path: read_flight(path) for path in sorted((folder / "runs").glob("*")) if kind_of(path) in READ}
        if found:
            return found
        raise UsageError(f"{folder} holds a comparison without signals; fly it again.")
    if kind not in READ:
        holds = f"holds {KINDS[kind].words}" if kind else "has no results of ahv"
        raise UsageError(f"{folder} {holds}; what can be seen are folders of ahv run, simulate and compare.")
    return {folder: read_flight(folder)}


def read_flight(folder: Path) -> tuple[Flight, dict[str, Any]]:
    """The flight in a folder that has run.json and signals.parquet. Raises UsageError if they cannot be read."""
    import pyarrow as pa
    import pyarrow.parquet

    record, path = read(folder / "run.json"), folder / SIGNALS
    if not path.is_file():
        if (folder / OWN / ROWS).exists():
            raise UsageError(f"{folder} has rows of a flight that was killed: `ahv recover {folder}` makes results of "
                             f"them.")
        raise UsageError(f"{path} cannot be read: there is no such file.")
    try:
        table = pyarrow.parquet.read_table(path.absolute())
        names = list(table.column_names)
        if not names or names[0] != "time" or not table.num_rows:
            raise ValueError("it has no time")
        columns = [Signal(field.name, text(field.metadata, b"unit"), text(field.metadata, b"description"))
                   for field in list(table.schema)[1:]]
        values = [np.asarray(column.to_numpy(), float) for column in table.columns]
    except (pa.ArrowException, OSError, ValueError, TypeError) as error:
        raise UsageError(f"{path} cannot be read: {' '.join(str(error).split()).rstrip('.')}.") from None
    signals = np.column_stack(values[1:]) if columns else np.empty((len(values[0]), 0))
    number = {key: value for key, value in record.items() if isinstance(value, int | float)}
    flight = Flight(values[0], signals, columns, record.get("finished") is not False, str(record.get("message") or ""),
                    0.0, float(number.get("wall_s", 0.0)), objects(record.get("parameters")),
                    objects(record.get("fmus")), int(number.get("ticks", len(values[0]) - 1)))
    flight.reached = float(number.get("departed_at_s", values[0][-1]))
    flight.remarks = [str(one) for one in record.get("warnings") or () if isinstance(one, str)]
    return flight, record


def text(metadata: dict[bytes, bytes] | None, key: bytes) -> str:
    """A text of a column's metadata; empty if there is none."""
    return (metadata or {}).get(key, b"").decode(errors="replace")


def objects(found: Any) -> dict[str, dict[str, Any]]:
    """Those entries of a JSON object that are objects."""
    return {name: one for name, one in found.items() if isinstance(one, dict)} if isinstance(found, dict) else {}


def named(folders: list[Path]) -> list[str]:
    """A name for each folder: the last part of its path, with as many before it as tell it from the others."""
    paths = [path.resolve() for path in folders]
    for length in range(1, max(len(path.parts) for path in paths) + 1):
        names = ["/".join(path.parts[-length:]) for path in paths]
        if len(set(names)) == len(names):
            return names
    return [f"{path.name} ({i})" for i, path in enumerate(paths, 1)]
