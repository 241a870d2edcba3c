"""`ahv fit`."""
import os
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..errors import UsageError
from ..vehicle.closed_loop import FOLLOWS, assignments, chosen_presets
from .options import Columns, Controller, Figures, Flavour, Json, Out, Plant, Preset
from .show import conclude, note, report, report_rows
from .systems import for_scenarios_only

if TYPE_CHECKING:
    from ..fitting.fit import Subject


def fit(
    system: Annotated[str, typer.Argument(metavar="SYSTEM", help="An FMU, an SSP, a system file, or what `ahv run` "
                                          "flies: case1, case2, hold, or a scenario file.")],
    data: Annotated[list[str], typer.Argument(metavar="DATA.csv|.parquet...", help="Measured signals, a flight each: "
                    "a column time (s), and one for each signal or input.")],
    parameter: Annotated[list[str], typer.Option("--parameter", metavar="NAME[=START|=LOW:HIGH|=START:LOW:HIGH]",
                         help="COMPONENT.VARIABLE to find, else within the FMU's limits; FILE:COMPONENT.VARIABLE for "
                         "one flight only. Can be repeated.")] = [],  # noqa: B006
    signal: Annotated[list[str], typer.Option("--signal", metavar="NAME[:SIGMA]", help="A signal to compare, and its "
                      "noise level; else all columns that are signals. Can be repeated.")] = [],  # noqa: B006
    set_: Annotated[list[str], typer.Option("--set", metavar="[FILE:]COMPONENT.VARIABLE=VALUE", help="Set a value in "
                    "all flights, or in that of FILE. Can be repeated.")] = [],  # noqa: B006
    starts: Annotated[int, typer.Option(help="Points that the search begins at; the best end counts.", min=1,
                                         max=10_000)] = 1,
    seed: Annotated[int, typer.Option(help="Of the points' draw.", min=0)] = 1,
    controller: Controller = "neural",
    preset: Preset = None,
    flavour: Flavour = None,
    plant: Plant = "ideal",
    step: Annotated[float | None, typer.Option(help="Communication step, s; else the file's.")] = None,
    start: Annotated[float | None, typer.Option(help="Start time, s; else the file's.")] = None,
    tolerance: Annotated[float | None, typer.Option(help="Relative tolerance for the FMUs; else the file's.")] = None,
    algorithm: Annotated[str | None, typer.Option(metavar="NAME[,OPTION=VALUE]...", help="See ahv simulate.")] = None,
    workers: Annotated[int | None, typer.Option(help="Processes; they do not change the result. Else one for each "
                                                "core.", min=1, max=1000)] = None,
    time_limit: Annotated[float | None, typer.Option(metavar="S", help="Longest wall time of a flight, s; one that "
                                                     "takes longer counts as lost.")] = None,
    figures: Figures = "png",
    columns: Columns = 2,
    out: Out = None,
    as_json: Json = False,
) -> None:
    """Fit parameters of any system to measured signals; write values with intervals to results/fit/SYSTEM."""
    from ..fitting.results import fit_into
    from ..pictures import Format

    form = Format(figures, columns)
    with subject_of(system, controller, preset, flavour, plant, start, tolerance, parameter, set_) as subject:
        count = workers or min(os.cpu_count() or 1, len(data))
        done, summary, trouble = fit_into(out, subject, data, parameter, signal, set_, start=start, step=step,
                                          algorithm=algorithm, tolerance=tolerance, begin_at=starts, seed=seed,
                                          workers=count, time_limit=time_limit, form=form,
                                          tell=lambda line: print(line, file=sys.stderr, flush=True))
    note(summary["warnings"])
    if as_json:
        report(summary, True)
    else:
        show(summary)
    conclude(done.finished, [done.message], trouble)


@contextmanager
def subject_of(word: str, controller: str, preset: str | None, flavour: str | None, plant: str, start: float | None,
               tolerance: float | None, parameters: Sequence[str], values: Sequence[str]) -> "Iterator[Subject]":
    """The system that a word names: a scenario's loop, or a file's. Raises UsageError for what does not fit."""
    from ..fitting.fit import Subject
    from ..fitting.fit import subject_of as of_file
    from ..systems.load import ENDINGS, Loaded, load_system
    from ..systems.system_file import is_system_file
    from ..systems.words import DEFAULT_STEP
    from ..vehicle import scenarios
    from ..vehicle.closed_loop import closed_loop

    if is_system_file(word) or Path(word).suffix.lower() in ENDINGS[:3]:
        for_scenarios_only(word, "a system", controller, preset, flavour, plant, None)
        with load_system(word) as found:
            yield of_file(found)
        return
    if start is not None or tolerance is not None:
        raise UsageError(f"--start and --tolerance are for systems from files; {word} is a scenario.")
    check_follows(parameters, values)
    plan = scenarios.load(word)

    def build(values: Sequence[str]) -> Any:
        loop = closed_loop(plan, controller, plant, flavour, chosen_presets(preset), assignments(values))
        return type(loop.system)(loop.system.components, loop.system.connections, DEFAULT_STEP, plan.stop)

    given = (("--controller", controller, "neural"), ("--preset", preset, None), ("--flavour", flavour, None),
             ("--plant", plant, "ideal"))
    command = ["ahv", "run", word, *(text for option, said, usual in given if said != usual
                                     for text in (option, str(said)))]
    yield Subject(Loaded(Path(word), plan.name, build([]), {}), build, tuple(command))


def check_follows(parameters: Sequence[str], values: Sequence[str]) -> None:
    """Raises UsageError for a start that is to be found while the scenario's command would follow it."""
    for command, start in FOLLOWS.items():
        for word in parameters:
            if f":{word.partition('=')[0]}".endswith(f":plant.{start}") and f"scenario.{command}=" not in str(values):
                raise UsageError(f"--parameter {word}: the scenario's command would follow plant.{start}; give it with "
                                 f"--set scenario.{command}=VALUE.")


def show(summary: dict[str, Any]) -> None:
    """Tables: the fit, its parameters, its signals."""
    report({"system": summary["system"], "flights": len(summary["flights"]), "flown": summary["flown"],
            "reduced chi square": summary["reduced_chi_square"], "out": summary["out"]}, False)
    parameters = summary["parameters"].items()
    report_rows({"value": {name: f"{found['value']:.6g}" for name, found in parameters},
                 "95 % interval": {name: interval(found) for name, found in parameters},
                 "start": {name: f"{found['start']:.6g}" for name, found in parameters},
                 "unit": {name: found["unit"] or "1" for name, found in parameters}})
    signals = summary["signals"].items()
    report_rows({"rms before": {name: shown(found["rms_before"]) for name, found in signals},
                 "rms after": {name: shown(found["rms_after"]) for name, found in signals},
                 "noise level": {name: f"{found['noise']:.4g}, {found['noise_from']}" for name, found in signals},
                 "unit": {name: found["unit"] or "1" for name, found in signals}})
    for flight in summary["flights"][:1]:
        if flight["command"]:
            print(f"{flight['file']} with these values: {flight['command']}")


def interval(found: dict[str, Any]) -> str:
    """A parameter's interval as a table has it."""
    return "none" if found["interval_95"] is None else " to ".join(f"{x:.6g}" for x in found["interval_95"])


def shown(value: float | None) -> str:
    """An rms as a table has it."""
    return "" if value is None else f"{value:.4g}"
