"""Control laws on the same run: a table, and figures with a curve for each."""
import json
import re
import time
import zipfile
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from .. import pictures
from ..errors import UsageError
from ..master.course import Course
from ..master.flight import Flight
from ..master.fmu import FmuFile
from ..master.folder import claimed
from ..master.guard import POSSIBLE
from ..master.isolated import launch
from ..master.publish import publish
from ..master.system import System
from ..names import safe
from ..pictures import COMMAND, PNG, REFERENCE, Curve, Format
from ..text import without_math
from . import burden, scenarios
from .closed_loop import ClosedLoop, closed_loop, flavour_of
from .figures import PLAIN, Panel, available
from .limits import explained
from .metrics import HEADLINES, METRICS, metrics
from .registry import LAWS
from .run import said_of, shown_by
from .scenarios import Scenario
from .signals import course, known, source
from .variants import Variant

BASE = "neural"  # the law that variants are flown beside
SETTLED = 0.02  # of a command's step

# figure's name, title, panels. Curves with a line of their own are drawn once, the others for each flight.
PICTURES: list[tuple[str, str, tuple[Panel, ...]]] = [
    ("velocity", "Velocity tracking", (
        Panel("V (ft/s)", (("reference", "controller.V_reference", REFERENCE), ("", "plant.V", PLAIN)),
              also=(("command", "scenario.V_command", COMMAND),)),
        Panel("V error (ft/s)", (("", "plant.V - controller.V_reference", PLAIN),)))),
    ("altitude", "Altitude tracking", (
        Panel("h (ft)", (("reference", "controller.h_reference", REFERENCE), ("", "plant.h", PLAIN)),
              also=(("command", "scenario.h_command", COMMAND),)),
        Panel("h error (ft)", (("", "plant.h - controller.h_reference", PLAIN),)))),
    ("attitude", "Attitude angles", (
        Panel("γ (deg)", (("", "plant.gamma", PLAIN),), True),
        Panel("θ (deg)", (("", "plant.theta", PLAIN),), True),
        Panel("Q (deg/s)", (("", "plant.Q", PLAIN),), True))),
    ("inputs", "Control inputs", (
        Panel("fuel ratio Φ (1)", (("", "controller.fuel_ratio", PLAIN),)),
        Panel("elevator δₑ (deg)", (("", "controller.elevator", PLAIN),), True))),
    ("flexible", "Flexible states", (
        Panel("η₁ (√(slug ft))", (("", "plant.eta1", PLAIN),)),
        Panel("η₂ (√(slug ft))", (("", "plant.eta2", PLAIN),)))),
]


def settling(time: np.ndarray, command: np.ndarray, found: np.ndarray) -> float | None:
    """Longest time (s) from a step of the command until `found` stays within SETTLED of that step, up to the
    next; None without a step, or where it does not settle."""
    edges = [0, *(np.flatnonzero(np.diff(command)) + 1), len(command)]
    worst: float | None = None
    for begin, end in pairwise(edges):
        height = abs(command[begin] - (found[0] if begin == 0 else command[begin - 1]))
        if height < 1e-6 or end - begin < 2:
            continue
        took = Course(time[begin:end], found[begin:end]).settling(float(command[begin]), SETTLED * height)
        if took is None or np.isnan(took):
            return None
        worst = max(worst or 0.0, took)
    return worst


def figures_of(flight: Flight) -> dict[str, Any]:
    """What a flight is compared by."""
    result = metrics(flight)
    del result["phi_hat"]
    for name, key in (("h", "altitude_settling_s"), ("V", "velocity_settling_s")):
        pair = f"scenario.{name}_command", source(flight, f"plant.{name}_true")
        rows = flight.together(pair)
        result[key] = settling(flight.time[rows], *(np.asarray(flight[one])[rows] for one in pair))
    saturated = result.pop("saturated_s")
    result |= {"elevator_saturated_s": saturated["elevator"], "fuel_saturated_s": saturated["fuel_ratio"]}
    return {"finished": flight.finished, "departed_at_s": None if flight.finished else flight.reached, **result}


