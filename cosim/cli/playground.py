"""`ahv playground`."""
import sys
from pathlib import Path
from typing import Annotated

import typer

from .options import new_file


def playground(
    out: Annotated[Path | None, typer.Option(metavar="FILE.html", parser=new_file,
                                             help="The page; else results/playground.html.")] = None,
) -> None:
    """Write a page that flies the closed loop in a browser, with sliders for what can be set (docs/playground.md)."""
    from ..playground.write import playground as write

    print(write(out or Path("results", "playground.html")), file=sys.stderr)
