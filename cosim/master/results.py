"""Writes a run to its folder: signals.parquet, signals.csv, run.json, figures/*.png."""
import json
import platform
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet

from ..errors import UsageError
from .recording import schema

if TYPE_CHECKING:
    from .flight import Flight

PACKAGES = ("ahv", "fmpy", "pythonfmu", "numpy", "casadi")


def prepare_folder(out: Path) -> None:
    """Make `out` and see that it can be written to; UsageError if not, before anything flies."""
    try:
        out.mkdir(parents=True, exist_ok=True)
        probe = out / ".probe"
        probe.touch()
        probe.unlink()
    except OSError as error:
        raise UsageError(f"--out {out} cannot be written to: {error.strerror}.") from None


def table(flight: "Flight", decimate: int = 1) -> pa.Table:
    """Every `decimate`-th row and the last, with unit and description of each column in its metadata."""
    rows = sorted({*range(0, len(flight.time), decimate), len(flight.time) - 1})
    arrays = [flight.time[rows], *flight.signals[rows].T]
    return pa.Table.from_arrays([pa.array(a) for a in arrays], schema=schema(flight.columns))


def write(out: Path, flight: "Flight", summary: dict[str, Any], decimate: int = 1, streamed: bool = False) -> None:
    """Write the signals (unless they were `streamed` there) and run.json below `out`; figures are `vehicle.figures`'
    part."""
    if not streamed:
        signals = table(flight, decimate)
        pyarrow.parquet.write_table(signals, out / "signals.parquet")
        pyarrow.csv.write_csv(signals, out / "signals.csv")
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
    (out / "run.json").write_text(json.dumps(record, indent=2) + "\n")
