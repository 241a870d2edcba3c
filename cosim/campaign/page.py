"""report.html: the frame of pages with the campaign's tables, and what its scripts draw."""
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from ..pages import write as pages
from ..text import html_table, html_text
from .criteria import least_is_worst
from .labels import on_axes
from .plan import Plan
from .rerun import command
from .statistics import EXPLAINED, Results

SCRIPTS = Path(__file__).parent / "scripts"
MOST_LISTED = 12  # values of a distribution
MOST_DRIVERS = 24
DRIVERS = (
    "Over the judged runs, the strongest first. The first columns are Spearman's rank correlations with each draw: of "
    "failure (0 or 1){metric}. A phase and words have no order: their number is the multiple correlation, never "
    "negative; differences of two phases stand beside the phases. The last columns are the share of failure's variance "
    "that the draw explains by itself (Sobol's index of first order), also where both small and large values fail. "
    "What the shares lack to 1 is due to draws that act together. Draws that are correlated share what they explain.")
OWN = ("runs", "scatter", "opened", "list", "overview", "sweep", "main")


def page(plan: Plan, outcome: str, sections: Sequence[tuple[str, str]], data: Mapping[str, Any],
         before: Sequence[tuple[str, str]] = ()) -> str:
    """The page: `outcome` is the HTML of its head; `sections` and those `before` the runs are titles and HTML. `data`
    is what its scripts read."""
    noun = plan.subject.noun
    explore = read("explore.html").replace("{{Noun}}", noun.capitalize()).replace("{{noun}}", noun).replace(
        "{{curves}}", pages.read("curves.html").replace("{{marks}}", ""))
    body = "".join(map(pages.section, before)) + explore + "".join(map(pages.section, sections))
    return pages.filled(f"Campaign {plan.campaign.name}", outcome, body, scripts(), data)


@cache
def read(name: str) -> str:
    """A file of the page."""
    return (SCRIPTS / name).read_text(encoding="utf-8")


def scripts() -> dict[str, str]:
    """The scripts of the page, in their order."""
    shared = {name: text for name, text in pages.scripts().items() if name != "page"}
    return shared | {name: read(f"{name}.js") for name in OWN}


def note(text: str) -> str:
    """A sentence or some above a picture, as HTML."""
    return f'<p class="note">{html_text(text)}</p>'


def place(name: str) -> str:
    """Where a script draws, as HTML."""
    return f'<div id="{name}"></div>'


def introduction(plan: Plan) -> str:
    """What was flown, and what counts as a success."""
    campaign, subject = plan.campaign, plan.subject
    most = "At most " if campaign.stop_when or campaign.rare else ""
    ours = f"sampling {campaign.rare.method if campaign.rare else campaign.sampling}"
    ours = ours if campaign.sampling == "grid" else f"seed {campaign.seed}, {ours}"
    drawn = [*([f"samples {campaign.samples}"] if campaign.samples else []), *([ours] if campaign.dispersions else [])]
    said = (f"{most}{campaign.runs:,} runs of {subject.name} ({subject.stop - subject.start:g} s in steps of "
            f"{subject.step:g} s) for each {subject.noun}, {', '.join(drawn)}{subject.remark}.")
    success = "; ".join(f"{html_text(name)}: <code>{html_text(text)}</code>" for name, text in campaign.success.items())
    return f"<p>{html_text(said)} A run is a success if it reaches the end and {success}.</p>"


def uncertain(plan: Plan) -> list[tuple[str, str]]:
    """The section on what is drawn, and on the campaign's own metrics."""
    campaign = plan.campaign
    rows = [[d.name if d.targets == (d.name,) else f"{d.name} (also {', '.join(d.targets[1:])})",
             plan.labels[d.name].description, plan.labels[d.name].unit,
             fields_text(d.distribution.model_dump(exclude={"also", "relative"}, exclude_none=True))
             + (f", times the nominal {d.factor:g}" if d.factor is not None else "")
             + (", as a period in s" if d.period else "")] for d in plan.draws[plan.laws[0]]]
    correlated = listed(fields_text(group.model_dump(exclude_none=True)) for group in campaign.correlations)
    own = html_table(("metric", "expression"), campaign.metrics.items())
    return [("What is uncertain", html_table(("drawn", "meaning", "unit", "from"), rows)
             + (f"<p>Correlated:</p>{correlated}" if campaign.correlations else "")),
            *([("Metrics of this campaign", own)] if campaign.metrics else [])]


def ended(plan: Plan, summary: Mapping[str, Any]) -> str:
    """Of a campaign with a rule: after how many runs it ended, and the intervals by that rule."""
    if not (stopped := summary.get("stopped")):
        return ""
    intervals = listed(f"{law}: {100 * low:.2f} to {100 * high:.2f} %"
                       for law, (low, high) in stopped["intervals"].items())
    return (f"<p>Ended after {stopped['after_runs']:,} runs of each {plan.subject.noun}: {html_text(stopped['why'])}. "
            f"The rule: the probability of {html_text(stopped['probability'])} with a half-width of "
            f"{100 * stopped['half_width']:g} %, at {100 * stopped['confidence']:g} % confidence whatever ends the "
            f"campaign. Its intervals:</p>{intervals}")


def listed(items: Iterable[str]) -> str:
    """An HTML list."""
    return f"<ul>{''.join(f'<li>{html_text(item)}</li>' for item in items)}</ul>"


def fields_text(given: Mapping[str, Any]) -> str:
    """The fields of a distribution or a correlation in a line."""
    def text(value: Any) -> str:
        if isinstance(value, list) and len(value) > MOST_LISTED:
            return f"({len(value):,} from {value[0]} to {value[-1]})"
        return f"{value:g}" if isinstance(value, float) else str(value)

    return ", ".join(str(v) if k == "distribution" else f"{k} {text(v)}" for k, v in given.items())


