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
    from fmus.check_model import ModelError

    for name in models or []:
        if name not in MODELS:
            raise UsageError(f"There is no model {name}; there are {', '.join(MODELS)}.")
    kinds = FLAVOURS if flavour == "all" else [choice("flavour", flavour, [*FLAVOURS, "all"])]
    try:
        for kind in kinds:
            for name in models or MODELS:
                print(build_one(MODELS[name], kind, arm=arm), file=sys.stderr)
    except ModelError as error:
        raise UsageError(str(error)) from None
