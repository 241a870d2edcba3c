"""One flight of a scenario, from words to a folder of results: what `ahv run` does."""
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..master.flight import Flight
from ..master.isolated import launch
from ..master.progress import progress_bar
from . import scenarios
from .closed_loop import ClosedLoop, Values, closed_loop
from .limits import explained
from .metrics import metrics
from .scenarios import Scenario


@dataclass(frozen=True)
class Run:
    """A flight with its figures of merit, as run.json has them, and the folder that has everything."""
    flight: Flight
    summary: dict[str, Any]
    out: Path
    notes: list[str]


def run(scenario: str | Scenario, controller: str = "neural", preset: Mapping[str, str] | str | None = None,
        plant: str = "ideal", flavour: str | None = None, step: float = 0.01, stop: float | None = None,
        algorithm: str = "gauss-seidel", values: Values | None = None, uncertainty: float | None = None,
        decimate: int = 1, stream: bool = False, isolate: bool = False, time_limit: float | None = None,
        plain: bool = False, real_time: float | None = None, out: Path | None = None, progress: bool = False) -> Run:
    """Fly `scenario` (a built-in name, a YAML file or a Scenario) and write signals, run.json and figures.

    `controller` and `plant` are words of the registry or anybody's FMUs (NAME=FILE.fmu); `preset` is the controller's,
    or component -> name. `values` are set last: component -> variable -> value. `step`, `stop` are in s. The results
    go to `out`, else to results/SCENARIO. Other arguments are those of `master.flight.fly`.

    Raises UsageError for what cannot be flown, RunError if an FMU does not start. A flight that ends early is a
    result: `flight.finished` is False and `flight.message` says why.
    """
    from ..master.results import prepare_folder, write

    plan = scenarios.load(scenario) if isinstance(scenario, str) else scenario
    presets = {"controller": preset} if isinstance(preset, str) else dict(preset or {})
    loop = closed_loop(plan, controller, plant, flavour, presets, values, uncertainty)
    folder = out or Path("results") / plan.name
    prepare_folder(folder)
    end = plan.stop if stop is None else stop
    options: dict[str, Any] = {"decimate": decimate, "stream": folder / "signals.parquet"} if stream else {}
    bar, tell = progress_bar(plan.name, end)
    with bar:
        flight = explained(launch(loop.system, step, end, algorithm, tell if progress else None,
                                  isolate or loop.foreign, time_limit, plain=plain, real_time=real_time, **options))
    summary = {**said_of(plan, loop, algorithm, step, end), **shown_by(flight), "out": str(folder),
               **({"lateness": flight.lateness} if flight.lateness else {})}
    write(folder, flight, {**summary, "presets": presets_of(loop)}, decimate, stream)
    draw(folder, flight, plan, loop)
    return Run(flight, summary, folder, [*loop.notes, *part_of_the_rows(flight, stream)])


def said_of(plan: Scenario, loop: ClosedLoop, algorithm: str, step: float, stop: float
            ) -> dict[str, Any]:
    """What run.json says of the request."""
    return {"scenario": plan.name, "controller": loop.controller, "preset": loop.preset, "flavour": loop.flavour,
            "algorithm": algorithm, "step_s": step, "stop_s": stop}


def shown_by(flight: Flight) -> dict[str, Any]:
    """What run.json says of the flight."""
    return {"ticks": flight.ticks, "finished": flight.finished,
            "departed_at_s": None if flight.finished else flight.reached, "ended_at_s": flight.ended_at,
            **metrics(flight), "real_time_factor": flight.reached / flight.wall_s if flight.ticks else 0.0}


def part_of_the_rows(flight: Flight, stream: bool) -> list[str]:
    """A sentence for whoever reads figures of a streamed flight, of which memory has only a part."""
    if not stream or len(flight.time) > flight.ticks:
        return []
    return [f"metrics and figures are computed from {len(flight.time)} of {flight.ticks + 1} rows: those that --stream "
            f"keeps in memory."]


def presets_of(loop: ClosedLoop) -> dict[str, dict[str, str]]:
    """Whose preset flew, and who said so."""
    return {component: {"name": name, "from": loop.preset_from[component]} for component, name in loop.presets.items()}


def draw(folder: Path, flight: Flight, plan: Scenario, loop: ClosedLoop) -> None:
    """The scenario's figures into `folder`."""
    from .figures import write  # matplotlib is slow to import

    preset = f" ({loop.preset})" if loop.preset else ""
    write(folder, flight, f"{plan.name}, {loop.controller}{preset}", plan.first_figure)