def outcomes(plan: Plan, summary: Mapping[str, Any], results: Sequence[Results]) -> str:
    """A line for each variant: its successes, and its worst run to open."""
    found = ""
    for v, r in enumerate(results):
        law = summary[f"{plan.subject.column}s"][r.law]
        share = "no judged run" if law["probability"] is None else f"{percent(law['probability'])} successes"
        between = "" if "grid" in summary or law["probability"] is None else \
            " ({:.2f} to {:.2f} %)".format(*(100 * p for p in law["interval_95"]))
        worst = r.worst(plan.worst_by, 1, least_is_worst(plan.worst_by, plan.campaign.success.values()))
        button = f". The worst: {opener(v, worst[0])}, {html_text(how(worst[0]))}" if worst else ""
        bad = "" if law["successes"] == r.runs else " bad"
        others = f", {r.others.num_rows:,} not judged" if r.others.num_rows else ""
        found += (f'<p class="outcome{bad}"><strong>{html_text(r.law)}</strong>: {share}{between} of '
                  f'{law["judged"]:,} judged runs{others}{button}</p>')
    return found


def opener(variant: int, row: Mapping[str, Any]) -> str:
    """A button that opens a run."""
    return f'<button type="button" data-variant="{variant}" data-run="{row["run"]}">run {row["run"]}</button>'


def how(row: Mapping[str, Any]) -> str:
    """How a run ended, in a word or two."""
    if row["departed_at_s"] is not None:
        return f"{row['status']} at {row['departed_at_s']:.5g} s"
    return "a success" if row["success"] else f"{row['status']}, no success"


def side_by_side(plan: Plan, summary: Mapping[str, Any]) -> str:
    """A table of the variants side by side."""
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
                         *(number(x["metrics"].get(name, {}).get(key)) for x in found.values())])
        endless = [x["metrics"].get(name, {}).get("infinite", 0) for x in found.values()]
        if any(endless):
            rows.append([f"{name}, infinite (in neither)", *(f"{count:,}" for count in endless)])
    pairs = "".join(f"<p>{html_text(both)} on the same draws: {html_text(counts_text(counts))}.</p>"
                    for both, counts in summary["paired"].items())
    return (note("Runs that finished or departed are judged. A run that could not start, took too long or crashed is a "
                 f"failure of the machinery: it says nothing of the {noun}.")
            + html_table(("figure", *found), rows) + pairs)


def drivers(plan: Plan, summary: Mapping[str, Any]) -> str:
    """A table of what failure goes with: a bar for each correlation and share of each variant."""
    found = {law: x["drivers"] for law, x in summary[f"{plan.subject.column}s"].items()}
    first = next(iter(found.values()))
    if not first:
        return ""
    metric = plan.worst_by
    shown = {"failure": "correlation with failure", **({metric: f"correlation with {metric}"} if metric else {}),
             EXPLAINED: "share of failure explained"}
    labels = on_axes(first, plan.labels)
    head = "".join(f'<th colspan="{len(found)}" scope="colgroup">{html_text(title)}</th>' for title in shown.values())
    laws = "".join(f'<th scope="col">{html_text(law)}</th>' for _ in shown for law in found)
    rows = "".join(
        f'<tr><th scope="row">{html_text(labels[name])}</th>'
        + "".join(f"<td>{bar(of[name][what])}</td>" for what in shown for of in found.values()) + "</tr>"
        for name in list(first)[:MOST_DRIVERS])
    said = DRIVERS.format(metric=f", and of {metric}" if metric else "")
    head = f'<tr><th rowspan="2" scope="col">draw</th>{head}</tr><tr>{laws}</tr>'
    return f'{note(said)}<table class="bars"><thead>{head}</thead><tbody>{rows}</tbody></table>'


def bar(value: float) -> str:
    """A number from -1 to 1 with a bar as long."""
    return (f'{value:.2f}'.replace("-", "\N{MINUS SIGN}")
            + f'<span class="bar{" less" if value < 0 else ""}" style="width:{100 * min(abs(value), 1):.0f}%"></span>')


def commands(plan: Plan, variant: int, runs: Iterable[Mapping[str, Any]]) -> str:
    """Runs with how they ended and the command that repeats each."""
    by, rows = plan.worst_by, ""
    for row in runs:
        ended_ = f"{row['status']}: {row['message']}" if row["message"] else row["status"]
        cells = [opener(variant, row), html_text(ended_), *([] if by is None else [number(row[by])]),
                 f'<pre tabindex="0">{html_text(command(plan, dict(row)))}</pre>']
        rows += f"<tr>{''.join(f'<td>{cell}</td>' for cell in cells)}</tr>"
    head = "".join(f"<th>{html_text(name)}</th>" for name in
                   ("run", "ended", *([with_unit(plan, by)] if by else []), "command"))
    return f'<table class="commands"><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>'


def with_unit(plan: Plan, metric: str) -> str:
    """A metric's name, with its unit where it has one."""
    unit = plan.metrics[metric].unit
    return f"{metric} ({unit})" if unit else metric


def number(value: float | None) -> str:
    """A figure for a table."""
    return "" if value is None else f"{value:.4g}"


def percent(share: float | None) -> str:
    """A share in per cent."""
    return "unknown" if share is None else f"{100 * share:.2f} %"


def counts_text(counts: Mapping[str, int]) -> str:
    """Counts in a line."""
    return ", ".join(f"{name} {count:,}" for name, count in counts.items())
