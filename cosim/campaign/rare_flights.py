"""The flights of a campaign of rare failures: a block of points at a time, through the engine and into the store.

The points of a block depend on the margins of all blocks before it and on the seed. So the same rows lead to the same
points: what is there already is read instead of flown, and the report computes its estimate from the rows alone.
"""
from collections.abc import Iterator
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from ..errors import RunError
from .engine import Batch, Engine
from .plan import Plan
from .rare import Estimate, estimate
from .receipt import Receipt
from .sampling import draw
from .store import Store


def fly(engine: Engine, plan: Plan, store: Store) -> Estimate:
    """Fly what the store does not have. Raises RunError if the cluster is lost, or if rows do not fit their points."""
    def margins(first: int, normal: np.ndarray) -> np.ndarray:
        points = plan.job.sampler.at(normal)
        found = np.empty(len(points))
        missing = []
        for a, b, there in pieces(plan, store, first, first + len(points)):
            mine = slice(a - first, b - first)
            if there:
                rows = pq.read_table(store.part("runs", there.first)).slice(a - there.first, b - a)
                found[mine] = known(plan, rows, points[mine], store)
            else:
                missing.append(Batch(plan, a, b, points[mine]))
        engine.run(missing)
        for batch in missing:
            found[batch.first - first:batch.last - first] = [
                np.nan if outcome.margin is None else outcome.margin for outcome in batch.rows]
        return found

    result = of(plan, margins)
    store.front.stopped = result.runs
    return result


def replayed(store: Store, runs: pa.Table) -> Estimate:
    """The estimate of a campaign that is complete. Raises RunError if rows do not fit their points."""
    plan = store.plan

    def margins(first: int, normal: np.ndarray) -> np.ndarray:
        if first + len(normal) > runs.num_rows:
            raise RunError(misfit(store, first))
        return known(plan, runs.slice(first, len(normal)), plan.job.sampler.at(normal), store)

    return of(plan, margins)


def of(plan: Plan, margins: Any) -> Estimate:
    """The estimate by these margins."""
    rare, sampler = plan.campaign.rare, plan.job.sampler
    assert rare is not None
    return estimate(rare, sampler.dimensions, sampler.seed, margins)


def pieces(plan: Plan, store: Store, first: int, last: int) -> Iterator[tuple[int, int, Receipt | None]]:
    """First and past-the-last run of each part of a block that is there, with its receipt; of each task for the rest.
    """
    at = first
    for there in [*sorted((r for r in store.done.values() if r.first < last and r.last > first),
                          key=lambda r: r.first), None]:
        while at < (there.first if there else last):
            end = min(there.first if there else last, at + plan.runs_per_task)
            yield at, end, None
            at = end
        if there:
            yield at, min(there.last, last), there
            at = min(there.last, last)


def known(plan: Plan, rows: pa.Table, points: np.ndarray, store: Store) -> np.ndarray:
    """The margins of rows, NaN where there is none. Raises RunError if the rows are of other points."""
    draws = plan.draws[plan.laws[0]]
    columns = {d.name: rows[d.name].to_pylist() for d in draws}
    for i, u in enumerate(points):
        if any(columns[name][i] != value for name, value in draw(draws, u).items()):
            raise RunError(misfit(store, rows["run"][i].as_py()))
    return rows["margin"].to_numpy().astype(float)


def misfit(store: Store, run: int) -> str:
    """The sentence about a row that is not of the point that is asked for."""
    return (f"{store.folder} does not have the run {run} that this campaign asks for: it was flown with another "
            "version of OpenTURNS or numpy, or changed since.")
