"""A campaign's folder: Parquet parts as tasks come back, one file of each kind at the end.

    campaign.json    what determines the rows         runs.parquet      one row a run and law
    campaign.yaml    the file                         signals.parquet   of the runs whose signals are kept
    parts/           until all is there               errors.parquet    errors over time, for the envelopes
                                                      receipt.json      row count and checksum of each table

A task's receipt is written after its parts: where it exists, the task is complete. The final files are the parts in
order, so they do not depend on which worker flew what, or when.
"""
import re
import shutil
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute
import pyarrow.parquet as pq

from ..errors import RunError, UsageError
from ..master.publish import held
from ..master.whole_file import reason, whole
from .front import Front
from .plan import Plan
from .receipt import Receipt, Table
from .sampling import Draw, keeps_signals
from .worker import Outcome

KINDS = ("errors", "signals", "runs")  # in the order in which they are written
# What parts/ has of us:
OURS = re.compile(rf"\.?({'|'.join(KINDS)}|receipt)-(?P<first>\d{{10}})\.(parquet|json)(?P<partial>\.partial)?")
GROUP_ROWS = 50_000
CONTINUE = "what was flown until then is kept, and --resume continues"
ARROW: dict[type, pa.DataType] = {float: pa.float64(), bool: pa.bool_(), str: pa.string()}


def kind_of(draw: Draw) -> pa.DataType:
    """The type of a draw's column: a double, also of whole numbers, while it holds them exactly."""
    values = draw.extremes()
    large = any(isinstance(x, int) and abs(x) > 2**53 for x in values)
    return pa.int64() if large else ARROW.get(type(values[0]), pa.float64())


def schemas(plan: Plan) -> dict[str, pa.Schema]:
    """The columns of each kind of file."""
    key: list[tuple[str, pa.DataType]] = [("run", pa.int64()), (plan.subject.column, pa.string())]
    draws = [(d.name, kind_of(d)) for d in plan.draws[plan.laws[0]]]
    recorded = sorted({name for names in plan.job.record.values() for name in names})
    return {
        "runs": pa.schema([
            *key, ("seed", pa.int64()), *draws, ("status", pa.string()), ("message", pa.string()),
            ("success", pa.bool_()), *((f"success.{name}", pa.bool_()) for name in plan.campaign.success),
            ("ticks", pa.int64()), ("departed_at_s", pa.float64()), *((name, pa.float64()) for name in plan.metrics),
            *([("margin", pa.float64())] if plan.campaign.rare else [])]),
        "signals": pa.schema([*key, ("time", pa.float64()), *((name, pa.float64()) for name in recorded)]),
        "errors": pa.schema([*key, ("time", pa.list_(pa.float64())),
                             *((name, pa.list_(pa.float32())) for name in plan.subject.over_time)]),
    }


