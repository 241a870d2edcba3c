"""What a flight leaves in its folder: signals.parquet, signals.csv, run.json; figures are `vehicle.figures`' part."""
import platform
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet

from .publish import Fill, Published, publish
from .recording import schema, to_parquet

if TYPE_CHECKING:
    from .flight import Flight

SIGNALS = "signals.parquet"
HEAD_BYTES = 65536  # a run.json has about 14,000
PACKAGES = ("ahv", "fmpy", "pythonfmu", "numpy", "casadi")


def table(flight: "Flight", decimate: int = 1) -> pa.Table:
    """Every `decimate`-th row and the last, with unit and description of each column in its metadata."""
    rows = np.arange(0, len(flight.time), decimate)
    if rows[-1] != len(flight.time) - 1:
        rows = np.append(rows, len(flight.time) - 1)
    columns = np.ascontiguousarray((flight.signals if len(rows) == len(flight.time) else flight.signals[rows]).T)
    return pa.Table.from_arrays([pa.array(a) for a in (flight.time[rows], *columns)], schema=schema(flight.columns))


def write(folder: Path, kind: str, flight: "Flight", summary: dict[str, Any], decimate: int = 1,
          extras: Sequence[Fill] = (), rows: Path | None = None) -> Published:
    """Publish the signals (those in the Arrow stream `rows`, if there is one), run.json with `summary`, and `extras`.
    See `publish`."""
    record = record_of(flight, summary)
    if rows:
        return publish(folder, kind, record, lambda place: to_parquet(rows, place / SIGNALS), extras, rows=rows,
                       interrupted=flight.interrupted)
    signals = table(flight, decimate)
    return publish(folder, kind, record, lambda place: write_parquet(signals, place / SIGNALS),
                   [lambda place: pyarrow.csv.write_csv(signals, (place / "signals.csv").absolute()), *extras],
                   lambda place: write_first(signals, place / SIGNALS))


def record_of(flight: "Flight", summary: dict[str, Any]) -> dict[str, Any]:
    """What run.json says: the summary, and all that the flight knows but for its rows."""
    return {
        **summary,
        "message": flight.message,
        "warnings": flight.warnings,
        "wall_s": flight.wall_s,
        "startup_s": flight.startup_s,
        "fmus": flight.fmus,
        "parameters": flight.parameters,
        "signals": {c.name: {"unit": c.unit, "description": c.description} for c in flight.columns},
        "versions": {"python": platform.python_version(), **{name: version(name) for name in PACKAGES}},
    }


def write_parquet(signals: pa.Table, path: Path) -> None:
    """Write a table. Raises OSError."""
    pyarrow.parquet.write_table(signals, path.absolute())  # pyarrow takes ~ at the beginning for the home folder


def write_first(signals: pa.Table, path: Path) -> None:
    """Write the first rows of a table, as many as fit beside the head. Raises OSError if none do."""
    head = path.with_name("room")
    head.write_bytes(bytes(HEAD_BYTES))
    while True:
        signals = signals.slice(0, signals.num_rows // 2)
        try:
            write_parquet(signals, path)
        except OSError:
            path.unlink(missing_ok=True)
            if signals.num_rows < 2:
                raise
        else:
            head.unlink()
            return
