"""`ahv campaign`."""
import json
from pathlib import Path
from typing import Annotated, Any

import typer

from ..errors import UsageError
from ..text import shown
from .options import Json, place
from .show import report


def campaign(
    file: Annotated[Path, typer.Argument(help="A campaign file, see docs/campaigns.md.")],
    scheduler: Annotated[str | None, typer.Option(metavar="ADDRESS", help="Dask scheduler; else a local one.")] = None,
    workers: Annotated[int | None, typer.Option(help="Local worker processes; else one for each core.", min=1,
                                                          max=1000)] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Continue a campaign, also with more runs.")] = False,
    tls_ca: Annotated[Path | None, typer.Option(metavar="FILE", parser=place,
                                                 help="CA, for a scheduler with TLS.")] = None,
    tls_cert: Annotated[Path | None, typer.Option(metavar="FILE", parser=place,
                                                   help="Our certificate, for the same.")] = None,
    tls_key: Annotated[Path | None, typer.Option(metavar="FILE", parser=place, help="Its key.")] = None,
    dashboard: Annotated[bool, typer.Option("--dashboard", help="Dask's dashboard for the local cluster; every user "
                                                                "of this machine can see it.")] = False,
    out: Annotated[Path | None, typer.Option(metavar="DIR", parser=place, help="Folder; else "
                                             "results/campaign/NAME.")] = None,
    as_json: Json = False,
) -> None:
    """Fly many uncertain runs on Dask, and report how often they succeed."""
    from ..campaign.campaign import campaign as fly
    from ..vehicle.campaigns import Laws

    given = [path for path in (tls_ca, tls_cert, tls_key) if path is not None]
    if len(given) not in (0, 3):
        raise UsageError("--tls-ca, --tls-cert and --tls-key belong together: give all three, or none.")
    tls = (given[0], given[1], given[2]) if given else None
    summary = fly(file, out, scheduler, resume, workers, tls, dashboard, [Laws])
    if as_json:
        print(json.dumps(summary))
    else:
        report(table(summary), False)


def table(summary: dict[str, Any]) -> dict[str, Any]:
    """The summary's few lines for a terminal."""
    rows: dict[str, Any] = {"campaign": summary["campaign"]}
    if "rare" in summary:
        return {**rows, **rare(summary["rare"]), "wall_s": summary["wall_s"], "report": summary["report"]}
    grid = summary.get("grid")
    for law, found in summary["controllers" if "controllers" in summary else "variants"].items():
        share = "unknown" if found["probability"] is None else f"{100 * found['probability']:.2f} %"
        between = " ({:.2f} to {:.2f})".format(*(100 * p for p in found["interval_95"])) if found["interval_95"] else ""
        rows[f"success, {law}"] = f"{share}{between}, {found['successes']:,} of {found['judged']:,} judged runs"
        if found["failures"]["machinery"]:
            rows[f"not judged, {law}"] = f"{found['failures']['machinery']:,} of {found['runs']:,} runs: " + ", ".join(
                f"{status} {count:,}" for status, count in found["statuses"].items() if status not in summary["judged"])
        for metric, ends in (grid or {}).get(law, {}).items():
            for word, one in ends.items():
                rows[f"{word} {metric}, {law}"] = f"{one['value']:.6g} at " + ", ".join(
                    f"{name} = {shown(value)}" for name, value in one["at"].items())
    if stopped := summary.get("stopped"):
        rows["ended"] = f"after {stopped['after_runs']:,} runs: {stopped['why']}"
    return {**rows, **({} if grid else {"interval": summary["interval"]}), "wall_s": summary["wall_s"],
            "report": summary["report"]}


def rare(found: dict[str, Any]) -> dict[str, Any]:
    """The lines of a campaign of rare failures."""
    runs = f"{found['runs']:,} in {len(found['levels'])} levels"
    if found["not_judged"]:
        runs += f", of which {found['not_judged']:,} were not judged"
    if found["probability"] is None:
        return {f"failure of {found['failure']}": f"no estimate: {found['reason']}", "runs": runs}
    low, high = found["interval_95"]
    plain = f"; as many as {found['plain_runs']:,.0f} plain runs" if found["plain_runs"] else ""
    return {f"failure of {found['failure']}": f"{found['probability']:.3g} ({low:.3g} to {high:.3g}), coefficient of "
                                              f"variation {100 * found['coefficient_of_variation']:.0f} %",
            "runs": runs + plain, "interval": found["interval"]}
