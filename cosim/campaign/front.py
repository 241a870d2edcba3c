"""The runs from the first one on, as far as all are there: what depends on the order of runs is decided on them alone.

So it does not matter which worker flew what, or when: at which run a campaign stops, and which failures are the first.
"""
from collections.abc import Iterable
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute

from .sequential import Sequence, looks
from .spec import StopWhen
from .statistics import JUDGED, Results

WITH_SIGNALS = (*JUDGED, "timed-out")  # statuses of runs that flew: only they have signals to keep
JUDGED_BIT, GOOD_BIT, FAILED_BIT = 1, 2, 4


class Front:
    """What the runs before `end` decide. `most` failures of each law keep their signals."""

    def __init__(self, laws: Iterable[str], most: float, rule: StopWhen | None):
        self.laws, self.most, self.rule = list(laws), most, rule
        self.end = 0
        self.stopped: int | None = None     # the number of runs after which the rule ended the campaign
        self.last_kept: dict[str, int] = {}  # of a law with `most` failures: the run of the last that counts
        self.waiting: dict[int, np.ndarray] = {}
        self.judged, self.good, self.failed = (np.zeros(len(self.laws), np.int64) for _ in range(3))

    @property
    def wanted(self) -> bool:
        """Whether anything depends on the order of runs: else nothing has to be added."""
        return self.rule is not None or 0 < self.most < np.inf

    @property
    def columns(self) -> list[str]:
        """The columns of runs.parquet that `add` needs."""
        return list(dict.fromkeys(["status", "success", self.criterion]))

    @property
    def criterion(self) -> str:
        """The column whose probability the rule is about."""
        return self.rule.column if self.rule else "success"

    def keeps(self, run: int, law: str) -> bool:
        """Whether the signals of a failure are kept, as far as that is known yet."""
        return run <= self.last_kept.get(law, run)

    def states(self, rows: pa.Table) -> np.ndarray:
        """Rows of runs.parquet as one byte each, shape (rows,)."""
        judged, flew = (pa.compute.is_in(rows["status"], pa.array(statuses)).to_numpy()
                        for statuses in (JUDGED, WITH_SIGNALS))
        good, success = (rows[name].to_numpy() for name in (self.criterion, "success"))
        return np.asarray(judged * JUDGED_BIT + (judged & good) * GOOD_BIT + (flew & ~success) * FAILED_BIT, np.uint8)

    def add(self, first: int, states: np.ndarray) -> None:
        """Take the `states` of all laws in the runs from `first` on, in the order of runs.parquet.

        Calls may come in any order; runs that are known already are passed over.
        """
        if first < self.end:
            return
        self.waiting[first] = states.reshape(-1, len(self.laws))
        while self.stopped is None and self.end in self.waiting:
            self.advance(self.waiting.pop(self.end))

    def advance(self, states: np.ndarray) -> None:
        """Take the next runs; shape (runs, laws)."""
        for law, failed, before in zip(self.laws, (states & FAILED_BIT).T, self.failed):
            if (left := self.most - before) > 0 and np.count_nonzero(failed) >= left:
                self.last_kept[law] = self.end + int(np.flatnonzero(failed)[int(left) - 1])
        judged = self.judged + np.cumsum(states & JUDGED_BIT > 0, axis=0)
        good = self.good + np.cumsum(states & GOOD_BIT > 0, axis=0)
        if self.rule:
            sequence = Sequence(self.rule.half_width)
            for look in looks(self.end, self.end + len(states)):
                i = look - self.end - 1
                if all(sequence.narrow(int(s), int(n), self.rule.confidence) for s, n in zip(good[i], judged[i])):
                    self.stopped = look
                    return
        self.end += len(states)
        self.judged, self.good = judged[-1], good[-1]
        self.failed = self.failed + np.count_nonzero(states & FAILED_BIT, axis=0)


def stopping(rule: StopWhen, results: list[Results]) -> dict[str, Any]:
    """What report.json says of the rule: after how many runs it ended, why, and each law's interval by that rule."""
    sequence = Sequence(rule.half_width)
    intervals = {r.law: sequence.interval(int(r.columns[rule.column].sum()), r.judged, rule.confidence)
                 for r in results}
    widest = max((high - low) / 2 for low, high in intervals.values())
    why = "the interval is narrow enough" if widest <= rule.half_width else \
        f"all runs of the file are flown, and the half-width is still {widest:.3g}"
    return {**rule.model_dump(), "after_runs": results[0].runs, "why": why,
            "intervals": {law: list(found) for law, found in intervals.items()}}
