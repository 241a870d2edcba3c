"""Statistics of the rows: probabilities with confidence intervals, and which draws correlate with failure."""
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute

from .criteria import METRICS

MOST_PHASES = 6
Z_95 = 1.959963984540054


def wilson(successes: int, runs: int) -> tuple[float, float]:
    """95 % confidence interval of a probability (Wilson's score interval)."""
    if runs == 0:
        return 0.0, 1.0
    p, z2 = successes / runs, Z_95**2
    middle = (p + z2 / (2 * runs)) / (1 + z2 / runs)
    half = Z_95 / (1 + z2 / runs) * (p * (1 - p) / runs + z2 / (4 * runs**2))**0.5
    return (0.0 if successes == 0 else middle - half), (1.0 if successes == runs else middle + half)


def correlation(x: np.ndarray, y: np.ndarray) -> float:
    """Pearson's; 0 where one does not vary."""
    a, b = x - x.mean(), y - y.mean()
    size = float(np.sqrt((a @ a) * (b @ b)))
    return float(a @ b) / size if size > 0 else 0.0


def rank_correlation(name: str, x: np.ndarray, y: np.ndarray) -> float:
    """Spearman's; for a phase, which has no order, the multiple correlation of y's ranks with its sine and cosine."""
    from scipy.stats import rankdata

    ok = np.isfinite(x) & np.isfinite(y)
    if ok.sum() < 3:
        return 0.0
    x, ranks = x[ok], rankdata(y[ok])
    if not name.endswith("_sine_phase"):
        return correlation(rankdata(x), ranks)
    c, s, cs = correlation(np.cos(x), ranks), correlation(np.sin(x), ranks), correlation(np.cos(x), np.sin(x))
    return float(np.sqrt(min(1.0, max(0.0, (c * c + s * s - 2 * c * s * cs) / max(1 - cs * cs, 1e-12)))))


def with_differences(table: pa.Table, draws: list[str]) -> tuple[pa.Table, list[str]]:
    """The rows and draws with the differences of phases, two at a time: groups that swing against each other."""
    phases = [name for name in draws if name.endswith("_sine_phase")][:MOST_PHASES]
    for a, b in combinations(phases, 2):
        difference = np.mod(table[a].to_numpy() - table[b].to_numpy(), 2 * np.pi)
        draws = [*draws, f"{a.removesuffix('_sine_phase')} - {b.partition('.')[2]}"]
        table = table.append_column(draws[-1], pa.array(difference))
    return table, draws


@dataclass
class Results:
    """The rows of one law, as arrays."""
    law: str
    columns: dict[str, np.ndarray]
    table: pa.Table

    @classmethod
    def of(cls, law: str, table: pa.Table) -> "Results":
        """The rows of `law` in a table of all laws."""
        mine = table.filter(pa.compute.equal(table["controller"], law))
        return cls(law, {f.name: mine[f.name].to_numpy() for f in mine.schema
                         if pa.types.is_floating(f.type) or pa.types.is_boolean(f.type)}, mine)

    @property
    def runs(self) -> int:
        """How many runs were flown."""
        return int(self.table.num_rows)

    @property
    def successes(self) -> int:
        """How many of them were successes."""
        return int(self.columns["success"].sum())

    def statuses(self) -> dict[str, int]:
        """How many runs ended with each status."""
        counts = self.table["status"].value_counts().to_pylist()
        return {c["values"]: c["counts"] for c in sorted(counts, key=lambda c: str(c["values"]))}

    def drivers(self, draws: list[str], metric: str) -> dict[str, dict[str, float]]:
        """Rank correlations of failure, and of `metric`, with each draw that is a number; the strongest first."""
        failed = (~self.columns["success"].astype(bool)).astype(float)
        found = {name: {"failure": rank_correlation(name, self.columns[name].astype(float), failed),
                        metric: rank_correlation(name, self.columns[name].astype(float), self.columns[metric])}
                 for name in draws if name in self.columns}
        return dict(sorted(found.items(), key=lambda item: -abs(item[1]["failure"]) - 1e-3 * abs(item[1][metric])))

    def worst(self, metric: str, count: int = 10) -> list[dict[str, Any]]:
        """Rows: those that did not end first, by how early that was, then by `metric`."""
        finished = np.array([s == "finished" for s in self.table["status"].to_pylist()])
        ended = np.where(finished, np.inf, np.nan_to_num(self.columns["departed_at_s"], nan=0.0))
        order = np.lexsort((np.arange(self.runs), -np.nan_to_num(self.columns[metric]), ended))
        return list(self.table.take(order[:count]).to_pylist())

    def summary(self, draws: list[str], metric: str) -> dict[str, Any]:
        """The numbers of report.json for this law."""
        low, high = wilson(self.successes, self.runs)
        quantiles = {}
        for name in METRICS:
            values = self.columns[name][np.isfinite(self.columns[name])]
            if len(values):
                quantiles[name] = {"median": float(np.median(values)), "p95": float(np.quantile(values, 0.95)),
                                   "max": float(values.max())}
        return {"runs": self.runs, "successes": self.successes, "probability": self.successes / self.runs,
                "interval_95": [low, high], "statuses": self.statuses(), "metrics": quantiles,
                "drivers": self.drivers(draws, metric)}


def paired(a: Results, b: Results) -> dict[str, int]:
    """How two laws did on the same draws."""
    first, second = (r.columns["success"].astype(bool) for r in (a, b))
    return {"both": int((first & second).sum()), f"only {a.law}": int((first & ~second).sum()),
            f"only {b.law}": int((~first & second).sum()), "neither": int((~first & ~second).sum())}
