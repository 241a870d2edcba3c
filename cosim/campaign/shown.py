"""The runs that are in the report's page, with all that its script knows of them: draws, figures, commands."""
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute

from ..pages.decimate import text
from ..text import shortened
from .criteria import least_is_worst
from .labels import on_axes
from .plan import Plan
from .rerun import words
from .statistics import JUDGED, Results

MOST_RUNS = 5000        # of each variant
ROOM = 900_000          # bytes of draws and figures, before base64 adds a third
MESSAGES = 300_000      # characters of all messages
LONGEST = 300           # characters of one
FULL = "runs.parquet has the message"
NUMBER = re.compile(r"(-?\d+(?:\.\d+)?)")


@dataclass
class Shown:
    """Which runs are in the page: their numbers, ascending, shape (runs,); and their rows, a table for each variant."""
    numbers: np.ndarray
    total: int
    tables: dict[str, pa.Table]
    worst: dict[str, np.ndarray]   # of each variant: places in `numbers`, the worst first, then what was not judged
    texts: list[str] = field(default_factory=list)  # columns as they are in the page, each once

    @property
    def sentence(self) -> str:
        """Which runs are missing; empty if none is."""
        return "" if len(self.numbers) == self.total else (
            f"This page has {len(self.numbers):,} of {self.total:,} runs: failures first, up to half of them, and the "
            "rest at random. All tables, histograms and intervals are of all runs; runs.parquet has every run.")

    def column(self, values: np.ndarray, kind: str) -> int:
        """Where in `texts` this column is: variants that fly the same draws share them."""
        packed = text(values, kind)
        if packed not in self.places:
            self.places[packed] = len(self.texts)
            self.texts.append(packed)
        return self.places[packed]

    def __post_init__(self) -> None:
        self.places: dict[str, int] = {}


def chosen(plan: Plan, runs: pa.Table, results: Sequence[Results]) -> Shown:
    """The runs to show: all, if there is room."""
    column = plan.subject.column
    every = np.unique(runs["run"].to_numpy())
    numbers = len(plan.draws[plan.laws[0]]) * 8 + len(plan.laws) * 4 * (len(plan.metrics) + 2)
    most = min(MOST_RUNS, ROOM // numbers)
    keep = every
    if len(every) > most:
        mixed = np.random.default_rng(0).permutation(every)  # the same page for the same rows
        failed = np.isin(mixed, runs["run"].to_numpy()[~runs["success"].to_numpy(zero_copy_only=False)])
        first = mixed[failed][:most // 2]
        keep = np.sort(np.concatenate([first, mixed[~np.isin(mixed, first)][:most - len(first)]]))
    tables, worst = {}, {}
    for r in results:
        mine = runs.filter(pa.compute.equal(runs[column], r.law))
        tables[r.law] = mine.take(np.searchsorted(mine["run"].to_numpy(), keep))
        order = r.table["run"].to_numpy()[r.worst_order(plan.worst_by, least_is_worst(
            plan.worst_by, plan.campaign.success.values()))]
        order = np.concatenate([order, r.others["run"].to_numpy()])
        worst[r.law] = np.searchsorted(keep, order[np.isin(order, keep)])
    return Shown(keep, len(every), tables, worst)


def packed(plan: Plan, shown: Shown, draws: Sequence[str]) -> dict[str, Any]:
    """What the page's script reads of the runs; `draws` are the columns of draws, with differences of phases."""
    success = [f"success.{name}" for name in plan.campaign.success]
    labels = on_axes(draws, plan.labels)
    statuses = sorted({s for table in shown.tables.values() for s in table["status"].unique().to_pylist()})
    messages = Messages()
    more = ["margin"] if plan.campaign.rare else []
    variants = []
    for law, table in shown.tables.items():
        flown = {d.name for d in plan.draws[law]}
        variants.append({
            "name": law, "worst": text(shown.worst[law], "<u4"),
            "command": [word if isinstance(word, str) else list(word) for word in words(plan, law)],
            "status": text(np.array([statuses.index(s) for s in table["status"].to_pylist()]), "u1"),
            "message": text(np.array([messages.place(m) for m in table["message"].to_pylist()]), "<u4"),
            "departed": text(floats(table["departed_at_s"])),
            "criteria": [text(table[name].to_numpy(zero_copy_only=False), "u1") for name in ("success", *success)],
            "metrics": [text(floats(table[name])) for name in (*plan.metrics, *more)],
            "draws": [drawn(shown, table[name], name in flown) for name in draws]})
    return {
        "numbers": text(shown.numbers, "<u4"), "total": shown.total, "statuses": statuses, "judged": list(JUDGED),
        "templates": list(messages.templates), "messages": messages.found,
        "criteria": [{"name": name, "text": said} for name, said in plan.campaign.success.items()],
        "metrics": [*({"name": name, "unit": metric.unit} for name, metric in plan.metrics.items()),
                    *({"name": name, "unit": ""} for name in more)],
        "draws": [{"name": name, "label": labels[name]} for name in draws],
        "variants": variants, "columns": shown.texts}


def floats(column: pa.ChunkedArray) -> np.ndarray:
    """A column of numbers, NaN where it is empty."""
    return np.asarray(column.to_numpy(), float)


def drawn(shown: Shown, column: pa.ChunkedArray, exact: bool) -> Any:
    """A column of draws: numbers, exact if a command has them, or words with the places of each."""
    if pa.types.is_floating(column.type):
        return {"kind": "f8" if exact else "f4", "at": shown.column(floats(column), "<f8" if exact else "<f4")}
    values = [str(x) for x in column.to_pylist()]
    names = sorted(set(values))
    place = {name: i for i, name in enumerate(names)}
    return {"kind": "u2", "words": names, "at": shown.column(np.array([place[x] for x in values]), "<u2")}


class Messages:
    """Messages that differ in numbers only have their words once."""

    def __init__(self) -> None:
        self.templates: dict[tuple[str, ...], int] = {}
        self.found: list[str] = [""]
        self.places = {"": 0}
        self.left = MESSAGES

    def place(self, message: str | None) -> int:
        """Where in `found` the message is: its template's place and its numbers, separated by bars."""
        message = shortened(message or "", LONGEST)
        if message not in self.places:
            words, numbers = (parts := NUMBER.split(message))[::2], parts[1::2]
            self.left -= len("|".join(numbers)) + (0 if tuple(words) in self.templates else len(message))
            if self.left < 0 and message != FULL:
                self.places[message] = self.place(FULL)
            else:
                template = self.templates.setdefault(tuple(words), len(self.templates))
                self.places[message] = len(self.found)
                self.found.append("|".join([str(template), *numbers]))
        return self.places[message]
