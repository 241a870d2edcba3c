"""The report of a campaign of rare failures: report.json, levels.parquet, figures/levels.png and report.html."""
import json
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute
import pyarrow.parquet as pq
from matplotlib.figure import Figure

from ..master.whole_file import whole
from ..text import html_table, html_text
from . import shown
from .charts import FAILURE, SUCCESS, figure
from .page import commands, introduction, note, number, page, percent, uncertain
from .plan import Plan
from .rare import FAR, Estimate
from .rare_flights import replayed
from .rare_rules import towards
from .report import STRONGEST, about_runs
from .statistics import JUDGED, Results
from .store import Store

SHOWN = 10    # runs with their commands
SEEN = 400    # runs of each level in the picture
INTERVALS = {
    "subset-simulation": "95 %, log-normal, by Au and Beck's bound on the coefficient of variation, for levels that "
                         "depend on each other as much as they can",
    "cross-entropy": "95 %, log-normal, by the coefficient of variation of the weights; too narrow where a part of the "
                     "failures was not found"}


def write(store: Store) -> dict[str, Any]:
    """Write the report into the store's folder; its numbers. Raises RunError if rows do not fit their points."""
    plan, folder = store.plan, store.folder
    runs = pq.read_table(store.file("runs"))
    found = replayed(store, runs)
    summary = numbers(plan, found, runs)
    with whole(folder / "report.json") as partial:
        partial.write_text(json.dumps(summary, indent=2) + "\n")
    with whole(folder / "levels.parquet") as partial:
        pq.write_table(levels(plan, found), partial)
    (folder / "figures").mkdir(exist_ok=True)
    with whole(folder / "figures" / "levels.png") as partial:
        chart(found).savefig(partial, dpi=110, format="png")
    with whole(folder / "report.html") as partial:
        partial.write_text(html(store, summary, found, runs), encoding="utf-8")
    return {**summary, "report": str(folder / "report.html")}


def numbers(plan: Plan, found: Estimate, runs: pa.Table) -> dict[str, Any]:
    """What report.json has."""
    campaign, subject, rare = plan.campaign, plan.subject, plan.campaign.rare
    assert rare is not None
    statuses = {c["values"]: c["counts"] for c in sorted(runs["status"].value_counts().to_pylist(),
                                                         key=lambda c: str(c["values"]))}
    return {
        "campaign": campaign.name, subject.field: subject.name, subject.column: plan.laws[0], "seed": campaign.seed,
        "success": campaign.success, "judged": list(JUDGED), "statuses": statuses,
        "rare": {
            "failure": " and ".join(towards(campaign)), "method": rare.method, "probability": found.probability,
            "coefficient_of_variation": found.variation, "coefficient_of_variation_bound": found.bound,
            "interval_95": list(found.interval), "interval": INTERVALS[rare.method], "runs": found.runs,
            "plain_runs": found.plain_runs, "not_judged": sum(n for s, n in statuses.items() if s not in JUDGED),
            "reason": found.reason, "drivers": drivers(plan, found),
            "levels": [{"first": level.first, "runs": level.last - level.first, "threshold": level.threshold,
                        "probability": level.probability, "failed": level.failed,
                        "margin": dict(zip(("least", "p5", "median", "p95"), level.margins))}
                       for level in found.levels]}}


def last_level(found: Estimate) -> slice:
    """The runs of the last level."""
    return slice(found.levels[-1].first, found.levels[-1].last) if found.levels else slice(0, 0)


def drivers(plan: Plan, found: Estimate) -> dict[str, float]:
    """How far the failures of the last level lie from the median of each draw, in standard deviations of a normal
    distribution; the farthest first. Empty without a failure."""
    from scipy.special import ndtri

    mine = last_level(found)
    failed = found.margins[mine] <= 0
    if not failed.any():
        return {}
    scores = ndtri(plan.job.sampler.at(found.points[mine][failed]))
    weights = found.weights[failed] if len(found.weights) else None
    means = np.average(scores, axis=0, weights=weights)
    names = [d.name for d in plan.draws[plan.laws[0]]]
    return dict(sorted(zip(names, map(float, means)), key=lambda item: -abs(item[1])))


