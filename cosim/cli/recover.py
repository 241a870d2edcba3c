"""`ahv recover`."""
from pathlib import Path
from typing import Annotated

import typer

from .options import Json
from .show import conclude, note, report


def recover(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="The folder of the run.")],
    as_json: Json = False,
) -> None:
    """Make results of the rows that a run with --stream left when it was killed, or when the disk was full."""
    from ..vehicle.run import recover as recovered

    done = recovered(folder)
    note([*done.notes, *done.flight.warnings, done.flight.message])
    report(done.summary, as_json)
    conclude(True, [], done.trouble)