class Store:
    """A campaign's folder."""

    def __init__(self, folder: Path, plan: Plan):
        self.folder, self.plan, self.schemas = folder, plan, schemas(plan)
        self.parts, self.head, self.receipt = folder / "parts", folder / "campaign.json", folder / "receipt.json"
        self.mark = self.parts / ".campaign"  # only in a folder with this file is anything removed
        self.done: dict[int, Receipt] = {}    # of each task that is complete, by its first run
        self.complete = False                 # all tables are there
        self.front = Front(plan.laws, plan.job.most_failures, plan.campaign.stop_when)

    @property
    def column(self) -> str:
        """The column that says which variant a row is of."""
        return self.plan.subject.column

    def file(self, kind: str) -> Path:
        """The final file of a kind."""
        return self.folder / f"{kind}.parquet"

    def tasks(self) -> set[int]:
        """The first runs of the tasks of which there are files in parts/."""
        names = (OURS.fullmatch(path.name) for path in self.parts.glob("*-*"))
        return {int(name["first"]) for name in names if name and not name["partial"]}

    def part(self, kind: str, first: int) -> Path:
        """The part of a kind that the task with the first run `first` writes."""
        return self.parts / f"{kind}-{first:010d}.parquet"

    def part_receipt(self, first: int) -> Path:
        """The receipt of the task with the first run `first`."""
        return self.parts / f"receipt-{first:010d}.json"

    @contextmanager
    def writing(self) -> Iterator[None]:
        """Around whatever writes here. Raises RunError if that is not possible."""
        try:
            yield
        except OSError as error:
            raise RunError(f"{self.folder} cannot be written to: {reason(error)}; {CONTINUE}.") from None
        except RunError as error:
            if isinstance(error.__context__, OSError):  # of `whole`
                raise RunError(f"{str(error).rstrip('.')}; {CONTINUE}.") from None
            raise

    def check_parts(self) -> None:
        """Raises UsageError if parts/ has files of somebody else."""
        if self.parts.exists() and not self.mark.exists() and any(self.parts.iterdir()):
            raise UsageError(f"{self.parts} has files that are not a campaign's: move them, or give another folder "
                             f"with --out.")

    def mark_parts(self) -> None:
        """Make parts/ and mark it as a campaign's."""
        self.parts.mkdir(exist_ok=True)
        self.mark.write_text(f"{self.plan.campaign.name} {self.plan.job.key}\n")

    def clear_parts(self) -> None:
        """Remove from parts/ what a campaign wrote there, and the folder if nothing is left."""
        if self.mark.exists():
            shutil.rmtree(self.parts / "work", ignore_errors=True)  # earlier versions left it there when killed
            for path in self.parts.iterdir():
                if OURS.fullmatch(path.name):
                    path.unlink()
            self.mark.unlink()
            with suppress(OSError):
                self.parts.rmdir()

    def write_head(self, text: str) -> None:
        """Write campaign.yaml, with `text`, and campaign.json."""
        with whole(self.folder / "campaign.yaml") as partial:
            partial.write_text(text)
        with whole(self.head) as partial:
            partial.write_text(self.plan.described)

    def add(self, first: int, rows: list[Outcome]) -> None:
        """The outcomes of the task whose first run is `first`, in order. Raises RunError if the disk is full."""
        tables = {"errors": self.table("errors", map(self.errors_line, rows)), "signals": self.signals(rows),
                  "runs": self.table("runs", map(self.line, rows))}
        written = {}
        with held(), self.writing():  # a signal leaves no parts without a receipt
            for kind in KINDS:
                if tables[kind].num_rows:
                    with whole(self.part(kind, first)) as partial:
                        pq.write_table(tables[kind], partial)
                        written[kind] = Table.of(partial, tables[kind].num_rows)
            receipt = Receipt(campaign=self.plan.job.key, first=first, tables=written,
                              last=first + tables["runs"].num_rows // len(self.plan.laws),
                              successes=sum(outcome.succeeded for outcome in rows))
            receipt.write(self.part_receipt(first))
        self.done[first] = receipt
        if self.front.wanted:
            self.front.add(first, self.front.states(tables["runs"]))

    def table(self, kind: str, lines: Iterator[dict[str, Any] | None]) -> pa.Table:
        """Rows of a kind as a table, without those that are None."""
        return pa.Table.from_pylist([line for line in lines if line], schema=self.schemas[kind])

    def line(self, outcome: Outcome) -> dict[str, Any]:
        """An outcome as a row of runs.parquet."""
        request = outcome.request
        return {"run": request.run, self.column: request.law, "seed": self.plan.campaign.seed, **request.drawn,
                "status": outcome.status, "message": outcome.message, "success": outcome.succeeded,
                **{f"success.{name}": outcome.success.get(name, False) for name in self.plan.campaign.success},
                "ticks": outcome.ticks, "departed_at_s": outcome.departed_at_s, **outcome.metrics,
                **({"margin": outcome.margin} if self.plan.campaign.rare else {})}

    def errors_line(self, outcome: Outcome) -> dict[str, Any] | None:
        """An outcome as a row of errors.parquet; None if its errors were not kept."""
        request = outcome.request
        return None if outcome.errors is None else {"run": request.run, self.column: request.law, **outcome.errors}

    def signals(self, rows: list[Outcome]) -> pa.Table:
        """The signals that outcomes kept, as rows of signals.parquet."""
        schema, tables = self.schemas["signals"], []
        for outcome in rows:
            request = outcome.request
            if outcome.signals is None or not (request.keep or self.front.keeps(request.run, request.law)):
                continue
            count = len(outcome.signals["time"])
            given = {"run": pa.array([request.run] * count, pa.int64()), self.column: pa.array([request.law] * count),
                     **{name: pa.array(values) for name, values in outcome.signals.items()}}
            tables.append(pa.Table.from_arrays([given.get(f.name, pa.nulls(count, f.type)) for f in schema],
                                               schema=schema))
        return pa.concat_tables(tables) if tables else schema.empty_table()

    def missing(self) -> Iterator[tuple[int, int]]:
        """First and past-the-last run of each task that is to be flown, until the campaign is stopped."""
        size, runs, at = self.plan.runs_per_task, self.plan.campaign.runs, 0
        for first, last in [*sorted((r.first, r.last) for r in self.done.values()), (runs, runs)]:
            while at < first and self.front.stopped is None:
                end = min(first, (at // size + 1) * size)
                yield at, end
                at = end
            at = last

    @property
    def last(self) -> int:
        """The number of runs that the tables are to have of each law, once all are there."""
        return self.plan.campaign.runs if self.front.stopped is None else self.front.stopped

    def look_at(self, file: Path, first: int) -> None:
        """Show the front rows of a file like runs.parquet, which begins with run `first`."""
        if self.front.wanted:
            with pq.ParquetFile(file) as rows:
                found = [self.front.states(pa.Table.from_batches([batch]))
                         for batch in rows.iter_batches(GROUP_ROWS, columns=self.front.columns)]
            self.front.add(first, np.concatenate(found))

    def reopen(self, receipt: Receipt) -> None:
        """Make a part of the final tables, so that more can be added. After a kill at any moment it can be done again.
        """
        self.mark_parts()
        receipt.write(self.part_receipt(0))
        for kind in KINDS:
            if self.file(kind).exists():
                self.file(kind).replace(self.part(kind, 0))
        self.receipt.unlink()

    def finish(self) -> None:
        """Write the parts as one file of each kind, with their receipt, and remove them.

        Raises RunError if a part was damaged meanwhile, or if the disk is full.
        """
        written, successes = {}, 0
        with self.writing():
            for kind in KINDS:
                rows = 0
                with whole(self.file(kind)) as partial:
                    with pq.ParquetWriter(partial, self.schemas[kind]) as writer:
                        for table in grouped(self.gathered(kind), GROUP_ROWS):
                            writer.write_table(table)
                            rows += table.num_rows
                            successes += pa.compute.sum(table["success"]).as_py() if kind == "runs" else 0
                    written[kind] = Table.of(partial, rows)
            Receipt(campaign=self.plan.job.key, first=0, last=self.last, tables=written,
                    successes=successes).write(self.receipt)
            self.clear_parts()

    def gathered(self, kind: str) -> Iterator[pa.Table]:
        """The rows of all parts, a few at a time. Raises RunError if a part does not fit its receipt."""
        for first, receipt in sorted(self.done.items()):
            if kind in receipt.tables and first < self.last:
                try:
                    receipt.check(kind, self.part(kind, first))
                except ValueError as fault:
                    raise RunError(f"{self.parts}: {fault}; --resume flies its runs again.") from None
                with pq.ParquetFile(self.part(kind, first)) as file:
                    for batch in file.iter_batches(GROUP_ROWS):
                        yield self.chosen(kind, pa.Table.from_batches([batch]))

    def chosen(self, kind: str, rows: pa.Table) -> pa.Table:
        """The rows that belong to the tables: of runs before the stop, signals of the first failures and of the share.
        """
        run = rows["run"].to_numpy()
        wanted = run < self.last
        if kind == "signals" and self.front.last_kept:
            law = rows[self.plan.subject.column].to_numpy()
            job, shared = self.plan.job, {}
            for name, last in self.front.last_kept.items():
                for k in np.unique(run[late := (law == name) & (run > last)]):
                    shared[k] = keeps_signals(job.sampler.seed, int(k), job.keep_share)
                wanted[late] &= np.array([shared[k] for k in run[late]], bool)
        return rows if wanted.all() else rows.filter(pa.array(wanted))

    def counts(self) -> tuple[int, int]:
        """(rows, successes) that are there already."""
        return (sum(r.tables["runs"].rows for r in self.done.values()), sum(r.successes for r in self.done.values()))


def grouped(tables: Iterable[pa.Table], size: int) -> Iterator[pa.Table]:
    """The rows of `tables` in tables of `size` rows, the last with what is left: the same however they came."""
    waiting: list[pa.Table] = []
    for table in tables:
        waiting.append(table)
        while sum(t.num_rows for t in waiting) >= size:
            together = pa.concat_tables(waiting)
            yield together.slice(0, size).combine_chunks()
            waiting = [together.slice(size)]
    if any(t.num_rows for t in waiting):
        yield pa.concat_tables(waiting).combine_chunks()
