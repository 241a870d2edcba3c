"""Statistics of the rows: probabilities with confidence intervals, and which draws correlate with failure."""
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute

from .sequential import Sequence

MOST_PHASES = 6
EXPLAINED = "failure_explained"  # in report.json
FEWEST, MOST_GROUPS = 30, 20  # runs that are grouped, and groups of them
JUDGED = ("finished", "departed")  # statuses that say something of the law; the others are failures of the machinery


def interval_text(sampling: str, sequence: Sequence | None = None, samples: str | None = None) -> str:
    """What an interval is worth with a kind of sampling, with a rule that ends the campaign, or with a file of samples.
    """
    if sampling == "grid":
        return "none: the points of a grid are not drawn"
    if sequence:
        return ("at least 95 % confidence, whatever ended the campaign (a confidence sequence: the beta-binomial "
                "mixture of Robbins, in the form of Howard and others)")
    if samples is not None:
        return f"at least 95 % confidence (Clopper and Pearson), if the rows of {samples} are independent draws"
    text = "at least 95 % confidence (Clopper and Pearson, for independent draws)"
    return text if sampling == "random" else \
        f"{text}; {sampling} draws lie more evenly, so that the interval is often wider than it need be"


def interval(successes: int, runs: int) -> tuple[float, float]:
    """An interval that covers the probability of success with at least 95 %, if the draws are independent of each other
    or lie more evenly than that.

    Clopper and Pearson's: Wilson's can cover as little as 84 % where success or failure is rare.
    """
    from scipy.stats import binomtest

    if runs == 0:
        return 0.0, 1.0
    found = binomtest(successes, runs).proportion_ci(0.95, method="exact")
    return float(found.low), float(found.high)


def rank_correlation(name: str, x: np.ndarray, y: np.ndarray) -> float:
    """Spearman's; for a phase, which has no order, the multiple correlation of y's ranks with its sine and cosine.

    For words, which have none either, the root of the share of the ranks' variance that they explain. 0 where x or y
    does not vary, or there are fewer than three pairs. Infinity, as of what never settled, is the largest
    value.
    """
    from scipy.stats import rankdata, spearmanr

    if x.dtype.kind != "f":
        ok = ~np.isnan(y)
        return float(explained(x[ok], rankdata(y[ok])) ** 0.5)
    ok = np.isfinite(x) & ~np.isnan(y)
    x, y = x[ok], y[ok]
    if ok.sum() < 3 or (x == x[0]).all() or (y == y[0]).all():
        return 0.0
    if not name.endswith("_sine_phase"):
        return float(spearmanr(x, y).statistic)
    ranks, waves = rankdata(y), np.column_stack([np.ones_like(x), np.cos(x), np.sin(x)])
    return float(min(1.0, np.std(waves @ np.linalg.lstsq(waves, ranks)[0]) / np.std(ranks)))


