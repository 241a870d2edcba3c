"""Where the rows of a run go: into memory, or to a Parquet file as they come."""
from pathlib import Path
from typing import Any

import numpy as np

from .wiring import Signal

CHUNK_ROWS = 4096
GROUP_ROWS = 65536      # of a Parquet file: written together
KEPT_ROWS = 20000       # at least so many are kept in memory of a stream, at most twice as many


class Recorder:
    """Keeps all rows in memory. The loop writes into `room`, then calls `took` with the number of rows."""

    def __init__(self, columns: list[Signal]):
        self.columns = columns
        self.rows, self.times = np.empty((CHUNK_ROWS, len(columns))), np.empty(CHUNK_ROWS)
        self.kept: list[tuple[np.ndarray, np.ndarray]] = []

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
        """Keep rows, shape (rows, columns), and their times."""
        self.kept.append((times, rows))

    def finish(self) -> tuple[np.ndarray, np.ndarray]:
        """All times and rows."""
        times, rows = zip(*self.kept)
        self.kept = []
        return np.concatenate(times), np.concatenate(rows)

    def abandon(self) -> None:
        """Close what is open: the run did not start."""


class Stream(Recorder):
    """Writes all rows to a Parquet file; keeps every n-th in memory, n growing with the run, for metrics and figures.

    The file is complete when the run ends, for whatever reason.
    """

    def __init__(self, columns: list[Signal], path: Path):
        super().__init__(columns)
        import pyarrow as pa
        import pyarrow.parquet

        self.arrow = pa
        self.schema = schema(columns)
        self.writer: Any = pyarrow.parquet.ParquetWriter(path, self.schema)
        self.waiting: list[tuple[np.ndarray, np.ndarray]] = []
        self.waiting_rows = self.seen = self.kept_rows = 0
        self.stride = 1

    def keep(self, times: np.ndarray, rows: np.ndarray) -> None:
        self.waiting.append((times, rows))
        self.waiting_rows += len(times)
        if self.waiting_rows >= GROUP_ROWS:
            self.flush()
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

    def flush(self) -> None:
        """Write the waiting rows to the file."""
        if self.waiting:
            times, rows = (np.concatenate(part) for part in zip(*self.waiting))
            self.waiting, self.waiting_rows = [], 0
            self.writer.write_table(self.arrow.Table.from_arrays(
                [self.arrow.array(a) for a in (times, *rows.T)], schema=self.schema))

    def finish(self) -> tuple[np.ndarray, np.ndarray]:
        self.flush()
        self.writer.close()
        if self.kept[-1][0][-1] != self.last[0][0]:
            self.kept.append(self.last)
        return super().finish()

    def abandon(self) -> None:
        self.writer.close()


def schema(columns: list[Signal]) -> Any:
    """Time and the columns, with unit and description of each in its metadata."""
    import pyarrow as pa

    fields = [pa.field("time", pa.float64(), metadata={"unit": "s", "description": "simulated time"})]
    return pa.schema(fields + [pa.field(c.name, pa.float64(), metadata={"unit": c.unit, "description": c.description})
                               for c in columns])
