"""The report: report.html (one file, all inside), figures/*.png and report.json."""
import json
from collections.abc import Mapping, Sequence
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from ..master.whole_file import whole
from ..text import html_table
from . import charts, curves, grid, shown
from .criteria import least_is_worst
from .front import stopping
from .overview import overview
from .page import commands, drivers, ended, introduction, note, outcomes, page, place, side_by_side, uncertain
from .plan import Plan
from .sequential import Sequence as Confidence
from .statistics import JUDGED, Results, interval_text, paired, with_differences
from .store import Store

STRONGEST = 12  # draws against which a figure can be drawn


def write(store: Store) -> dict[str, Any]:
    """Write the report into the store's folder; its numbers."""
    plan, folder = store.plan, store.folder
    runs, errors = pq.read_table(store.file("runs")), pq.read_table(store.file("errors"))
    runs, draws = with_differences(runs, [d.name for d in plan.draws[plan.laws[0]]])
    subject, metric, rule = plan.subject, plan.worst_by, plan.campaign.stop_when
    sequence = Confidence(rule.half_width) if rule else None
    results = [Results.of(law, runs, subject.column, sequence, plan.campaign.sampling != "grid") for law in plan.laws]
    summary = {
        "campaign": plan.campaign.name, subject.field: subject.name, "runs": plan.campaign.runs,
        "seed": plan.campaign.seed, "sampling": plan.campaign.sampling, "success": plan.campaign.success,
        "judged": list(JUDGED), "interval": interval_text(plan.campaign.sampling, sequence, plan.campaign.samples),
        **({"stopped": stopping(rule, results)} if rule else {}),
        f"{subject.column}s": {r.law: r.summary(draws, metric, plan.metrics, subject.noun) for r in results},
        "paired": {f"{a.law} and {b.law}": paired(a, b) for i, a in enumerate(results) for b in results[i + 1:]}}
    if plan.campaign.sampling == "grid":
        summary["grid"] = {r.law: grid.extremes(plan, r) for r in results}
    if plan.campaign.samples is not None:
        summary["samples"] = plan.campaign.samples
    with whole(folder / "report.json") as partial:  # first: it needs no pictures
        partial.write_text(json.dumps(summary, indent=2) + "\n")
    (folder / "figures").mkdir(exist_ok=True)
    every = grid.pictures(plan, results) if "grid" in summary else charts.every(plan, results, errors, draws)
    for name, draw in every.items():
        with whole(folder / "figures" / f"{name}.png") as partial:
            draw().savefig(partial, dpi=110, format="png")
    with whole(folder / "report.html") as partial:
        partial.write_text(html(store, summary, results, runs, errors, draws), encoding="utf-8")
    return {**summary, "report": str(folder / "report.html")}


def html(store: Store, summary: dict[str, Any], results: list[Results], runs: pa.Table, errors: pa.Table,
         draws: list[str]) -> str:
    """report.html."""
    plan = store.plan
    found = summary[f"{plan.subject.column}s"]
    there = shown.chosen(plan, runs, results)
    data = about_runs(store, there, draws, errors, {law: x["drivers"] for law, x in found.items()})
    data["overview"] = overview(plan, results, errors)
    head = outcomes(plan, summary, results) + introduction(plan) + ended(plan, summary)
    return page(plan, head + (note(there.sentence) if there.sentence else ""),
                [*drawn(plan, summary, data["overview"]), *uncertain(plan), *lists(plan, results)], data,
                over_the_grid(plan, summary) if "grid" in summary else ())


def about_runs(store: Store, there: shown.Shown, draws: Sequence[str], errors: pa.Table,
               found: Mapping[str, Mapping[str, Mapping[str, float]]]) -> dict[str, Any]:
    """What the page's scripts read of single runs; `found` are the drivers of each variant."""
    plan = store.plan
    data = {"noun": plan.subject.noun, "metric": plan.worst_by, **shown.packed(plan, there, draws)}
    for variant in data["variants"]:
        mine = found.get(variant["name"], {})
        variant["strongest"] = [draws.index(name) for name in (*mine, *(d for d in draws if d not in mine))][:STRONGEST]
        variant["correlations"] = [mine[name]["failure"] if name in mine else None for name in draws]
    return {**data, "curves": curves.packed(store, there, errors)}


def over_the_grid(plan: Plan, summary: Mapping[str, Any]) -> list[tuple[str, str]]:
    """The sections of a grid."""
    return [("Over the grid", note(
        "A cross is a run that was no success; a grey cell of a map has no finite value. The scale of a map is that of "
        "the successes, if there are any: orange is above, light blue below it. Point at a cell to read it, click to "
        "open its run.") + place("sweep")),
        ("Least and greatest", html_table((plan.subject.noun, "metric", "least", "greatest"),
                                          grid.table_rows(plan, summary["grid"])))]


def drawn(plan: Plan, summary: Mapping[str, Any], data: Mapping[str, Any]) -> list[tuple[str, str]]:
    """The sections with tables and pictures of all runs."""
    subject = plan.subject
    parts = [(f"The {subject.noun}s side by side", place("probability") + note(f"Interval: {summary['interval']}.")
              + side_by_side(plan, summary))]
    if not data["sweep"] and (table := drivers(plan, summary)):
        parts.append(("What drives the failures", table))
    if data["histograms"]:
        parts.append(("How far off", note("All judged runs, failures too, each as far as it flew. A dashed line is the "
                                          "open run.") + place("histograms")))
    if data["envelopes"]:
        title, words = subject.drawn
        bent = any(panel["bend"] for panel in data["envelopes"]["panels"])
        most = min(max(variant["runs"] for variant in data["envelopes"]["variants"]), 2000)
        parts.append((title, note(
            f"{words}, of the first {most} runs of each {subject.noun} at most: at each time over the runs that still "
            "fly then, so curves calm down as failures leave. Bands: all, and 5 to 95 %; the line is the median, the "
            "dashed one the open run."
            + (" The axes are logarithmic far from 0." if bent else "")) + place("envelopes")))
    return parts


def lists(plan: Plan, results: Sequence[Results]) -> list[tuple[str, str]]:
    """The sections with the worst runs and with those that were not judged."""
    least = least_is_worst(plan.worst_by, plan.campaign.success.values())
    order = f"then by {plan.worst_by}, the {'least' if least else 'largest'} first" if plan.worst_by else \
        "then what was no success"
    said = note(f"What did not reach the end, the earliest first; {order}. Each command repeats its run.")
    return [*((f"The worst ten, {r.law}", said + commands(plan, v, r.worst(plan.worst_by, least=least)))
              for v, r in enumerate(results)),
            *((f"Failures of the machinery, {r.law}",
               note(f"The first ten of {r.others.num_rows:,}. Each command repeats its run.")
               + commands(plan, v, r.others.slice(0, 10).to_pylist()))
              for v, r in enumerate(results) if r.others.num_rows)]
