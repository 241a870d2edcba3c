"""`ahv linearize`."""
import json
from typing import Annotated

import typer

from ..vehicle.closed_loop import assignments
from .ending import ended_in_any_case
from .options import Altitude, Controller, Json, Plant, Preset, Set, Step, Velocity
from .show import report, report_rows, short


def linearize(
    V: Velocity = 7700.0,
    h: Altitude = 85000.0,
    controller: Controller = "neural",
    preset: Preset = None,
    plant: Plant = "ideal",
    scale: Annotated[float, typer.Option(help="Factor on every coefficient group.")] = 1.0,
    step: Step = 0.01,
    set_: Set = [],  # noqa: B006
    as_json: Json = False,
) -> None:
    """Linearise open and closed loop about level flight: poles, zeros, damping, margins at each actuator and sensor."""
    from ..vehicle.linearize import linearize as linearize_loop

    with ended_in_any_case():
        found = linearize_loop(controller, preset, plant, V, h, scale, step, assignments(set_))
    if as_json:
        print(json.dumps(found))
        return
    report({k: v for k, v in found.items() if not isinstance(v, dict)}, False)
    report_rows({"open loop": short(found["open_loop"]), "closed loop": short(found["closed_loop"])})
    margins = found["margins"] or {}
    report_rows({key: {place: m[key] for place, m in margins.items()} for key in next(iter(margins.values()), {})})
