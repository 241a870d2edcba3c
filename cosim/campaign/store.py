"""A campaign's folder: Parquet parts as tasks come back, one file of each kind at the end.

    campaign.json    what determines the rows         runs.parquet      one row a run and law
    campaign.yaml    the file                         signals.parquet   of the runs whose signals are kept
    parts/           until all is there               errors.parquet    errors over time, for the envelopes

A task's part of runs.parquet is written last, and appears as a whole: where it exists, the task is complete. The final
files are the parts in order, so they do not depend on which worker flew what, or when.
"""
import json
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from ..errors import UsageError
from ..master.whole_file import whole
from ..vehicle.metrics import METRICS, OVER_TIME
from .plan import Plan
from .worker import Outcome

KINDS = ("errors", "signals", "runs")  # in the order in which they are written
GROUP_ROWS = 50_000
ARROW: dict[type, pa.DataType] = {float: pa.float64(), bool: pa.bool_(), str: pa.string()}


def schemas(plan: Plan) -> dict[str, pa.Schema]:
    """The columns of each kind of file."""
    key: list[tuple[str, pa.DataType]] = [("run", pa.int64()), ("controller", pa.string())]
    draws = [(d.name, ARROW.get(type(d.extremes()[0]), pa.float64())) for d in plan.draws[plan.laws[0]]]
    recorded = sorted({name for names in plan.job.record.values() for name in names})
    return {
        "runs": pa.schema([
            *key, ("seed", pa.int64()), *draws, ("status", pa.string()), ("message", pa.string()),
            ("success", pa.bool_()), *((f"success.{name}", pa.bool_()) for name in plan.campaign.success),
            ("ticks", pa.int64()), ("departed_at_s", pa.float64()), *((name, pa.float64()) for name in METRICS)]),
        "signals": pa.schema([*key, ("time", pa.float64()), *((name, pa.float64()) for name in recorded)]),
        "errors": pa.schema([*key, ("time", pa.list_(pa.float64())),
                             *((name, pa.list_(pa.float32())) for name in OVER_TIME)]),
    }


class Store:
    """A campaign's folder."""

    def __init__(self, folder: Path, plan: Plan):
        self.folder, self.plan, self.schemas = folder, plan, schemas(plan)
        self.parts = folder / "parts"

    def file(self, kind: str) -> Path:
        """The final file of a kind."""
        return self.folder / f"{kind}.parquet"

    def part(self, kind: str, first: int) -> Path:
        """The part of a kind that the task with the first run `first` writes."""
        return self.parts / f"{kind}-{first:010d}.parquet"

    @property
    def complete(self) -> bool:
        """Whether the campaign is done."""
        return self.file("runs").exists()

    def prepare(self, resume: bool, text: str) -> None:
        """Make the folder ready; `text` is the campaign file's.

        Raises UsageError if it has a campaign already, unless `resume` is set and that campaign is the same.
        """
        head = self.folder / "campaign.json"
        if head.exists() and (self.complete or any(self.parts.glob("runs-*"))):
            if not resume:
                raise UsageError(f"{self.folder} has a campaign already: --resume continues it, --out puts this one "
                                 f"elsewhere.")
            before = json.loads(head.read_text())
            changed = [k for k, v in self.plan.fingerprint.items() if before.get(k) != json.loads(json.dumps(v))]
            if changed:
                raise UsageError(f"{self.folder} has another campaign, which cannot be continued: "
                                 f"{', '.join(changed)} {'has' if len(changed) == 1 else 'have'} changed since.")
        if not self.complete:
            self.parts.mkdir(exist_ok=True)
        (self.folder / "campaign.yaml").write_text(text)
        with whole(head) as partial:
            partial.write_text(json.dumps({"kind": "campaign", **self.plan.fingerprint}, indent=2) + "\n")

    def has(self, first: int) -> bool:
        """Whether the task with the first run `first` is done."""
        return self.part("runs", first).exists()

    def add(self, first: int, rows: list[Outcome]) -> None:
        """The outcomes of the task whose first run is `first`, in order."""
        for kind, lines in (("errors", map(errors_line, rows)), ("runs", map(self.line, rows))):
            table = pa.Table.from_pylist([x for x in lines if x], schema=self.schemas[kind])
            if kind == "runs":  # after everything else
                self.write("signals", first, self.signals(rows))
            self.write(kind, first, table)

    def write(self, kind: str, first: int, table: pa.Table) -> None:
        """Write a part, unless it is empty; runs always."""
        if table.num_rows or kind == "runs":
            with whole(self.part(kind, first)) as partial:
                pq.write_table(table, partial)

    def line(self, outcome: Outcome) -> dict[str, Any]:
        """An outcome as a row of runs.parquet."""
        request = outcome.request
        return {"run": request.run, "controller": request.law, "seed": self.plan.campaign.seed, **request.drawn,
                "status": outcome.status, "message": outcome.message, "success": outcome.succeeded,
                **{f"success.{name}": outcome.success.get(name, False) for name in self.plan.campaign.success},
                "ticks": outcome.ticks, "departed_at_s": outcome.departed_at_s, **outcome.metrics}

    def signals(self, rows: list[Outcome]) -> pa.Table:
        """The signals that outcomes kept, as rows of signals.parquet."""
        schema, tables = self.schemas["signals"], []
        for outcome in rows:
            if outcome.signals is None:
                continue
            request = outcome.request
            count = len(outcome.signals["time"])
            given = {"run": pa.array([request.run] * count, pa.int64()), "controller": pa.array([request.law] * count),
                     **{name: pa.array(column) for name, column in outcome.signals.items()}}
            tables.append(pa.Table.from_arrays([given.get(f.name, pa.nulls(count, f.type)) for f in schema],
                                               schema=schema))
        return pa.concat_tables(tables) if tables else schema.empty_table()

    def finish(self) -> None:
        """Write the parts as one file of each kind, runs.parquet last, and remove them."""
        for kind in KINDS:
            with whole(self.file(kind)) as partial, pq.ParquetWriter(partial, self.schemas[kind]) as writer:
                for table in self.gathered(kind):
                    writer.write_table(table)
        shutil.rmtree(self.parts, ignore_errors=True)

    def gathered(self, kind: str) -> Iterator[pa.Table]:
        """The rows of all parts in groups of about GROUP_ROWS."""
        waiting: list[pa.Table] = []
        for first, _ in self.plan.batches():
            if self.part(kind, first).exists():
                waiting.append(pq.read_table(self.part(kind, first), schema=self.schemas[kind]))
            if sum(t.num_rows for t in waiting) >= GROUP_ROWS:
                yield pa.concat_tables(waiting).combine_chunks()
                waiting = []
        if waiting:
            yield pa.concat_tables(waiting).combine_chunks()

    def counts(self) -> tuple[int, int]:
        """(rows, successes) that are there already."""
        rows = successes = 0
        for first, _ in self.plan.batches():
            if self.has(first):
                column = pq.read_table(self.part("runs", first), columns=["success"])["success"]
                rows, successes = rows + len(column), successes + sum(column.to_pylist())
        return rows, successes


def errors_line(outcome: Outcome) -> dict[str, Any] | None:
    """An outcome as a row of errors.parquet; None if its errors were not kept."""
    request = outcome.request
    return None if outcome.errors is None else {"run": request.run, "controller": request.law, **outcome.errors}
