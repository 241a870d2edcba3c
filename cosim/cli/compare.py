"""`ahv compare`."""
import json
from pathlib import Path
from typing import Annotated

import typer

from ..vehicle.registry import LAWS
from .options import Columns, Figures, Flavour, Json, Open, Out, Plant, ScenarioWord, Step, Stop, opened, typed
from .show import conclude, note, report_rows


def compare(
    scenario: ScenarioWord,
    controller: Annotated[list[str], typer.Option(metavar="NAME|NAME=FILE.fmu", help=f"{', '.join(LAWS)}, or any FMU "
                                                  "with the same ports; else all of ours. Can be repeated.")] = [],  # noqa: B006
    flavour: Flavour = None,
    plant: Plant = "ideal",
    step: Step = 0.01,
    stop: Stop = None,
    runs: Annotated[list[str], typer.Option("--run", metavar="NAME:OPTIONS", help="A variant, as the options of ahv "
                    "run say it: \"mine:--preset robust --set controller.k_gamma=0.3\". Can be repeated; without "
                    "--controller, beside the neural law.")] = [],  # noqa: B006
    figures: Figures = "png",
    columns: Columns = 2,
    out: Out = None,
    open_: Open = False,
    as_json: Json = False,
) -> None:
    """Fly control laws on the same scenario: a table, and figures and a page with a curve for each.

    The backstepping law is a reconstruction of the one that the paper compares with. It and the neural law's preset
    `robust` were tuned with the same cost and budget.
    """
    from ..pictures import Format
    from ..vehicle.compare import compare as fly
    from ..vehicle.variants import variant

    summary, flights, notes, trouble = fly(scenario, controller, plant, flavour, step, stop, out,
                                           list(map(variant, runs)), typed(), Format(figures, columns))
    note([*notes, *(f"{law}: {warning}" for law, flight in flights.items() for warning in flight.warnings)])
    if as_json:
        print(json.dumps(summary))
    else:
        report_rows(summary["controllers"])
        print(f"{summary['verdict']} Figures: {summary['out']}")
    opened(Path(summary["out"], "report.html"), open_)
    conclude(all(flight.finished for flight in flights.values()),
             [f"{law}: {flight.message}" for law, flight in flights.items() if flight.message], trouble)