def size_of(path: Path, preset: str | None) -> dict[str, int | None]:
    """States (as a native FMU's sources tell), parameters, and parameters that the preset sets."""
    with FmuFile.open(path) as file:
        parameters, tuned = len(file.names("parameter")), len(file.preset(preset)) if preset else None
    with zipfile.ZipFile(path) as archive:
        header = archive.read("sources/model.h").decode() if "sources/model.h" in archive.namelist() else ""
    states = re.search(r"\bNX = (\d+)", header)
    return {"states": int(states[1]) if states else None, "parameters": parameters, "preset_parameters": tuned}


def whole(system: System, step: float, stop: float, record: list[str] | None = None) -> Flight:
    """`launch` in a process of its own where that is possible. Raises Interrupted after a signal: a part of a flight
    compares to nothing."""
    flight = launch(system, step, stop, isolate=POSSIBLE, record=record)
    flight.check_interrupted()
    return flight


def controller_alone(loop: ClosedLoop) -> System:
    """The controller of a loop, connected to nothing."""
    return System(tuple(c for c in loop.system.components if c.name == "controller"), ())


def loops_of(plan: Scenario, controllers: list[str], plant: str, flavour: str) -> dict[str, ClosedLoop]:
    """Column -> loop: each of `controllers` (none: all of ours) with the presets that the registry compares."""
    loops: dict[str, ClosedLoop] = {}
    for word in controllers or LAWS:
        presets = LAWS[word].compared if word in LAWS else (None,)
        for preset in presets:
            loop = closed_loop(plan, word, plant, flavour, {"controller": preset} if preset else {})
            column = loop.controller if preset == presets[0] else f"{loop.controller}, {preset}"
            if column in loops:
                raise UsageError(f"--controller {word}: there are two controllers called {column}.")
            loops[column] = loop
    return loops


def shown(column: str) -> str:
    """A column's name with what has to be said of its law."""
    remark = LAWS[column].remark if column in LAWS else ""
    return f"{column} ({remark})" if remark else column


def compare(scenario: str | Scenario, controllers: list[str] | None = None, plant: str = "ideal",
            flavour: str | None = None, step: float = 0.01, stop: float | None = None, out: Path | None = None,
            runs: Sequence[Variant] = (), command: str = "", form: Format = PNG
            ) -> tuple[dict[str, Any], dict[str, Flight], list[str], str]:
    """Fly `controllers` (words of the registry or anybody's FMUs as NAME=FILE.fmu; none: all of ours) on one scenario.

    `runs` are variants that are flown, too; without `controllers`, they are flown beside the neural law. `command` is
    what the page says that it was made by.

    Returns the summary as compare.json has it, the flights by column, notes, and which results did not find room (empty
    if all did). Writes compare.json, figures as `form` says, a page, and the signals of each run to `out`, else
    to results/compare/SCENARIO. Raises what `run` raises.
    """
    plan = scenarios.load(scenario) if isinstance(scenario, str) else scenario
    flavour = flavour_of(flavour)
    with claimed(out, "compare", plan.name) as folder:
        loops = loops_of(plan, controllers or [BASE] * bool(runs), plant, flavour)
        add(loops, runs, plan, plant, flavour)
        end = plan.stop if stop is None else stop
        flights: dict[str, Flight] = {}
        rows: dict[str, dict[str, Any]] = {}
        for column, loop in loops.items():
            began = time.perf_counter()
            flights[column] = explained(whole(loop.system, step, end))
            fmu = next(c.fmu for c in loop.system.components if c.name == "controller")
            rows[column] = {"preset": loop.preset, **figures_of(flights[column]), **size_of(fmu, loop.preset),
                            "wall_s": time.perf_counter() - began}
        for row, cost in zip(rows.values(), burden.costs([controller_alone(loop) for loop in loops.values()], step)):
            row |= cost
        summary = {"scenario": plan.name, "flavour": flavour, "step_s": step, "controllers": rows,
                   "verdict": verdict(rows)}
        notes = list(dict.fromkeys(note for loop in loops.values() for note in loop.notes))
        records = {column: {**said_of(plan, loop, "gauss-seidel", step, end), **shown_by(flights[column])}
                   for column, loop in loops.items()}
        published = publish(folder, "compare", summary, lambda place: None,
                            [lambda place: write(place, flights, plan.name, form),
                             lambda place: write_page(place, summary, flights, command, notes),
                             lambda place: write_runs(place, flights, records)])
    return {**summary, "out": str(published.folder)}, flights, notes, published.trouble


