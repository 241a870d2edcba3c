"""`ahv simulate`: an SSP file flown by the master, results as `ahv run` writes them."""
import sys
from pathlib import Path
from typing import Any

from ..errors import UsageError
from ..flight import fly, progress_bar
from ..results import prepare_folder, write
from .load import loaded


def simulate(path: Path, step: float | None, stop: float | None, algorithm: str,
             out: Path | None) -> tuple[dict[str, Any], str]:
    """Fly the system in `path`; the summary, and why it ended early (empty if it did not).

    Raises UsageError for a file or numbers that do not fit, RunError if the FMUs cannot be started.
    """
    with loaded(path) as found:
        end = found.stop if stop is None else stop
        size = found.step if step is None else step
        if found.start != 0:
            raise UsageError(f"{path} starts at t = {found.start:g} s; a start other than 0 is not supported.")
        if end is None or size is None:
            option, what = ("--stop", "when to stop") if end is None else ("--step", "how large the step is")
            raise UsageError(f"{path} does not say {what}: give {option}.")
        for name in found.ignored:
            print(f"ahv: the parameter {name} fits no variable and is ignored.", file=sys.stderr)
        folder = out or Path("results") / path.stem
        prepare_folder(folder)
        bar, progress = progress_bar(found.name, end)
        with bar:
            flight = fly(found.system, size, end, algorithm, progress)
    for component, fmu in flight.fmus.items():
        fmu["file"] = f"{path}/{found.sources[component]}"
    last, ticks = float(flight.time[-1]), len(flight.time) - 1
    summary = {
        "system": found.name, "components": list(found.sources), "algorithm": algorithm, "step_s": size, "stop_s": end,
        "ticks": ticks, "finished": flight.finished, "departed_at_s": None if flight.finished else last,
        "real_time_factor": last / flight.wall_s if ticks else 0.0, "out": str(folder),
    }
    write(folder, flight, summary)
    return summary, flight.message
