"""`ahv view`."""
import sys
from pathlib import Path
from typing import Annotated

import typer

from .options import Open, new_file, opened, place, typed


def view(
    folders: Annotated[list[Path], typer.Argument(metavar="DIR...", parser=place, help="Folders that ahv run, simulate "
                                                  "or compare wrote.")],
    out: Annotated[Path | None, typer.Option(metavar="FILE.html", parser=new_file,
                                             help="The page; else results/view.html.")] = None,
    open_: Open = False,
) -> None:
    """Write a page with the curves of several runs over each other, and a table of what differs in their parameters."""
    from ..vehicle.view import view as write

    written = write(folders, out or Path("results", "view.html"), typed())
    print(written, file=sys.stderr)
    opened(written, open_)
