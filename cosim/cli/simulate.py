"""`ahv simulate`."""
from pathlib import Path
from typing import Annotated

import typer

from .options import Columns, Decimate, Json, Open, Out, Record, Stream, TimeLimit, opened, place, typed
from .show import conclude, report

ALGORITHM = ("gauss-seidel (the default, unless the file says another), jacobi, multi-rate, variable or iterated; for "
             "example multi-rate,controller=5,hold=linear.")


def simulate(
    file: Annotated[Path, typer.Argument(metavar="FILE.fmu|.ssp|.yaml", help="An FMU, an SSP, or a system file.")],
    step: Annotated[float | None, typer.Option(help="Communication step, s; else the file's.")] = None,
    start: Annotated[float | None, typer.Option(help="Start time, s; else the file's.")] = None,
    stop: Annotated[float | None, typer.Option(help="Stop time, s; else the file's.")] = None,
    tolerance: Annotated[float | None, typer.Option(help="Relative tolerance for the FMUs; else the file's.")] = None,
    algorithm: Annotated[str | None, typer.Option(metavar="NAME[,OPTION=VALUE]...", help=ALGORITHM)] = None,
    set_: Annotated[list[str], typer.Option("--set", metavar="[COMPONENT.]VARIABLE=VALUE", help="Set a parameter or a "
                    "start value, with a unit if wanted (2deg). Can be repeated.")] = [],  # noqa: B006
    fmu: Annotated[list[str], typer.Option(metavar="COMPONENT=FILE.fmu", help="Fly another FMU in this place. Can be "
                   "repeated.")] = [],  # noqa: B006
    input_: Annotated[Path | None, typer.Option("--input", metavar="FILE.csv|.parquet", help="Inputs over time: a "
                      "column time (s), and one for each input.")] = None,
    record: Record = [],  # noqa: B006
    decimate: Decimate = 1,
    plot: Annotated[bool, typer.Option("--plot", help="Draw what is recorded, one panel for each unit.")] = False,
    save: Annotated[Path | None, typer.Option(metavar="FILE", parser=place,
                                              help="File for the whole state at the end.")] = None,
    restore: Annotated[Path | None, typer.Option(metavar="FILE", parser=place,
                                                 help="Go on from a state that --save wrote.")] = None,
    time_limit: TimeLimit = None,
    stream: Stream = False,
    figures: Annotated[str | None, typer.Option("--figures", metavar="png|pdf|svg", help="Draw, as --plot does, in "
                                                "this format.")] = None,
    columns: Columns = 2,
    out: Out = None,
    open_: Open = False,
    as_json: Json = False,
) -> None:
    """Fly any FMU or system of FMUs; write signals, run.json and report.html to results/simulate/FILE."""
    from ..pictures import Format
    from ..systems.simulate import simulate as fly

    form, drawn = Format(figures or "png", columns), plot or figures is not None
    summary, flight, trouble = fly(file, step, stop, algorithm, out, time_limit, stream, start=start,
                                   tolerance=tolerance, values=set_, inputs=input_, record=record, decimate=decimate,
                                   plot=drawn, save=save, restore=restore, fmus=fmu, command=typed(), form=form)
    report(summary, as_json)
    opened(Path(summary["out"], "report.html"), open_)
    conclude(flight.finished, [flight.message], trouble, flight.interrupted)
