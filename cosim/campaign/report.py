"""The report: report.html (one file, figures included), figures/*.png and report.json."""
import base64
import json
from collections.abc import Iterable
from html import escape
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from ..master.whole_file import whole
from . import charts, grid
from .criteria import least_is_worst
from .curves import Curves
from .front import stopping
from .plan import Plan
from .rerun import command
from .sequential import Sequence
from .statistics import JUDGED, Results, interval_text, paired, with_differences
from .store import Store

STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; color: #222; max-width: 1000px; margin: 2em auto; padding: 0 1em; }
h1, h2 { line-height: 1.2; } h2 { margin-top: 2em; border-bottom: 1px solid #ccc; }
table { border-collapse: collapse; margin: 1em 0; font-variant-numeric: tabular-nums; }
th, td { padding: .25em .8em; text-align: right; border-bottom: 1px solid #ddd; vertical-align: top; }
th:first-child, td:first-child { text-align: left; }
img { width: 100%; height: auto; }
pre { background: #f4f4f4; padding: .5em; font-size: 12px; white-space: pre-wrap; overflow-wrap: anywhere; margin: 0; }
.commands td, .commands th, .words td, .words th { text-align: left; font-size: 14px; }
.note { color: #555; }
.curves { display: flex; flex-wrap: wrap; gap: 1em; } .curves figure { margin: 0; width: 220px; font-size: 12px; }
.curves polyline { fill: none; stroke: #2471a3; stroke-width: 1.2; } summary { cursor: pointer; }
@media (max-width: 700px) { table { display: block; overflow-x: auto; } }
"""
MOST_LISTED = 12  # values of a distribution
EXPLAINED = {
    "probability": ("Success", "Bars: share of the judged runs that reached the end and met every criterion. "
                    "Lines: an interval of {interval}."),
    "envelopes": ("{drawn[0]}", "{drawn[1]}, of the first {envelope} runs of each {noun} at most: at "
                  "each time over the runs that still fly then, so curves calm down as failures leave."),
    "histograms": ("How far off", "All judged runs, failures too, each as far as it flew."),
    "drivers": ("What drives the failures", "Over the judged runs, the strongest first. Left: Spearman's "
                "rank correlation of failure (0 or 1) with each draw{and_metric}. A phase and words have no order: "
                "their bar is the multiple correlation, never negative; differences of two phases stand beside the "
                "phases. Right: the share of failure's variance that the draw explains by itself (Sobol's index of "
                "first order), also where both small and large values fail. What the shares lack to 1 is due to draws "
                "that act together. Draws that are correlated share what they explain."),
    "scatter": ("{metric} against each dispersion, {law}", "The first {points} judged runs at most; the "
                "twelve strongest."),
    "sweep": ("{law}", "Over the grid. A cross is a run that was no success; a grey cell of a map has no finite value. "
              "The scale of a map is that of the successes, if there are any: orange is above, light blue below it."),
}


def write(store: Store) -> dict[str, Any]:
    """Write the report into the store's folder; its numbers."""
    plan, folder = store.plan, store.folder
    runs, errors = pq.read_table(store.file("runs")), pq.read_table(store.file("errors"))
    runs, draws = with_differences(runs, [d.name for d in plan.draws[plan.laws[0]]])
    subject, metric, rule = plan.subject, plan.worst_by, plan.campaign.stop_when
    sequence = Sequence(rule.half_width) if rule else None
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
    pictures = {}
    (folder / "figures").mkdir(exist_ok=True)
    every = grid.pictures(plan, results) if "grid" in summary else charts.every(plan, results, errors, draws)
    for name, draw in every.items():
        path = folder / "figures" / f"{name}.png"
        with whole(path) as partial:
            draw().savefig(partial, dpi=110, format="png")
        pictures[name] = path.read_bytes()
    listed = {row["run"] for r in results for row in (*worst_of(plan, r), *first_of(r.others))}
    with whole(folder / "report.html") as partial:
        partial.write_text(page(plan, summary, results, pictures, Curves(store, errors, listed)))
    return {**summary, "report": str(folder / "report.html")}


def page(plan: Plan, summary: dict[str, Any], results: list[Results], pictures: dict[str, bytes],
         curves: Curves) -> str:
    """report.html."""
    campaign = plan.campaign
    names = {"envelope": min(results[0].runs, 2000), "metric": plan.worst_by, "points": charts.POINTS,
             "and_metric": f"; in the middle, of {plan.worst_by}" if plan.worst_by else "",
             "noun": plan.subject.noun, "drawn": plan.subject.drawn, "interval": summary["interval"]}
    parts = [f"<h1>Campaign {escape(campaign.name)}</h1>", introduction(plan), ended(plan, summary),
             side_by_side(plan, summary)]
    for name, png in pictures.items():
        kind, _, law = name.partition("_")
        title, note = (text.format(law=law, **names) for text in EXPLAINED[kind])
        parts.append(f"<h2>{escape(title)}</h2><p class=note>{escape(note)}</p>"
                     f"<img alt='{escape(title, quote=True)}' src='data:image/png;base64,"
                     f"{base64.b64encode(png).decode()}'>")
    if "grid" in summary:
        parts.append("<h2>Least and greatest</h2>" + table([plan.subject.noun, "metric", "least", "greatest"],
                                                           grid.table_rows(plan, summary["grid"])))
    parts += [worst(plan, r, curves) for r in results]
    parts += [not_judged(plan, r, curves) for r in results if r.others.num_rows]
    return ("<!doctype html><html lang=en><head><meta charset=utf-8><meta name=viewport content='width=device-width'>"
            f"<link rel=icon href='data:,'><title>Campaign {escape(campaign.name)}</title><style>{STYLE}</style></head>"
            f"<body>{''.join(parts)}</body></html>\n")


def introduction(plan: Plan) -> str:
    """What was flown, what counts as a success, and what is uncertain."""
    campaign, subject = plan.campaign, plan.subject
    own = listed(f"{escape(name)}: <code>{escape(text)}</code>" for name, text in campaign.metrics.items())
    success = listed(f"{escape(name)}: <code>{escape(text)}</code>" for name, text in campaign.success.items())
    rows = [[d.name if d.targets == (d.name,) else f"{d.name} (also {', '.join(d.targets[1:])})",
             plan.labels[d.name].description, plan.labels[d.name].unit,
             fields_text(d.distribution.model_dump(exclude={"also", "relative"}, exclude_none=True))
             + (f", times the nominal {d.factor:g}" if d.factor is not None else "")
             + (", as a period in s" if d.period else "")] for d in plan.draws[plan.laws[0]]]
    correlated = listed(escape(fields_text(group.model_dump(exclude_none=True))) for group in campaign.correlations)
    most = "At most " if campaign.stop_when or campaign.rare else ""
    ours = f"sampling {campaign.rare.method if campaign.rare else campaign.sampling}"
    ours = ours if campaign.sampling == "grid" else f"seed {campaign.seed}, {ours}"
    drawn = [*([f"samples {escape(campaign.samples)}"] if campaign.samples else []),
             *([ours] if campaign.dispersions else [])]
    return (f"<p>{most}{campaign.runs:,} runs of {escape(subject.name)} ({subject.stop - subject.start:g} s in steps "
            f"of {subject.step:g} s) for each {subject.noun}, {', '.join(drawn)}{escape(subject.remark)}.</p>"
            f"{f'<p>Metrics of this campaign:</p>{own}' if campaign.metrics else ''}"
            f"<p>A run is a success if it reaches the end and</p>{success}"
            f"<details><summary>What is uncertain</summary>{table(['drawn', 'meaning', 'unit', 'from'], rows, 'words')}"
            f"{f'<p>Correlated:</p>{correlated}' if campaign.correlations else ''}</details>")


def ended(plan: Plan, summary: dict[str, Any]) -> str:
    """Of a campaign with a rule: after how many runs it ended, and the intervals by that rule."""
    if not (stopped := summary.get("stopped")):
        return ""
    intervals = listed(f"{escape(law)}: {100 * low:.2f} to {100 * high:.2f} %"
                       for law, (low, high) in stopped["intervals"].items())
    return (f"<p>Ended after {stopped['after_runs']:,} runs of each {plan.subject.noun}: {escape(stopped['why'])}. "
            f"The rule: the probability of {escape(stopped['probability'])} with a half-width of "
            f"{100 * stopped['half_width']:g} %, at {100 * stopped['confidence']:g} % confidence whatever ends the "
            f"campaign. Its intervals:</p>{intervals}")


def listed(items: Iterable[str]) -> str:
    """An HTML list; `items` are HTML."""
    return f"<ul>{''.join(f'<li>{item}</li>' for item in items)}</ul>"


def fields_text(given: dict[str, Any]) -> str:
    """The fields of a distribution or a correlation in a line."""
    def text(value: Any) -> str:
        if isinstance(value, list) and len(value) > MOST_LISTED:
            return f"({len(value):,} from {value[0]} to {value[-1]})"
        return f"{value:g}" if isinstance(value, float) else str(value)

    return ", ".join(str(v) if k == "distribution" else f"{k} {text(v)}" for k, v in given.items())


def table(head: list[str], rows: list[list[Any]], kind: str = "") -> str:
    """Cells are escaped, unless they are a <pre>."""
    def cell(x: Any) -> str:
        text = f"{x:.4g}" if isinstance(x, float) else str(x)
        return f"<td>{text if text.startswith('<pre>') else escape(text)}</td>"
    return (f"<table class='{kind}'><tr>{''.join(f'<th>{escape(h)}</th>' for h in head)}</tr>"
            + "".join(f"<tr>{''.join(map(cell, row))}</tr>" for row in rows) + "</table>")


def side_by_side(plan: Plan, summary: dict[str, Any]) -> str:
    """A table of the laws side by side."""
    noun = plan.subject.noun
    found = summary[f"{plan.subject.column}s"]
    statuses = sorted({s for law in found.values() for s in law["statuses"]})
    rows: list[list[Any]] = [
        ["successes", *(f"{x['successes']:,} of {x['judged']:,} judged" for x in found.values())],
        ["share of successes" if "grid" in summary else "probability of success",
         *(percent(x["probability"]) for x in found.values())],
        *([] if "grid" in summary else [["95 % interval", *("{:.2f} to {:.2f} %".format(
            *(100 * p for p in x["interval_95"])) for x in found.values())]]),
        *([f"failures of the {whose}", *(f"{x['failures'][whose]:,}" for x in found.values())]
          for whose in (noun, "machinery")),
        *([status, *(f"{x['statuses'].get(status, 0):,}" for x in found.values())] for status in statuses)]
    for name in plan.headlines:
        for key in ("median", "p95"):
            rows.append([f"{with_unit(plan, name)}, {key}",
                         *(x["metrics"].get(name, {}).get(key, "") for x in found.values())])
        endless = [x["metrics"].get(name, {}).get("infinite", 0) for x in found.values()]
        if any(endless):
            rows.append([f"{name}, infinite (in neither)", *(f"{count:,}" for count in endless)])
    pairs = "".join(f"<p>{escape(both)} on the same draws: {escape(counts_text(counts))}.</p>"
                    for both, counts in summary["paired"].items())
    return (f"<h2>The {noun}s side by side</h2><p class=note>Runs that finished or departed are judged. A run that "
            f"could not start, took too long or crashed is a failure of the machinery: it says nothing of the {noun}."
            "</p>"
            + table(["", *found], rows) + pairs)


def with_unit(plan: Plan, metric: str) -> str:
    """A metric's name, with its unit where it has one."""
    unit = plan.metrics[metric].unit
    return f"{metric} ({unit})" if unit else metric


def percent(share: float | None) -> str:
    """A share in per cent."""
    return "unknown" if share is None else f"{100 * share:.2f} %"


def counts_text(counts: dict[str, int]) -> str:
    """Counts in a line."""
    return ", ".join(f"{name} {count:,}" for name, count in counts.items())


def worst_of(plan: Plan, r: Results) -> list[dict[str, Any]]:
    """The rows of the ten worst of a law's judged runs."""
    return r.worst(plan.worst_by, least=least_is_worst(plan.worst_by, plan.campaign.success.values()))


def worst(plan: Plan, r: Results, curves: Curves) -> str:
    """The ten worst of a law's judged runs."""
    order = f"by {escape(plan.worst_by or '')}, the " + (
        "least" if least_is_worst(plan.worst_by, plan.campaign.success.values()) else "largest") + " first"
    return (f"<h2>The worst ten, {escape(r.law)}</h2><p class=note>What did not reach the end, the earliest first; "
            f"then {order if plan.worst_by else 'what was no success'}. "
            "Each command repeats its run.</p>"
            + commands(plan, worst_of(plan, r), curves))


def not_judged(plan: Plan, r: Results, curves: Curves) -> str:
    """The first ten failures of the machinery."""
    return (f"<h2>Failures of the machinery, {escape(r.law)}</h2><p class=note>The first ten of {r.others.num_rows:,}. "
            "Each command repeats its run.</p>" + commands(plan, first_of(r.others), curves))


def first_of(table: pa.Table) -> list[dict[str, Any]]:
    """The first ten rows."""
    return list(table.slice(0, 10).to_pylist())


def commands(plan: Plan, runs: list[dict[str, Any]], curves: Curves | None = None) -> str:
    """Runs with how they ended, the command that repeats each, and below that its curves, as far as they were kept."""
    by, rows = plan.worst_by, []
    for row in runs:
        ended = f"{row['status']}: {row['message']}" if row["message"] else row["status"]
        shown = [] if by is None else ["" if row[by] is None else float(row[by])]
        pictures = curves.of(row["run"], row[plan.subject.column]) if curves else ""
        opened = f"<details><summary>curves</summary><div class=curves>{pictures}</div></details>" if pictures else ""
        rows.append([str(row["run"]), ended, *shown, f"<pre>{escape(command(plan, row))}</pre>{opened}"])
    return table(["run", "ended", *([with_unit(plan, by)] if by else []), "command"], rows, "commands")