def levels(plan: Plan, found: Estimate) -> pa.Table:
    """A row a run: its level from 1, its margin and its weight, each null where there is none."""
    rare = plan.campaign.rare
    assert rare is not None
    weights = np.full(found.runs, np.nan)
    weights[found.runs - len(found.weights):] = found.weights
    return pa.table({"run": pa.array(range(found.runs), pa.int64()),
                     "level": pa.array([k // rare.runs_per_level + 1 for k in range(found.runs)], pa.int64()),
                     "margin": pa.array(np.where(found.margins >= FAR, np.nan, found.margins), from_pandas=True),
                     "weight": pa.array(weights, from_pandas=True)})


def failures(plan: Plan, found: Estimate, runs: pa.Table) -> list[dict[str, Any]]:
    """The first failures of the last level that has one, as rows."""
    for level in reversed(found.levels):
        failed = level.first + np.flatnonzero(found.margins[level.first:level.last] <= 0)
        if len(failed):
            return list(runs.take(failed[:SHOWN]).to_pylist())
    return []


def chart(found: Estimate) -> Figure:
    """The margins of each level's runs, and the thresholds between levels."""
    made, axes = figure(4.5)
    axis = axes[0, 0]
    margins = np.where(np.abs(found.margins) < FAR, found.margins, np.nan)
    for place, level in enumerate(found.levels, 1):
        mine = margins[level.first:level.last]
        mine = mine[::max(1, len(mine) // SEEN)]
        beside = place + np.linspace(-0.3, 0.3, len(mine))
        for chosen, color, mark, label in ((mine > 0, SUCCESS, ".", "met"), (mine <= 0, FAILURE, "x", "failed")):
            axis.plot(beside[chosen], mine[chosen], mark, ms=3, alpha=0.6, color=color,
                      label=label if place == 1 else None)
        axis.plot([place - 0.4, place + 0.4], [level.threshold] * 2, color="k", lw=1.5,
                  label="threshold" if place == 1 else None)
    axis.axhline(0, color=FAILURE, lw=0.8, ls="--")
    axis.set_xticks(range(1, len(found.levels) + 1))
    axis.set_xlabel("level")
    axis.set_ylabel("margin, in the unit of the criterion (a failure is at most 0)")
    axis.grid(True, axis="y", alpha=0.3)
    axis.legend(fontsize="small", loc="upper right")
    return made


def html(store: Store, summary: dict[str, Any], found: Estimate, runs: pa.Table) -> str:
    """report.html."""
    plan, rare = store.plan, summary["rare"]
    law, draws = plan.laws[0], ["level", *(d.name for d in plan.draws[plan.laws[0]])]
    runs = runs.append_column("level", levels(plan, found)["level"].cast(pa.float64()))
    there = shown.chosen(plan, runs, [Results.of(law, runs, plan.subject.column)])
    there.worst[law] = np.argsort(found.margins[there.numbers], kind="stable")
    data = about_runs(store, there, draws, pq.read_table(store.file("errors")), {})
    data |= {"metric": "margin", "overview": {"probability": [], "histograms": [], "envelopes": None, "sweep": None}}
    names = [*rare["drivers"]]
    data["variants"][0]["strongest"] = [0, *(draws.index(name) for name in (
        *names, *(d for d in draws[1:] if d not in names)))][:STRONGEST]
    low, high = rare["interval_95"]
    outcome = (f"There is no estimate: {html_text(rare['reason'])}." if rare["reason"] else
               f"The probability of failure is {scientific(rare['probability'])} ({low:.3g} to {high:.3g}).")
    head = (f'<p class="outcome{" bad" if rare["reason"] else ""}">{outcome}</p>' + introduction(plan)
            + (note(there.sentence) if there.sentence else ""))
    return page(plan, head, [*sections(plan, summary), *uncertain(plan), *worst(plan, found, runs)], data)


def sections(plan: Plan, summary: dict[str, Any]) -> list[tuple[str, str]]:
    """The sections on the estimate, the levels, and where the failures lie."""
    rare = summary["rare"]
    low, high = rare["interval_95"]
    said = [["probability of failure", scientific(rare["probability"])],
            ["95 % interval", f"{low:.3g} to {high:.3g}"],
            ["coefficient of variation", percent(rare["coefficient_of_variation"])],
            ["its bound", percent(rare["coefficient_of_variation_bound"])],
            ["runs flown", f"{rare['runs']:,}"],
            ["plain runs for the same coefficient of variation", count(rare["plain_runs"])],
            ["not judged", f"{rare['not_judged']:,}"]]
    rows = [[str(i), f"{level['runs']:,}", number(level["threshold"]), scientific(level["probability"]),
             percent(level["failed"]), number(level["margin"]["least"]), number(level["margin"]["median"])]
            for i, level in enumerate(rare["levels"], 1)]
    found = [("The probability of failure",
              note(f"Of {rare['failure']}, by {rare['method']}. Interval: {rare['interval']}.")
              + html_table(("", ""), said)),
             ("The levels", note(
                 "The tenth of a level's runs with the least margins gives its threshold, below which the next level "
                 "flies. At the last level the threshold is 0. A failure is a margin of at most 0; the first panel "
                 "above has the margins of each level.")
              + html_table(("level", "runs", "threshold", "probability of a margin below it", "failed", "least margin",
                            "median margin"), rows))]
    if rare["drivers"]:
        found.append(("Where the failures lie",
                      note("The mean of the last level's failures, in standard deviations from the median of each "
                           "draw.")
                      + html_table(("drawn", "mean"), [(name, f"{x:+.2f}") for name, x in rare["drivers"].items()])))
    return found


def worst(plan: Plan, found: Estimate, runs: pa.Table) -> list[tuple[str, str]]:
    """The section with the commands of some failures."""
    failed = failures(plan, found, runs)
    return [("Failures", note(f"The first {len(failed)} of the last level that has one. Each command repeats its run.")
             + commands(plan, 0, failed))] if failed else []


def scientific(probability: float | None) -> str:
    """A probability that may be very small."""
    return "unknown" if probability is None else f"{probability:.3g}"


def count(runs: float | None) -> str:
    """A number of runs, to the nearest whole one."""
    return "unknown" if runs is None else f"{runs:,.0f}"
