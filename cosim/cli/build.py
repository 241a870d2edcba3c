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
    fmi: Annotated[str, typer.Option(help="Version of FMI: 2, 3 or all. The Python flavour has 2 only.")] = "all",
) -> None:
    """Write the FMU files to fmus/dist/FLAVOUR/, those of FMI 3.0 to fmus/dist/native-fmi3/."""
    from fmus.build import FLAVOURS, versions
    from fmus.build import build as build_one
    from fmus.check_model import ModelError

    for name in models or []:
        if name not in MODELS:
            raise UsageError(f"There is no model {name}; there are {', '.join(MODELS)}.")
    choice("fmi", fmi, ("2", "3", "all"))
    kinds = FLAVOURS if flavour == "all" else [choice("flavour", flavour, [*FLAVOURS, "all"])]
    wanted = [(kind, version) for kind in kinds for version in versions(kind) if fmi in (version, "all")]
    if not wanted:
        raise UsageError(f"--fmi {fmi} has no FMU of the flavour {flavour}, which is for FMI {versions(flavour)[0]}.")
    try:
        for kind, version in wanted:
            for name in models or MODELS:
                print(build_one(MODELS[name], kind, fmi=version), file=sys.stderr)
    except ModelError as error:
        raise UsageError(str(error)) from None
