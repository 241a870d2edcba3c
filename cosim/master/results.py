"""What a flight leaves in its folder: signals.parquet, signals.csv, run.json; figures are `vehicle.figures`' part."""
import platform
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet

from .publish import OWN, ROWS, Fill, Published, publish
from .recording import schema, to_parquet

if TYPE_CHECKING:
    from .flight import Flight

SIGNALS = "signals.parquet"
PACKAGES = ("ahv", "fmpy", "pythonfmu", "numpy", "casadi")


def table(flight: "Flight", decimate: int = 1) -> pa.Table:
    """Every `decimate`-th row and the last, with unit and description of each column in its metadata."""
    rows = sorted({*range(0, len(flight.time), decimate), len(flight.time) - 1})
    arrays = [flight.time[rows], *flight.signals[rows].T]
    return pa.Table.from_arrays([pa.array(a) for a in arrays], schema=schema(flight.columns))


def write(folder: Path, kind: str, flight: "Flight", summary: dict[str, Any], decimate: int = 1,
          extras: Sequence[Fill] = (), streamed: bool = False) -> Published:
    """Publish the signals (or the rows that were `streamed` there), run.json with `summary`, and what `extras` write.

    Raises RunError, one sentence, if there is no room for the signals anywhere.
    """
    record = {
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
    if streamed:
        rows = folder / OWN / ROWS
        return publish(folder, kind, record, lambda place: to_parquet(rows, place / SIGNALS), extras, streamed=True)
    signals = table(flight, decimate)
    return publish(folder, kind, record, lambda place: write_parquet(signals, place / SIGNALS),
                   [lambda place: pyarrow.csv.write_csv(signals, (place / "signals.csv").absolute()), *extras])


def write_parquet(signals: pa.Table, path: Path) -> None:
    """Write a table. Raises OSError."""
    pyarrow.parquet.write_table(signals, path.absolute())  # pyarrow takes ~ at the beginning for the home folder
