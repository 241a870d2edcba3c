"""`ahv simulate`: an SSP file flown by the master, results as `ahv run` writes them."""
from pathlib import Path
from typing import Any

from ..errors import UsageError
from ..master.isolated import fly_isolated
from ..master.notes import note
from ..master.progress import progress_bar
from ..master.results import prepare_folder, write
from .load import load_ssp

DEFAULT_STEP = 0.01  # s, as that of `ahv run`


def simulate(path: Path, step: float | None, stop: float | None, algorithm: str,
             out: Path | None) -> tuple[dict[str, Any], str]:
    """Fly the system in `path`; the summary, and why it ended before its stop (empty if it did not).

    Raises UsageError for a file or numbers that do not fit, RunError if the FMUs cannot be started.
    """
    with load_ssp(path) as found:
        end = found.stop if stop is None else stop
        size = (found.step or DEFAULT_STEP) if step is None else step
        if end is None:
            raise UsageError(f"{path} does not say when to stop: give --stop.")
        if step is None and found.step is None:
            note(f"{path} does not say how large the step is: {DEFAULT_STEP} s is taken.")
        for name in found.ignored:
            note(f"the parameter {name} fits no variable and is ignored.")
        folder = out or Path("results") / path.stem
        prepare_folder(folder)
        bar, progress = progress_bar(found.name, end)
        with bar:
            flight = fly_isolated(found, size, end, algorithm, progress)  # FMUs of unknown origin may crash
    for component, fmu in flight.fmus.items():
        fmu["file"] = f"{path}/{found.sources[component]}"
    summary = {
        "system": found.name, "components": list(found.sources), "algorithm": algorithm, "step_s": size, "stop_s": end,
        "ticks": flight.ticks, "finished": flight.finished,
        "departed_at_s": None if flight.finished else flight.reached, "ended_at_s": flight.ended_at,
        "real_time_factor": flight.reached / flight.wall_s if flight.ticks else 0.0, "out": str(folder),
    }
    write(folder, flight, summary)
    for warning in flight.warnings:
        note(warning)
    return summary, flight.message
