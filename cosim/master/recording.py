"""Where the rows of a run go: into memory, or to a file as they come."""
import json
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import RunError
from .whole_file import reason, whole
from .wiring import Signal

CHUNK_ROWS = 4096
GROUP_ROWS = 65536      # of a Parquet file: written together
KEPT_ROWS = 20000       # at least so many are kept in memory of a stream, at most twice as many
BATCH_ROWS = 1024       # of an Arrow stream: what a full disk may cost
FLUSH_S = 1.0           # wall time: what a kill may cost a stream
ROWS = ".arrows"        # the ending of an Arrow stream


class NoRoom(RunError):
    """Rows that could not be written; one sentence."""


class Recorder:
    """Keeps all rows in memory. The loop writes into `room`, then calls `took` with the number of rows."""

    def __init__(self, columns: list[Signal]):
        self.columns = columns
        self.rows, self.times = np.empty((CHUNK_ROWS, len(columns))), np.empty(CHUNK_ROWS)
        self.kept: list[tuple[np.ndarray, np.ndarray]] = []
        self.trouble = ""   # after the end: why rows are not where they should be

    def room(self, count: int) -> tuple[np.ndarray, np.ndarray]:
        """Space for `count` rows, at most CHUNK_ROWS + 1, and their times."""
        if count > len(self.times):
            self.rows, self.times = np.empty((count, len(self.columns))), np.empty(count)
        return self.rows, self.times

    def took(self, used: int) -> None:
        """The loop has written `used` rows into the room: keep them."""
        if used:
            self.keep(self.times[:used].copy(), self.rows[:used].copy())

    def add(self, time: float, row: np.ndarray) -> None:
        """One row by itself."""
        rows, times = self.room(1)
        rows[0], times[0] = row, time
        self.took(1)

    def keep(self, times: np.ndarray, rows: np.ndarray) -> None:
        """Keep rows, shape (rows, columns), and their times. Raises NoRoom where they cannot be written."""
        self.kept.append((times, rows))

    def about(self, known: dict[str, Any]) -> None:
        """What is known of the flight before its first row, as JSON goes."""

    def finish(self) -> tuple[np.ndarray, np.ndarray]:
        """All times and rows; `trouble` is set where there is no room for them."""
        times, rows = zip(*self.kept)
        self.kept = []
        return np.concatenate(times), np.concatenate(rows)

    def abandon(self) -> None:
        """Remove what was written: the run did not start."""


class Whole(Recorder):
    """Keeps all rows in memory, in one place, to which the loop writes: `rows` of them at first, more where these do
    not suffice. What `finish` returns is valid until `restart`."""

    def __init__(self, columns: list[Signal], rows: int):
        super().__init__(columns)
        self.rows, self.times = np.empty((rows, len(columns))), np.empty(rows)
        self.used = 0

    def restart(self) -> "Whole":
        """Forget all rows, for another flight."""
        self.used = 0
        return self

    def room(self, count: int) -> tuple[np.ndarray, np.ndarray]:
        if self.used + count > len(self.times):
            more = max(count, len(self.times))
            self.rows = np.concatenate((self.rows[:self.used], np.empty((more, len(self.columns)))))
            self.times = np.concatenate((self.times[:self.used], np.empty(more)))
        return self.rows[self.used:], self.times[self.used:]

    def took(self, used: int) -> None:
        self.used += used

    def finish(self) -> tuple[np.ndarray, np.ndarray]:
        return self.times[:self.used], self.rows[:self.used]


class Thinned(Recorder):
    """Keeps every n-th row in memory, n growing with the run, for metrics and figures."""

    def __init__(self, columns: list[Signal]):
        super().__init__(columns)
        self.seen = self.kept_rows = 0
        self.stride = 1

    def keep(self, times: np.ndarray, rows: np.ndarray) -> None:
        chosen = slice(-self.seen % self.stride, None, self.stride)
        self.seen += len(times)
        self.last = times[-1:].copy(), rows[-1:].copy()
        if len(times[chosen]):
            super().keep(times[chosen].copy(), rows[chosen].copy())
            self.kept_rows += len(self.kept[-1][0])
        if self.kept_rows > 2 * KEPT_ROWS:
            times, rows = super().finish()
            self.kept = [(times[::2].copy(), rows[::2].copy())]
            self.stride, self.kept_rows = 2 * self.stride, len(self.kept[0][0])

    def finish(self) -> tuple[np.ndarray, np.ndarray]:
        if self.kept[-1][0][-1] != self.last[0][0]:
            self.kept.append(self.last)
        return super().finish()


