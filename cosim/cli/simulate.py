"""`ahv simulate`."""
from pathlib import Path
from typing import Annotated

import typer

from .options import Algorithm, Json, Out, Stream, TimeLimit
from .show import conclude, report


def simulate(
    file: Annotated[Path, typer.Argument(help="An SSP 1.0 file.")],
    step: Annotated[float | None, typer.Option(help="Communication step, s; else the file's.")] = None,
    stop: Annotated[float | None, typer.Option(help="Stop time, s; else the file's.")] = None,
    algorithm: Algorithm = "gauss-seidel",
    time_limit: TimeLimit = None,
    stream: Stream = False,
    out: Out = None,
    as_json: Json = False,
) -> None:
    """Fly any system of FMI 2.0 co-simulation FMUs; write signals and run.json to results/simulate/FILE."""
    from ..ssp.simulate import simulate as fly

    summary, flight, trouble = fly(file, step, stop, algorithm, out, time_limit, stream)
    report(summary, as_json)
    conclude(flight.finished, [flight.message], trouble, flight.interrupted)
