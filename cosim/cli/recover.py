"""`ahv recover`."""
from pathlib import Path
from typing import Annotated

import typer

from .options import Json, place, typed
from .show import conclude, note, report


def recover(
    folder: Annotated[Path, typer.Argument(metavar="DIR", parser=place, help="The folder of the run.")],
    out: Annotated[Path | None, typer.Option(metavar="DIR", parser=place, help="Folder for the results; else "
                                             "DIR itself.")] = None,
    as_json: Json = False,
) -> None:
    """Make results of the rows that a run with --stream left when it was killed, or when the disk was full."""
    from ..master.folder import kind_of

    if kind_of(folder) == "simulate":
        from ..systems.simulate import recover as simulated

        summary, flight, trouble = simulated(folder, out, typed())
        notes = []
    else:
        from ..vehicle.run import recover as recovered

        done = recovered(folder, out, typed())
        summary, flight, trouble, notes = done.summary, done.flight, done.trouble, done.notes
    note([*notes, *flight.warnings, flight.message])
    report(summary, as_json)
    conclude(True, [], trouble)
