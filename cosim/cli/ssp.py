"""`ahv ssp`."""
import sys
from pathlib import Path
from typing import Annotated

import typer

from ..vehicle.closed_loop import assignments, chosen_presets
from .options import Controller, Flavour, Plant, Preset, ScenarioWord, Set, Uncertainty
from .show import note


def ssp(
    scenario: ScenarioWord = "case1",
    controller: Controller = "neural",
    preset: Preset = None,
    flavour: Flavour = None,
    plant: Plant = "ideal",
    step: Annotated[float, typer.Option(help="Communication step to suggest, s.")] = 0.01,
    uncertainty: Uncertainty = None,
    set_: Set = [],  # noqa: B006
    out: Annotated[Path | None, typer.Option(help="File; else results/SCENARIO.ssp.")] = None,
) -> None:
    """Write the closed loop as SSP 1.0, for any tool that reads it."""
    from ..master.flight import tick_count
    from ..master.folder import expanded
    from ..ssp.write import write
    from ..vehicle import scenarios
    from ..vehicle.closed_loop import closed_loop

    plan = scenarios.load(scenario)
    tick_count(step, plan.stop)
    loop = closed_loop(plan, controller, plant, flavour, chosen_presets(preset), assignments(set_), uncertainty)
    path = expanded(out) if out else Path("results") / f"{plan.name}.ssp"
    write(path, plan.name, loop.system, step, plan.stop)
    note(loop.notes)
    print(path, file=sys.stderr)
