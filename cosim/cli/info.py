"""`ahv info`."""
from typing import Annotated

import typer

from .options import Json


def info(
    what: Annotated[str, typer.Argument(metavar="FMU|COMPONENT|SCENARIO", help="An FMU file; scenario, controller, "
                                        "plant or one of their names; or a scenario.")],
    as_json: Json = False,
) -> None:
    """Show what can be set and seen: variables with unit, range and start value, and presets."""
    raise NotImplementedError
