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
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from ..errors import RunError, UsageError
from ..master.publish import held
from ..master.whole_file import reason, whole
from .plan import Plan
from .receipt import Receipt, Table
from .worker import Outcome

KINDS = ("errors", "signals", "runs")  # in the order in which they are written
OURS = re.compile(rf"\.?({'|'.join(KINDS)}|receipt)-\d{{10}}\.(parquet|json)(\.partial)?")  # what parts/ has of us
GROUP_ROWS = 50_000
CONTINUE = "what was flown until then is kept, and --resume continues"
ARROW: dict[type, pa.DataType] = {float: pa.float64(), bool: pa.bool_(), str: pa.string()}


def schemas(plan: Plan) -> dict[str, pa.Schema]:
    """The columns of each kind of file."""
    key: list[tuple[str, pa.DataType]] = [("run", pa.int64()), (plan.subject.column, pa.string())]
    draws = [(d.name, ARROW.get(type(d.extremes()[0]), pa.float64())) for d in plan.draws[plan.laws[0]]]
    recorded = sorted({name for names in plan.job.record.values() for name in names})
    return {
        "runs": pa.schema([
            *key, ("seed", pa.int64()), *draws, ("status", pa.string()), ("message", pa.string()),
            ("success", pa.bool_()), *((f"success.{name}", pa.bool_()) for name in plan.campaign.success),
            ("ticks", pa.int64()), ("departed_at_s", pa.float64()), *((name, pa.float64()) for name in plan.metrics)]),
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

    @property
    def column(self) -> str:
        """The column that says which variant a row is of."""
        return self.plan.subject.column

    def file(self, kind: str) -> Path:
        """The final file of a kind."""
        return self.folder / f"{kind}.parquet"

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
                              successes=sum(outcome.succeeded for outcome in rows))
            receipt.write(self.part_receipt(first))
        self.done[first] = receipt

    def table(self, kind: str, lines: Iterator[dict[str, Any] | None]) -> pa.Table:
        """Rows of a kind as a table, without those that are None."""
        return pa.Table.from_pylist([line for line in lines if line], schema=self.schemas[kind])

    def line(self, outcome: Outcome) -> dict[str, Any]:
        """An outcome as a row of runs.parquet."""
        request = outcome.request
        return {"run": request.run, self.column: request.law, "seed": self.plan.campaign.seed, **request.drawn,
                "status": outcome.status, "message": outcome.message, "success": outcome.succeeded,
                **{f"success.{name}": outcome.success.get(name, False) for name in self.plan.campaign.success},
                "ticks": outcome.ticks, "departed_at_s": outcome.departed_at_s, **outcome.metrics}

    def errors_line(self, outcome: Outcome) -> dict[str, Any] | None:
        """An outcome as a row of errors.parquet; None if its errors were not kept."""
        request = outcome.request
        return None if outcome.errors is None else {"run": request.run, self.column: request.law, **outcome.errors}

    def signals(self, rows: list[Outcome]) -> pa.Table:
        """The signals that outcomes kept, as rows of signals.parquet."""
        schema, tables = self.schemas["signals"], []
        for outcome in rows:
            if outcome.signals is None:
                continue
            request = outcome.request
            count = len(outcome.signals["time"])
            given = {"run": pa.array([request.run] * count, pa.int64()), self.column: pa.array([request.law] * count),
                     **{name: pa.array(values) for name, values in outcome.signals.items()}}
            tables.append(pa.Table.from_arrays([given.get(f.name, pa.nulls(count, f.type)) for f in schema],
                                               schema=schema))
        return pa.concat_tables(tables) if tables else schema.empty_table()

    def finish(self) -> None:
        """Write the parts as one file of each kind, with their receipt, and remove them.

        Raises RunError if a part was damaged meanwhile, or if the disk is full.
        """
        written = {}
        with self.writing():
            for kind in KINDS:
                rows = 0
                with whole(self.file(kind)) as partial:
                    with pq.ParquetWriter(partial, self.schemas[kind]) as writer:
                        for table in self.gathered(kind):
                            writer.write_table(table)
                            rows += table.num_rows
                    written[kind] = Table.of(partial, rows)
            Receipt(campaign=self.plan.job.key, first=0, tables=written,
                    successes=self.counts()[1]).write(self.receipt)
            self.clear_parts()

    def gathered(self, kind: str) -> Iterator[pa.Table]:
        """The rows of all parts in groups of about GROUP_ROWS. Raises RunError if one does not fit its receipt."""
        waiting: list[pa.Table] = []
        for first, receipt in sorted(self.done.items()):
            if kind in receipt.tables:
                try:
                    receipt.check(kind, self.part(kind, first))
                except ValueError as fault:
                    raise RunError(f"{self.parts}: {fault}; --resume flies its runs again.") from None
                waiting.append(pq.read_table(self.part(kind, first), schema=self.schemas[kind]))
            if sum(t.num_rows for t in waiting) >= GROUP_ROWS:
                yield pa.concat_tables(waiting).combine_chunks()
                waiting = []
        if waiting:
            yield pa.concat_tables(waiting).combine_chunks()

    def counts(self) -> tuple[int, int]:
        """(rows, successes) that are there already."""
        return (sum(r.tables["runs"].rows for r in self.done.values()), sum(r.successes for r in self.done.values()))

