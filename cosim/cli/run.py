"""`ahv run`."""
from typing import Annotated

import typer

from ..vehicle.closed_loop import assignments, chosen_presets
from .options import (
    Algorithm,
    Columns,
    Controller,
    Decimate,
    Figures,
    Flavour,
    Json,
    Open,
    Out,
    Plant,
    Preset,
    Record,
    ScenarioWord,
    Set,
    Step,
    Stop,
    Stream,
    TimeLimit,
    Uncertainty,
    opened,
    typed,
)
from .show import conclude, note, report


def run(
    scenario: ScenarioWord,
    controller: Controller = "neural",
    preset: Preset = None,
    flavour: Flavour = None,
    plant: Plant = "ideal",
    step: Step = 0.01,
    stop: Stop = None,
    algorithm: Algorithm = "gauss-seidel",
    uncertainty: Uncertainty = None,
    plain: Annotated[bool, typer.Option("--plain", help="Run the tick loop in plain Python, not compiled.")] = False,
    real_time: Annotated[float | None, typer.Option(metavar="[FACTOR]", help="Pace the run, FACTOR (1) times.")] = None,
    live: Annotated[bool, typer.Option("--live", help="Show the flight on a local page while it flies (--real-time 1 "
                                       "unless given), with buttons that step coefficients.")] = False,
    isolate: Annotated[bool, typer.Option("--isolate", hidden=True, help="Every run does so by now.")] = False,
    time_limit: TimeLimit = None,
    stream: Stream = False,
    set_: Set = [],  # noqa: B006  (typer wants a list)
    record: Record = [],  # noqa: B006
    decimate: Decimate = 1,
    figures: Figures = "png",
    columns: Columns = 2,
    out: Out = None,
    open_: Open = False,
    as_json: Json = False,
) -> None:
    """Fly a scenario and write signals, run.json, figures and report.html to results/run/SCENARIO."""
    import webbrowser
    from threading import Thread

    from ..master.guard import POSSIBLE
    from ..pictures import Format
    from ..vehicle.run import run as fly

    def announce(address: str) -> None:
        note([f"the flight is live at\n{address}"])
        if open_:
            Thread(target=webbrowser.open, args=(address,), daemon=True).start()  # some wait for the browser's end

    done = fly(scenario, controller, chosen_presets(preset), plant, flavour, step, stop, algorithm, assignments(set_),
               uncertainty, decimate, stream, isolate or POSSIBLE, time_limit, plain, real_time, out, progress=True,
               record=record, command=typed(), form=Format(figures, columns),
               live=announce if live else None)
    note([*done.notes, *done.flight.warnings])
    report(done.summary, as_json)
    opened(done.out / "report.html", open_ and not live)
    conclude(done.flight.finished, [done.flight.message], done.trouble, done.flight.interrupted)
