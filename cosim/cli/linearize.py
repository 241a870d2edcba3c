"""`ahv linearize`."""
import json
from pathlib import Path
from typing import Annotated, Any

import typer

from ..errors import UsageError
from ..vehicle.closed_loop import assignments
from .ending import ended_in_any_case
from .options import Altitude, Controller, Json, Plant, Preset, Set, Step, Velocity, place
from .show import report, report_poles, report_rows, report_zeros

OF_THE_LOOP = ("V", "h", "controller", "preset", "plant", "scale", "step", "of")  # what an FMU alone does not have
NAMES = {"open_loop": "open loop", "closed_loop": "closed loop", "law": "controller", "system": "FMU"}


def linearize(
    context: typer.Context,
    file: Annotated[Path | None, typer.Argument(metavar="[FILE.fmu]", parser=place, help="An FMU with model exchange, "
                    "which is linearised alone; else the vehicle's closed loop is.")] = None,
    V: Velocity = 7700.0,
    h: Altitude = 85000.0,
    controller: Controller = "neural",
    preset: Preset = None,
    plant: Plant = "ideal",
    scale: Annotated[float, typer.Option(help="Factor on every coefficient group.")] = 1.0,
    step: Step = 0.01,
    of: Annotated[str, typer.Option(metavar="controller|plant|loop", help="What to tell of: the controller as it "
                  "flies, the plant alone, or the loop.")] = "loop",
    time: Annotated[float, typer.Option(help="Of FILE.fmu: linearise where it is after so many seconds.")] = 0.0,
    set_: Set = [],  # noqa: B006
    out: Annotated[Path | None, typer.Option(metavar="FILE.mat|.json", parser=place,
                                             help="File for matrices, poles, zeros and margins.")] = None,
    as_json: Json = False,
) -> None:
    """Linearise the closed loop about level flight, or any FMU alone: poles, zeros, damping, margins at each signal.

    An FMU's own directional derivatives are taken where it has them, else differences. Values of FILE.fmu are set by
    --set VARIABLE=VALUE: parameters, inputs, and continuous states.
    """
    if file:
        refuse(context, OF_THE_LOOP, f"{file.name} is linearised alone")
    else:
        refuse(context, ("time",), "it belongs to FILE.fmu, and none is given")
    from ..analysis.save import save  # scipy is slow to import

    with save(out) as keep, ended_in_any_case():
        keep(found := alone(file, set_, time) if file else loop(controller, preset, plant, V, h, scale, step, set_, of))
    if as_json:
        print(json.dumps(found))
        return
    show(found)


def refuse(context: typer.Context, names: tuple[str, ...], reason: str) -> None:
    """Raise UsageError if an option of `names` is on the command line."""
    for name in names:
        source = context.get_parameter_source(name)
        if source and source.name == "COMMANDLINE":
            raise UsageError(f"--{name} cannot be given here: {reason}.")


def alone(file: Path, words: list[str], time: float) -> dict[str, Any]:
    """One FMU, see `linearize_fmu`."""
    from ..analysis import linearize_fmu

    return linearize_fmu(file, words, time)


def loop(controller: str, preset: str | None, plant: str, V: float, h: float, scale: float, step: float,
         words: list[str], of: str) -> dict[str, Any]:
    """The vehicle's loop, see `vehicle.linearize`."""
    from ..vehicle.linearize import linearize as linearize_loop

    return linearize_loop(controller, preset, plant, V, h, scale, step, assignments(words), of)


def show(found: dict[str, Any]) -> None:
    """Tables: what was linearised, poles, zeros, margins."""
    systems = {NAMES[key]: found[key] for key in NAMES if found.get(key)}
    hidden = ("scale", "margins", *NAMES)
    report({key: value for key, value in found.items() if key not in hidden and value != {}}, False)
    report_poles(systems)
    for system in systems.values():
        report_zeros(system if "zeros" in system else {"zeros": {}})
    margins = found.get("margins") or {}
    if margins:
        report_rows({key: {place: m[key] for place, m in margins.items()} for key in next(iter(margins.values()))})
