"""The curves of runs that are in the report's page: what is drawn over time of all runs, and signals that were kept."""
from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute
import pyarrow.parquet as pq

from ..pages.decimate import kept, rounded, text
from ..pages.flown import Panel
from ..pages.write import arrangement
from .charts import axes_over_time
from .labels import Label
from .plan import Plan
from .shown import Shown
from .store import Store

ERRORS = 450_000              # values over time of all runs: two bytes each, before base64 adds a third
POINTS = 180_000              # of all kept signals: four bytes each
FEWEST, MOST = 60, 2000       # points of one signal of a run
MOST_SIGNALS = 40             # of one run


def packed(store: Store, shown: Shown, errors: pa.Table) -> dict[str, Any]:
    """What the page's script reads of all curves."""
    plan = store.plan
    signals, runs = of_signals(store, shown)
    labels = {name: plan.labels.get(name, Label(name)) for name in (*plan.subject.over_time, *signals)}
    about = {name: {"unit": labels[name].unit, "said": axis} for name, axis in axes_over_time(plan).items()}
    about |= {name: {"unit": labels[name].unit, "said": labels[name].description} for name in signals}
    panels = arrangement(about, [Panel(about[name]["said"], (name,)) for name in plan.subject.over_time])
    return {"about": about, "panels": [{"title": panel.title, "curves": panel.curves} for panel in panels],
            "errors": of_errors(plan, shown, errors), "signals": runs,
            "start": plan.subject.start, "stop": plan.subject.stop}


def of_errors(plan: Plan, shown: Shown, errors: pa.Table) -> dict[str, Any] | None:
    """What is drawn over time: for each variant the runs that have it, how many rows each, and per name their least
    value, step, and rows. All have the same times, but that some end early. None where nothing is drawn."""
    names = list(plan.subject.over_time)
    mine = errors.filter(pa.compute.is_in(errors["run"], pa.array(shown.numbers)))
    if not mine.num_rows:
        return None
    rows = np.diff(mine["time"].combine_chunks().offsets.to_numpy())
    every = max(1, -(-int(rows.sum()) * len(names) // ERRORS))  # of the rows
    longest = mine["time"][int(rows.argmax())].values.to_numpy()
    variants = []
    for law in plan.laws:
        table = mine.filter(pa.compute.equal(mine[plan.subject.column], law))
        counts, found = np.empty(0, int), {}
        for name in names:
            values = table[name].combine_chunks()
            starts = values.offsets.to_numpy()
            counts = -(-np.diff(starts) // every)
            rows = np.concatenate([np.arange(a, b, every) for a, b in pairwise(starts)] or [np.empty(0, int)])
            low, step, steps = rounded(values.values.to_numpy()[rows], np.cumsum(counts) - counts)
            found[name] = {"low": text(low), "step": text(step), "values": text(steps, "<u2")}
        variants.append({"runs": text(np.searchsorted(shown.numbers, table["run"].to_numpy()), "<u4"),
                         "counts": text(counts, "<u2"), "curves": found})
    return {"times": text(longest[::every], "<f4"), "names": names, "variants": variants}


def of_signals(store: Store, shown: Shown) -> tuple[list[str], list[dict[str, Any]]]:
    """The names of kept signals; and of each run that has a place, the worst first, its variant, place and curves."""
    plan, column = store.plan, store.plan.subject.column
    file = pq.ParquetFile(store.file("signals"))
    names = [name for name in file.schema_arrow.names if name not in ("run", column, "time")][:MOST_SIGNALS]
    if not names or not file.metadata.num_rows:
        return names, []
    keys = pq.read_table(store.file("signals"), columns=["run", column]).group_by(["run", column]).aggregate([])
    there = set(zip(keys["run"].to_pylist(), keys[column].to_pylist()))
    ranked = sorted((rank, v, int(place)) for v, law in enumerate(plan.laws)
                    for rank, place in enumerate(shown.worst[law]) if (int(shown.numbers[place]), law) in there)
    ranked = ranked[:POINTS // (FEWEST * len(names))]
    if not ranked:
        return names, []
    points = min(MOST, max(FEWEST, POINTS // (len(ranked) * len(names))))
    wanted = sorted({int(shown.numbers[place]) for _, _, place in ranked})
    table = pq.read_table(store.file("signals"), filters=pa.compute.field("run").isin(wanted))
    found = []
    for _, v, place in ranked:
        mine = table.filter(pa.compute.and_(pa.compute.equal(table["run"], int(shown.numbers[place])),
                                            pa.compute.equal(table[column], plan.laws[v])))
        found.append({"variant": v, "place": place, "curves": curves_of(mine, names, points)})
    return names, found


def curves_of(table: pa.Table, names: Sequence[str], points: int) -> dict[str, Any]:
    """The curves of a run that say something: name -> times and values, or the one value that a signal always has."""
    time, found = table["time"].to_numpy(), {}
    for name in names:
        values = table[name].to_numpy()
        if np.isfinite(values).any():
            rows = kept(values, points)
            (low, begin), (step, tick), steps = rounded(np.concatenate([values[rows], time[rows]]), [0, len(rows)])
            found[name] = [low, step, text(steps[:len(rows)], "<u2"), begin, tick, text(steps[len(rows):], "<u2")]
    return found
