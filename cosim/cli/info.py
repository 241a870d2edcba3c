"""`ahv info`."""
import json
from typing import Annotated

import typer

from .options import Flavour, Json


def info(
    what: Annotated[str, typer.Argument(metavar="FMU|COMPONENT|SCENARIO", help="An FMU file; scenario, controller, "
                                        "plant or the name of a law or plant; a scenario.")],
    flavour: Flavour = None,
    as_json: Json = False,
) -> None:
    """Show what can be set and seen: variables with unit, range and start value, and presets."""
    from ..vehicle.about import about

    found = about(what, flavour)
    print(json.dumps(found.to_dict()) if as_json else found)
