"""`ahv build`."""
import sys
from typing import Annotated

import typer

from ..errors import UsageError
from ..vehicle.closed_loop import choice
from ..vehicle.registry import MODELS


def build(
    models: Annotated[list[str] | None, typer.Argument(metavar="[MODEL]...", help=f"{', '.join(MODELS)}; else all.",
                                                       show_default=False)] = None,
    flavour: Annotated[str, typer.Option(help="python, native or all.")] = "all",
    arm: Annotated[bool, typer.Option("--arm", help="Also binaries for Arm (native flavour).")] = False,
) -> None:
    """Write the FMU files to fmus/dist/FLAVOUR/."""
    from fmus.build import FLAVOURS
    from fmus.build import build as build_one

    for name in models or []:
        if name not in MODELS:
            raise UsageError(f"There is no model {name}; there are {', '.join(MODELS)}.")
    for kind in FLAVOURS if flavour == "all" else [choice("flavour", flavour, [*FLAVOURS, "all"])]:
        for name in models or MODELS:
            print(build_one(name, kind, arm=arm), file=sys.stderr)
