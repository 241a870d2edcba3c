"""`ahv tune`."""
import sys
from typing import Annotated, Any

import typer

from ..vehicle.registry import LAWS
from .options import Json, Out
from .show import report, report_rows


def tune(
    law: Annotated[str, typer.Argument(metavar="LAW", help=f"{', '.join(LAWS)}; or any FMU with the same ports as "
                                                           "NAME=FILE.fmu.")],
    preset: Annotated[str | None, typer.Option(help="The gains to begin with; else the law's own.")] = None,
    flights: Annotated[str, typer.Option(help="independent: vehicles whose coefficient groups err each on its own; "
                                              "together: the paper's cases; structures: those on four flexible "
                                              "structures.")] = "independent",
    gain: Annotated[list[str], typer.Option(help="A gain that is free; can be repeated. Else the law's, or, of an FMU "
                                                 "file, those that the preset sets.")] = [],  # noqa: B006
    evaluations: Annotated[int, typer.Option(help="Sets of gains to fly.", min=1)] = 960,
    draws: Annotated[int, typer.Option(help="Vehicles that each set is flown on.", min=1)] = 48,
    seed: Annotated[int, typer.Option(help="Of the draws and of the search.", min=1)] = 1,
    sigma: Annotated[float, typer.Option(help="First step of the search, of a gain's logarithm.")] = 0.3,
    workers: Annotated[int, typer.Option(help="Processes; they do not change the result.", min=1)] = 2,
    out: Out = None,
    as_json: Json = False,
) -> None:
    """Tune a law's gains for uncertain vehicles, with CMA-ES.

    Training, test and fresh draws are apart: the search minimises the cost over the first, the second choose among what
    it finds, the third are flown once at the end. tune.json is written as the search goes on; Ctrl-C keeps it.
    """
    from ..vehicle.tune import tune as search

    found = search(law, preset, flights, gain, evaluations, draws, seed, sigma, workers, out,
                   lambda line: print(line, file=sys.stderr, flush=True))
    report(found if as_json else table(found), as_json)
    if not as_json and "fresh" in found:
        report_rows(found["fresh"])


def table(found: dict[str, Any]) -> dict[str, Any]:
    """The result's few lines for a terminal."""
    return {"law": found["law"], "preset": found["preset"], "flights": found["flights"],
            "evaluations": found["evaluations"],
            **{f"{use} draws": f"{drawn['count']}, seed {drawn['seed']}" for use, drawn in found["draws"].items()},
            "training cost": f"{found['start']['training_cost']:.4f} -> {found['training_cost']:.4f}",
            "test cost": f"{found['start']['test_cost']:.4f} -> {found['test_cost']:.4f}",
            **found["gains"], "out": found["out"]}
