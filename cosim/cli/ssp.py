"""`ahv ssp`."""
import sys
from contextlib import ExitStack
from pathlib import Path
from typing import Annotated

import typer

from ..vehicle.closed_loop import assignments, chosen_presets
from .options import Controller, Flavour, Plant, Preset, Set, Uncertainty, place
from .show import note
from .systems import for_scenarios_only


def ssp(
    scenario: Annotated[str, typer.Argument(metavar="[SCENARIO|SYSTEM.yaml]", help="What `ahv run` flies: case1, "
                                            "case2, hold, or a scenario file; or a system file.")] = "case1",
    controller: Controller = "neural",
    preset: Preset = None,
    flavour: Flavour = None,
    plant: Plant = "ideal",
    step: Annotated[float | None, typer.Option(help="Communication step to suggest, s; else the file's; else 0.01."
                                               )] = None,
    uncertainty: Uncertainty = None,
    set_: Set = [],  # noqa: B006
    out: Annotated[Path | None, typer.Option(metavar="FILE", parser=place, help="File; else results/NAME.ssp.")] = None,
) -> None:
    """Write the closed loop, or any system, as SSP 1.0, for any tool that reads it."""
    from ..master.fly import tick_count
    from ..ssp.write import write
    from ..systems.load import load_system
    from ..systems.system_file import is_system_file
    from ..systems.words import DEFAULT_STEP, assigned, experiment
    from ..vehicle import scenarios
    from ..vehicle.closed_loop import closed_loop

    with ExitStack() as stack:
        if is_system_file(scenario):
            for_scenarios_only(scenario, "a system", controller, preset, flavour, plant, uncertainty)
            found = stack.enter_context(load_system(scenario))
            name, system, notes = found.name, assigned(set_, found), found.remarks
            start, stop, size, remarks = experiment(found, None, None, step)
            notes += remarks
        else:
            plan = scenarios.load(scenario)
            loop = closed_loop(plan, controller, plant, flavour, chosen_presets(preset), assignments(set_), uncertainty)
            size = DEFAULT_STEP if step is None else step
            name, system, notes, start, stop = plan.name, loop.system, loop.notes, 0.0, plan.stop
        tick_count(size, stop, start)
        path = out or Path("results") / f"{name}.ssp"
        write(path, name, system, size, stop)
    note(notes)
    print(path, file=sys.stderr)