def add(loops: dict[str, ClosedLoop], runs: Sequence[Variant], plan: Scenario, plant: str, flavour: str) -> None:
    """Add the loops of `runs` as columns. Raises UsageError for a name that there is already, and as `closed_loop`."""
    for one in runs:
        if one.name in loops:
            raise UsageError(f"--run {one.name}: there are two runs called {one.name}.")
        loops[one.name] = one.loop(plan, plant, flavour)


BETTER = (*((METRICS[name].headline, name.split("."), METRICS[name].unit) for name in HEADLINES),
          ("cost per step", [burden.COST], "us"))


def verdict(table: dict[str, dict[str, Any]]) -> str:
    """One sentence: which law has the smallest figure in what. Costs whose spreads overlap are no difference."""
    departed = [law for law, row in table.items() if not row["finished"]]
    if departed:
        return f"{' and '.join(shown(law) for law in departed)} departed."
    won: dict[str, list[str]] = {law: [] for law in table}
    undecided = ""
    for name, keys, unit in BETTER:
        found = {}
        for law, row in table.items():
            value: Any = row
            for key in keys:
                value = value[key]
            found[law] = value
        best = [min(found, key=found.__getitem__)] if keys != [burden.COST] else burden.alike(table)
        smallest = " and ".join(f"{found[law]:.3g}" for law in best)
        others = " and ".join(f"{v:.3g}" for law, v in found.items() if law not in best)
        figures = f"({smallest}{f' against {others}' if others else ''} {unit})"
        if len(best) == 1:
            won[best[0]].append(f"{name} {figures}")
        else:
            undecided = f"; no difference in {name} was measured between {' and '.join(map(shown, best))} {figures}"
    sentences = [f"{shown(law)} has the smallest {', '.join(what)}" for law, what in won.items() if what]
    return "; ".join(sentences) + undecided + "."


def draw(flights: dict[str, Flight], title: str, panels: tuple[Panel, ...], columns: int = 2) -> Figure:
    """One figure: a panel for each quantity, a curve for each flight; and where they differ most, drawn larger."""
    found = [panel_of(flights, panel) for panel in panels]
    return pictures.over_time(found, without_math(title), columns, pictures.where_they_differ(found))


def panel_of(flights: dict[str, Flight], panel: Panel) -> pictures.Panel:
    """The panel with the values of all flights."""
    curves = []
    for name, expression, line in (*panel.curves, *panel.also):
        for law, flight in flights.items():
            if known(flight, expression):
                one = course(flight, expression)
                values = np.degrees(one.values) if panel.degrees else one.values
                curves.append(Curve(name if line else without_math(shown(law)), one.time, values, line))
            if line:
                break
    return pictures.Panel(panel.ylabel, curves)


def write(folder: Path, flights: dict[str, Flight], name: str, form: Format = PNG) -> None:
    """Every picture into `folder`, a file for each."""
    for key, title, panels in PICTURES:
        if all(available(flight, panels) for flight in flights.values()):
            pictures.save(draw(flights, f"{name}: {title}", panels, form.columns), folder / f"compare_{key}", form)


def write_page(folder: Path, summary: dict[str, Any], flights: dict[str, Flight], command: str, notes: list[str]
               ) -> None:
    """The page of all flights into `folder`. Raises OSError."""
    from ..pages.write import REPORT, page
    from .look import PANELS, looked_at

    flown = [looked_at(column, flight, summary["controllers"][column]) for column, flight in flights.items()]
    (folder / REPORT).write_text(page(f"{summary['scenario']} compared", flown, PANELS, command,
                                      [summary["verdict"], *notes]), encoding="utf-8")


def write_runs(folder: Path, flights: dict[str, Flight], records: Mapping[str, dict[str, Any]]) -> None:
    """The signals and run.json of each flight, a folder each, as `ahv view` reads them. Raises OSError."""
    from ..master.results import SIGNALS, record_of, table, write_parquet

    for column, flight in flights.items():
        place = folder / "runs" / safe(column)
        place.mkdir(parents=True)
        write_parquet(table(flight), place / SIGNALS)
        record = record_of(flight, {key: value for key, value in records[column].items() if key != "first_figure"})
        (place / "run.json").write_text(json.dumps({"kind": "run", **record}, indent=2) + "\n")
