"""Small pictures of a listed run, in its row of the report: each signal over time as a line of an inline SVG."""
from collections.abc import Collection
from html import escape

import numpy as np
import pyarrow as pa
import pyarrow.compute
import pyarrow.parquet as pq

from .labels import Label
from .store import Store

MOST_CURVES = 12
WIDTH, HEIGHT, MOST_POINTS = 220, 70, 200


def small(label: str, time: np.ndarray, values: np.ndarray) -> str:
    """A picture of `values` over `time` (s), both of shape (rows,), as HTML, with its name and its ends in words. Of
    many rows the least and the largest value of each stretch are drawn; empty without a finite value."""
    time, values = thinned(time[np.isfinite(values)], values[np.isfinite(values)])
    if not len(time):
        return ""
    low, high = float(values.min()), float(values.max())
    x = (time - time[0]) / max(time[-1] - time[0], 1e-300) * WIDTH
    y = HEIGHT - (values - low) / max(high - low, 1e-300) * HEIGHT
    points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y))
    ends = f"{low:.6g} to {high:.6g}, {time[0]:.6g} to {time[-1]:.6g} s"
    name = escape(label, quote=True)
    return (f"<figure><svg viewBox='0 -2 {WIDTH} {HEIGHT + 4}' role=img aria-label='{name}: {ends}'>"
            f"<polyline points='{points}'/></svg><figcaption>{name}<br>{ends}</figcaption></figure>")


def thinned(time: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same, or where there are more than MOST_POINTS rows, the least and the largest value of each stretch."""
    if len(time) <= MOST_POINTS:
        return time, values
    chosen: set[int] = {0, len(time) - 1}
    for part in np.array_split(np.arange(len(time)), MOST_POINTS // 2):
        chosen |= {int(part[np.argmin(values[part])]), int(part[np.argmax(values[part])])}
    rows = sorted(chosen)
    return time[rows], values[rows]


class Curves:
    """What was kept over time of the runs numbered `runs`: what is drawn of all (`errors`), and the signals."""

    def __init__(self, store: Store, errors: pa.Table, runs: Collection[int]):
        chosen = pa.array(sorted(runs), pa.int64())
        self.errors = errors.filter(pa.compute.is_in(errors["run"], chosen))
        self.signals = pq.read_table(store.file("signals"), filters=pa.compute.field("run").isin(chosen))
        self.subject, self.labels = store.plan.subject, store.plan.labels

    def said(self, name: str) -> str:
        """A signal with its unit and what the FMU says of it."""
        return self.labels.get(name, Label(name)).said

    def of(self, run: int, variant: str) -> str:
        """The small pictures of a run, as HTML; empty if nothing of it was kept."""
        found = []
        for row in mine(self.errors, self.subject.column, run, variant).to_pylist():
            time = np.array(row["time"], float)
            found += [small(self.said(name) if name == label else label, time, np.array(row[name], float))
                      for name, (label, _) in self.subject.over_time.items()]
        kept = mine(self.signals, self.subject.column, run, variant)
        for name in kept.column_names[3:] if kept.num_rows else ():
            values = kept[name].to_numpy()
            if np.isfinite(values).any() and np.nanmin(values) < np.nanmax(values):
                found.append(small(self.said(name), kept["time"].to_numpy(), values))
        return "".join(found[:MOST_CURVES])


def mine(table: pa.Table, column: str, run: int, variant: str) -> pa.Table:
    """The rows of a run of a variant."""
    return table.filter(pa.compute.and_(pa.compute.equal(table["run"], run), pa.compute.equal(table[column], variant)))
