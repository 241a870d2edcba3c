"""What a flight with --stream leaves when it is killed, or when the disk is full: rows, and what was asked for."""
import json
from collections.abc import Callable
from contextlib import nullcontext
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from ..errors import RunError, UsageError
from .flight import Flight
from .fly import take_rows
from .folder import claimed, expanded
from .publish import OWN, REQUEST, ROWS, read
from .recording import Thinned, batches
from .whole_file import whole
from .wiring import Signal

Result = TypeVar("Result")


def asked(folder: Path, request: dict[str, Any]) -> Path:
    """The file in a claimed folder that a flight streams its rows to; `request`, as JSON goes, is kept beside it.

    Raises RunError if that cannot be written.
    """
    with whole(folder / OWN / REQUEST) as partial:
        partial.write_text(json.dumps(request) + "\n")
    return folder / OWN / ROWS


def recovered(folder: Path) -> tuple[Flight, dict[str, Any]] | None:
    """The flight of the rows in a claimed folder, and what was asked for; None if there are no rows.

    As a stream's, its rows in memory are a part. Raises RunError if no row is complete: what there was is removed then.
    """
    rows = folder / OWN / ROWS
    if not rows.exists():
        return None
    import pyarrow as pa

    request = read(folder / OWN / REQUEST)
    try:
        schema, complete = batches(rows)
    except (OSError, pa.ArrowInvalid):
        schema, complete = pa.schema([]), iter(())
    if "step_s" not in request:
        raise RunError(f"{folder / OWN / REQUEST} is broken; the rows are in {rows}, an Arrow stream.")
    columns = [Signal(field.name, *(field.metadata[key].decode() for key in (b"unit", b"description")))
               for field in list(schema)[1:]]
    recorder = Thinned(columns)
    for batch in complete:
        times, *signals = (column.to_numpy() for column in batch.columns)
        recorder.keep(times, np.column_stack(signals) if signals else np.empty((len(times), 0)))
    if not recorder.seen:
        rows.unlink()
        raise RunError(f"{folder} had no complete rows of the flight that was killed.")
    known = json.loads(schema.metadata[b"about"])
    flight = Flight(np.empty(0), np.empty((0, len(columns))), columns, False, "", known["startup_s"], 0.0,
                    known["parameters"], known["fmus"], periods=known["periods"])
    take_rows(flight, recorder)
    flight.reached = float(flight.time[-1])
    flight.ticks = round((flight.reached - request.get("start_s", 0.0)) / request["step_s"])
    flight.message = f"The flight was killed; its rows up to t = {flight.reached:.6g} s were recovered."
    return flight, request


def recover(left: Path, out: Path | None, kind: str, keep: Callable[[Path, Flight, dict[str, Any], Path], Result]
            ) -> Result:
    """What `keep` makes, in `out` or there, of the rows that a killed flight left in the folder `left`; it is given the
    claimed folder, the flight, what was asked for, and the file of the rows, which stays if they cannot be written.

    Raises UsageError if there are no such rows, RunError if none is complete or there is no room.
    """
    if not (left := expanded(left)).is_dir():
        raise UsageError(f"There is no folder {left}.")
    with claimed(left, kind, "", recover=True), claimed(out, kind, "") if out else nullcontext(left) as folder:
        if (found := recovered(left)) is None:
            raise UsageError(f"{left} has no rows of a flight that was killed.")
        flight, said = found
        return keep(folder, flight, said, left / OWN / ROWS)