class Stream(Thinned):
    """Writes all rows to an Arrow stream as they come, which can be read after a kill, and thins them in memory.

    At the end the Arrow stream becomes the Parquet file `path`, unless `path` itself ends with .arrows.
    """

    def __init__(self, columns: list[Signal], path: Path):
        super().__init__(columns)
        self.path = path.absolute()
        self.arrows = self.path if path.suffix == ROWS else self.path.with_name(f".{path.name}{ROWS}")
        self.schema = schema(columns)
        self.sink: Any = None
        self.writer: Any = None
        self.waiting: list[tuple[np.ndarray, np.ndarray]] = []
        self.waiting_rows, self.flushed, self.full = 0, time.monotonic(), False

    def about(self, known: dict[str, Any]) -> None:
        self.schema = self.schema.with_metadata({"about": json.dumps(known)})

    def keep(self, times: np.ndarray, rows: np.ndarray) -> None:
        super().keep(times, rows)
        self.waiting.append((times, rows))
        self.waiting_rows += len(times)
        if self.waiting_rows >= CHUNK_ROWS or time.monotonic() - self.flushed >= FLUSH_S:
            self.flush()

    def flush(self) -> None:
        """Write the waiting rows to the file. Raises NoRoom if that fails; nothing more is written then."""
        if not self.waiting or self.full:
            return
        import pyarrow as pa

        times, rows = (np.concatenate(part) for part in zip(*self.waiting))
        self.waiting, self.waiting_rows, self.flushed = [], 0, time.monotonic()
        first = 0
        try:
            if self.writer is None:
                self.sink = pa.OSFile(str(self.arrows), "wb")
                self.writer = pa.ipc.new_stream(self.sink, self.schema,
                                                options=pa.ipc.IpcWriteOptions(compression="lz4"))
            for first in range(0, len(times), BATCH_ROWS):
                part = slice(first, first + BATCH_ROWS)
                self.writer.write_batch(pa.RecordBatch.from_arrays([pa.array(a) for a in (times[part], *rows[part].T)],
                                                                   schema=self.schema))
        except OSError as error:
            self.full = True
            raise NoRoom(f"{self.arrows}: {reason(error)}; rows from t = {times[first]:.6g} s on are lost.") from None

    def close(self) -> None:
        """Close the file."""
        for part in (self.writer, self.sink):
            try:
                if part:
                    part.close()
            except OSError:
                pass  # the end of the stream does not fit: readers do without
        self.writer = self.sink = None

    def finish(self) -> tuple[np.ndarray, np.ndarray]:
        try:
            self.flush()
        except NoRoom as error:
            self.trouble = str(error)
        self.close()
        if self.path != self.arrows:
            try:
                with whole(self.path) as partial:
                    to_parquet(self.arrows, partial)
                self.arrows.unlink()
            except RunError as error:
                self.trouble = f"{str(error).rstrip('.')}; the rows are in {self.arrows}."
        return super().finish()

    def abandon(self) -> None:
        self.close()
        self.arrows.unlink(missing_ok=True)


def schema(columns: list[Signal]) -> Any:
    """Time and the columns, with unit and description of each in its metadata."""
    import pyarrow as pa

    fields = [pa.field("time", pa.float64(), metadata={"unit": "s", "description": "simulated time"})]
    return pa.schema(fields + [pa.field(c.name, pa.float64(), metadata={"unit": c.unit, "description": c.description})
                               for c in columns])


def batches(arrows: Path) -> tuple[Any, Iterator[Any]]:
    """The schema of an Arrow stream and its batches, those that are complete: a kill or a full disk may have cut it.

    Raises OSError or pyarrow.ArrowInvalid if not even the schema is complete.
    """
    import pyarrow as pa

    reader = pa.ipc.open_stream(pa.OSFile(str(arrows)))

    def complete() -> Iterator[Any]:
        while True:
            try:
                batch = reader.read_next_batch()
            except (StopIteration, OSError, pa.ArrowInvalid):
                return
            yield batch

    return reader.schema, complete()


def to_parquet(arrows: Path, path: Path, seen: Callable[[Any], None] = lambda batch: None) -> None:
    """Write the complete batches of an Arrow stream to a Parquet file, GROUP_ROWS together; `seen` is told of each.

    Raises OSError if the file cannot be written.
    """
    import pyarrow as pa
    import pyarrow.parquet

    found, complete = batches(arrows)
    found = found.remove_metadata()
    with pa.parquet.ParquetWriter(path.absolute(), found) as writer:
        waiting: list[Any] = []

        def write() -> None:
            writer.write_table(pa.Table.from_batches(waiting, found).combine_chunks())
            waiting.clear()

        for batch in complete:
            seen(batch)
            waiting.append(batch.replace_schema_metadata(None))
            if sum(b.num_rows for b in waiting) >= GROUP_ROWS:
                write()
        if waiting:
            write()
