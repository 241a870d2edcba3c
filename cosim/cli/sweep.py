"""`ahv sweep`."""
import json
from os.path import isfile
from pathlib import Path
from typing import Annotated, Any

import typer

from .campaign import table
from .options import Json, Preset, Set, place
from .show import report
from .systems import for_scenarios_only


def sweep(
    system: Annotated[str, typer.Argument(metavar="SCENARIO|SYSTEM", help="case1, case2, hold, or a scenario file; or "
                                          "an FMU, an SSP, or a system file.")],
    variables: Annotated[list[str], typer.Argument(metavar="VARIABLE=A:B:N|VARIABLE=V1,V2...", help="N values from A "
                                                   "to B, or those of a list; COMPONENT.VARIABLE each.")],
    metric: Annotated[list[str], typer.Option("--metric", metavar="NAME=EXPRESSION", help="A metric of recorded "
                      "signals, such as overshoot=max(plant.h). Can be repeated.")] = [],  # noqa: B006
    success: Annotated[list[str], typer.Option("--success", metavar="[NAME=]EXPRESSION", help="What counts as a "
                       "success besides reaching the end. Can be repeated.")] = [],  # noqa: B006
    controller: Annotated[list[str], typer.Option("--controller", metavar="NAME|NAME=FILE.fmu", help="Of a scenario; "
                          "else neural. Can be repeated.")] = [],  # noqa: B006
    preset: Preset = None,
    flavour: Annotated[str | None, typer.Option(help="native, native-fmi3 or python; else native.")] = None,
    plant: Annotated[str, typer.Option(metavar="NAME|FILE.fmu", help="Of a scenario.")] = "ideal",
    step: Annotated[float | None, typer.Option(help="Communication step, s; else the system's, or 0.01.")] = None,
    stop: Annotated[float | None, typer.Option(help="Stop time, s; else the system's.")] = None,
    algorithm: Annotated[str | None, typer.Option(metavar="NAME[,OPTION=VALUE]...", help="As of `ahv run`; else the "
                                                  "system's, or gauss-seidel.")] = None,
    set_: Set = [],  # noqa: B006
    workers: Annotated[int | None, typer.Option(help="Local worker processes; else one for each core.", min=1,
                                                          max=1000)] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Continue an interrupted sweep.")] = False,
    out: Annotated[Path | None, typer.Option(metavar="DIR", parser=place, help="Folder; else results/sweep/NAME."
                                             )] = None,
    as_json: Json = False,
) -> None:
    """Fly every combination of the values of some variables, and draw each metric over them.

    One variable gives lines, two a map, more a map for each value of the others. The folder has a campaign file, which
    `ahv campaign` flies again, also on a cluster.
    """
    from ..campaign.sweep import called
    from ..campaign.sweep import sweep as fly
    from ..vehicle.campaigns import Laws

    values = dict(word.partition("=")[::2] for word in set_)
    about: dict[str, Any] = {"name": called(system, variables), **said(step=step, stop=stop, algorithm=algorithm,
                                                                       set=values)}
    if is_system(system):
        for_scenarios_only(system, "a system", (controller or ["neural"])[0], preset, flavour, plant, None)
        about["system"] = str(place(system).absolute())
    else:
        about |= scenario(system, controller, preset, flavour, plant)
    summary = fly(about, variables, metric, success, out, resume, workers, [Laws])
    if as_json:
        print(json.dumps(summary))
    else:
        report(table(summary), False)


def is_system(word: str) -> bool:
    """Whether a word names a system's file, not a scenario."""
    from ..systems.load import ENDINGS
    from ..systems.system_file import is_system_file

    return is_system_file(word) if word.endswith((".yaml", ".yml")) else word.lower().endswith(ENDINGS)


def scenario(word: str, controller: list[str], preset: str | None, flavour: str | None, plant: str) -> dict[str, Any]:
    """The fields of a campaign file for a scenario."""
    from ..vehicle.closed_loop import chosen_presets
    from ..vehicle.scenarios import BUILT_IN

    presets = chosen_presets(preset)
    own = said(preset=presets.pop("controller", None))
    named = [absolute(law) for law in controller or ["neural"]]
    laws = [{"law": law, **own} if own else law for law in named]
    return {"scenario": str(place(word).absolute()) if word not in BUILT_IN and isfile(place(word)) else word,
            "controllers": laws, **said(presets=presets, flavour=flavour, plant=absolute(plant))}


def absolute(word: str) -> str:
    """A word for a law or a plant, with the file that it names (if it names one) as an absolute path."""
    from ..vehicle.closed_loop import names_file

    name, equals, file = word.rpartition("=")
    return f"{name}{equals}{place(file).absolute()}" if names_file(word) else word


def said(**options: Any) -> dict[str, Any]:
    """Those options that were given."""
    return {name: value for name, value in options.items() if value not in (None, {}, [])}
