"""`ahv container`."""
import sys
from contextlib import ExitStack
from pathlib import Path
from typing import Annotated

import typer

from ..vehicle.closed_loop import assignments, chosen_presets
from .options import Controller, Flavour, Plant, Preset, Set, Uncertainty, place
from .show import note
from .systems import for_scenarios_only


def container(
    system: Annotated[str, typer.Argument(metavar="SYSTEM.ssp|SYSTEM.yaml|SCENARIO", help="An SSP, a system file, or "
                                          "what `ahv run` flies: case1, case2, hold, or a scenario file.")],
    connector: Annotated[list[str], typer.Option("--connector", metavar="[NAME=]COMPONENT.VARIABLE", help="An input or "
                         "output of the FMU, * for any; else all outputs and the inputs that nothing feeds. An input "
                         "that is named takes the place of what feeds it. Can be repeated.")] = [],  # noqa: B006
    controller: Controller = "neural",
    preset: Preset = None,
    flavour: Flavour = None,
    plant: Plant = "ideal",
    step: Annotated[float | None, typer.Option(help="Step at which values are exchanged, s; else the file's.")] = None,
    uncertainty: Uncertainty = None,
    set_: Set = [],  # noqa: B006
    out: Annotated[Path | None, typer.Option(metavar="FILE", parser=place,
                                             help="File; else results/SYSTEM.fmu.")] = None,
) -> None:
    """Write a system as one FMU, which exchanges values as the algorithm jacobi does."""
    from ..master.fly import tick_count
    from ..ssp.container import write_container
    from ..systems.load import load_system
    from ..systems.system_file import is_system_file
    from ..systems.words import DEFAULT_STEP, assigned
    from ..vehicle import scenarios
    from ..vehicle.closed_loop import closed_loop

    with ExitStack() as stack:
        ssp = Path(system).suffix.lower() == ".ssp"
        if ssp or is_system_file(system):
            for_scenarios_only(system, "an SSP" if ssp else "a system", controller, preset, flavour, plant, uncertainty)
            found = stack.enter_context(load_system(system))
            note(found.remarks)
            what = assigned(set_, found)
            name, stop = found.name, what.stop
        else:
            plan = scenarios.load(system)
            loop = closed_loop(plan, controller, plant, flavour, chosen_presets(preset), assignments(set_), uncertainty)
            note(loop.notes)
            name, what, stop = plan.name, loop.system, plan.stop
        size = what.step or DEFAULT_STEP if step is None else step
        tick_count(size, what.start + size if stop is None else stop, what.start)
        path = out or Path("results") / f"{Path(system).stem}.fmu"
        note(write_container(path, name, what, size, stop, connector or None))
    print(path, file=sys.stderr)
