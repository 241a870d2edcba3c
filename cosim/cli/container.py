"""`ahv container`."""
import sys
from contextlib import ExitStack
from pathlib import Path
from typing import Annotated

import typer

from ..errors import UsageError, did_you_mean
from ..master.system import System, Value
from ..vehicle.closed_loop import assignments, chosen_presets
from .options import Controller, Flavour, Plant, Preset, Set, Uncertainty
from .show import note

DEFAULT_STEP = 0.01  # s, as that of `ahv run`


def container(
    system: Annotated[str, typer.Argument(metavar="SYSTEM.ssp|SCENARIO", help="An SSP 1.0 file, or what `ahv run` "
                                          "flies: case1, case2, hold, or a scenario file.")],
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
    out: Annotated[Path | None, typer.Option(help="File; else results/SYSTEM.fmu.")] = None,
) -> None:
    """Write a system as one FMU, which exchanges values as the algorithm jacobi does."""
    from ..master.flight import tick_count
    from ..master.folder import expanded
    from ..ssp.container import write_container
    from ..ssp.load import load_ssp
    from ..vehicle import scenarios
    from ..vehicle.closed_loop import closed_loop

    with ExitStack() as stack:
        if Path(system).suffix.lower() == ".ssp":
            if (controller, preset, flavour, plant, uncertainty) != ("neural", None, None, "ideal", None):
                raise UsageError(f"--controller, --preset, --flavour, --plant and --uncertainty are for scenarios; "
                                 f"{system} is an SSP.")
            found = stack.enter_context(load_ssp(system))
            name, what, stop = found.name, with_values(found, assignments(set_)), found.stop
        else:
            plan = scenarios.load(system)
            loop = closed_loop(plan, controller, plant, flavour, chosen_presets(preset), assignments(set_), uncertainty)
            note(loop.notes)
            name, what, stop = plan.name, loop.system, plan.stop
        size = what.step or DEFAULT_STEP if step is None else step
        tick_count(size, size if stop is None else stop)
        path = expanded(out) if out else Path("results") / f"{Path(system).stem}.fmu"
        note(write_container(path, name, what, size, stop, connector or None))
    print(path, file=sys.stderr)


def with_values(system: System, values: dict[str, dict[str, Value]]) -> System:
    """`system` with `values` (component -> variable -> value). Raises UsageError for an unknown component."""
    known = [c.name for c in system.components]
    for name in values:
        if name not in known:
            raise UsageError(f"--set {name}: there is no such component{did_you_mean(name, known)}")
    return System([c.with_values(values.get(c.name, {})) for c in system.components], system.connections, system.step,
                  system.stop)