def explained(x: np.ndarray, y: np.ndarray) -> float:
    """The share of y's variance, 0 to 1, that x explains by itself: Sobol's index of first order, from the runs as they
    are.

    The runs are put into groups of like x, and the variance between the groups' means is compared with all of it, less
    what chance alone would show (epsilon squared). Any dependence counts, also one that goes up and down, and x may be
    words. 0 where x or y does not vary, of fewer than FEWEST runs, and of more words than groups.
    """
    if y.dtype.kind == "f":
        ok = np.isfinite(y)
        x, y = x[ok], y[ok]
    most = min(MOST_GROUPS, round(len(y) ** 0.5))  # fewer would hide what changes within a group
    words, group = np.unique(x, return_inverse=True)
    if len(words) > most and x.dtype.kind == "f":
        group = np.searchsorted(np.quantile(x, np.arange(1, most) / most), x, side="right")
        group = np.unique(group, return_inverse=True)[1]
    counts = np.bincount(group)
    total = float(((y - y.mean()) ** 2).sum()) if len(y) else 0.0
    if not total > 0 or not 1 < len(counts) <= most or len(y) < FEWEST:
        return 0.0
    between = float(counts @ (np.bincount(group, y) / counts - y.mean()) ** 2)
    by_chance = (len(counts) - 1) * (total - between) / (len(y) - len(counts))
    return min(1.0, max(0.0, (between - by_chance) / total))


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
    """The rows of one law. What is said of the law is said of the judged runs: those that finished or departed."""
    law: str
    columns: dict[str, np.ndarray]  # of the judged runs
    table: pa.Table                 # of the judged runs
    others: pa.Table                # the failures of the machinery
    column: str                     # that names the law
    sequence: Sequence | None = None  # its intervals, where a rule ended the campaign
    drawn: bool = True                # else the runs are the points of a grid

    @classmethod
    def of(cls, law: str, table: pa.Table, column: str, sequence: Sequence | None = None, drawn: bool = True
           ) -> "Results":
        """The rows of `law` in a table of all laws, which are named in `column`."""
        mine = table.filter(pa.compute.equal(table[column], law))
        known = pa.compute.is_in(mine["status"], pa.array(JUDGED))
        judged = mine.filter(known)
        return cls(law, {f.name: judged[f.name].to_numpy() for f in judged.schema
                         if pa.types.is_floating(f.type) or pa.types.is_boolean(f.type)
                         or pa.types.is_integer(f.type)},
                   judged, mine.filter(pa.compute.invert(known)), column, sequence, drawn)

    @property
    def runs(self) -> int:
        """How many runs there are, failures of the machinery too."""
        return self.judged + int(self.others.num_rows)

    @property
    def judged(self) -> int:
        """How many runs finished or departed."""
        return int(self.table.num_rows)

    @property
    def successes(self) -> int:
        """How many runs were successes."""
        return int(self.columns["success"].sum())

    @property
    def probability(self) -> float | None:
        """The share of successes of the judged runs; None without any."""
        return self.successes / self.judged if self.judged else None

    @property
    def interval(self) -> tuple[float, float]:
        """An interval for the probability of success with at least 95 % confidence."""
        return (self.sequence.interval if self.sequence else interval)(self.successes, self.judged)

    def statuses(self) -> dict[str, int]:
        """How many runs ended with each status."""
        counts = [c for t in (self.table, self.others) for c in t["status"].value_counts().to_pylist()]
        return {c["values"]: c["counts"] for c in sorted(counts, key=lambda c: str(c["values"]))}

    def drivers(self, draws: list[str], metric: str | None) -> dict[str, dict[str, float]]:
        """Of each draw its rank correlations with failure and with `metric`, and the share of failure's variance that
        it explains by itself (EXPLAINED); the strongest first."""
        judged = {"failure": (~self.columns["success"].astype(bool)).astype(float)}
        if metric is not None:
            judged[metric] = self.columns[metric]
        found = {}
        for name in (d for d in draws if d in self.table.column_names):
            words = name not in self.columns
            x = np.array(self.table[name].to_pylist(), str) if words else self.columns[name].astype(float)
            found[name] = {**{what: rank_correlation(name, x, values) for what, values in judged.items()},
                           EXPLAINED: explained(x, judged["failure"])}
        return dict(sorted(found.items(), key=lambda item: -max(abs(item[1]["failure"]), item[1][EXPLAINED] ** 0.5)
                           - 1e-3 * abs(item[1].get(metric or "failure", 0.0))))

    def worst(self, metric: str | None, count: int = 10, least: bool = False) -> list[dict[str, Any]]:
        """The first `count` rows of `worst_order`."""
        return list(self.table.take(self.worst_order(metric, least)[:count]).to_pylist())

    def worst_order(self, metric: str | None, least: bool = False) -> np.ndarray:
        """The places of the judged runs: those that did not end first, by how early that was, then by `metric`, if
        there is one: the largest first, or the `least`, those without a value last."""
        finished = np.array([s == "finished" for s in self.table["status"].to_pylist()])
        ended = np.where(finished, np.inf, np.nan_to_num(self.columns["departed_at_s"], nan=0.0))
        by = self.columns["success"].astype(float) if metric is None else \
            np.nan_to_num(self.columns[metric] * (1 if least else -1), nan=np.inf)
        return np.lexsort((np.arange(self.judged), by, ended))

    def summary(self, draws: list[str], metric: str | None, metrics: Iterable[str], noun: str) -> dict[str, Any]:
        """The numbers of report.json for this law, which is a `noun`."""
        quantiles: dict[str, dict[str, float]] = {}
        for name in metrics:
            values = self.columns[name][np.isfinite(self.columns[name])]
            if len(values):
                quantiles[name] = {"median": float(np.median(values)), "p95": float(np.quantile(values, 0.95)),
                                   "max": float(values.max())}
            if endless := int(np.isinf(self.columns[name]).sum()):  # what never settled, or never came: apart
                quantiles[name] = {**quantiles.get(name, {}), "infinite": endless}
        return {"runs": self.runs, "judged": self.judged, "successes": self.successes,
                "failures": {noun: self.judged - self.successes, "machinery": self.runs - self.judged},
                "probability": self.probability, "interval_95": list(self.interval) if self.drawn else None,
                "statuses": self.statuses(), "metrics": quantiles, "drivers": self.drivers(draws, metric)}


def paired(a: Results, b: Results) -> dict[str, int]:
    """How two laws did on the same draws, where both were judged."""
    both, i, j = np.intersect1d(a.table["run"].to_numpy(), b.table["run"].to_numpy(), True, True)
    first, second = a.columns["success"][i].astype(bool), b.columns["success"][j].astype(bool)
    return {"both": int((first & second).sum()), f"only {a.law}": int((first & ~second).sum()),
            f"only {b.law}": int((~first & second).sum()), "neither": int((~first & ~second).sum()),
            "not judged": a.runs - len(both)}
