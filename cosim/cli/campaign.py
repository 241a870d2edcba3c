"""`ahv campaign`."""
import json
from pathlib import Path
from typing import Annotated, Any

import typer

from .options import Json
from .show import report


def campaign(
    file: Annotated[Path, typer.Argument(help="A campaign file, see docs/campaigns.md.")],
    scheduler: Annotated[str | None, typer.Option(metavar="ADDRESS", help="Dask scheduler; else a local one.")] = None,
    workers: Annotated[int | None, typer.Option(help="Local worker processes; else one for each core.", min=1)] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Continue an interrupted campaign.")] = False,
    out: Annotated[Path | None, typer.Option(help="Folder; else results/NAME.")] = None,
    as_json: Json = False,
) -> None:
    """Fly many uncertain runs on Dask, and report how often they succeed."""
    from ..campaign.campaign import campaign as fly

    summary = fly(file, out, scheduler, resume, workers)
    if as_json:
        print(json.dumps(summary))
    else:
        report(table(summary), False)


def table(summary: dict[str, Any]) -> dict[str, Any]:
    """The summary's few lines for a terminal."""
    rows: dict[str, Any] = {"campaign": summary["campaign"]}
    for law, found in summary["controllers"].items():
        low, high = found["interval_95"]
        rows[f"success, {law}"] = (f"{100 * found['probability']:.2f} % ({100 * low:.2f} to {100 * high:.2f}), "
                                   f"{found['successes']:,} of {found['runs']:,}")
    return {**rows, "wall_s": summary["wall_s"], "report": summary["report"]}
