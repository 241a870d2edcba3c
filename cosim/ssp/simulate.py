"""`ahv simulate`: an SSP file flown by the master, results as `ahv run` writes them."""
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Any

from ..errors import UsageError
from ..master.flight import Flight, tick_count
from ..master.folder import claimed
from ..master.interruptions import interruptions
from ..master.isolated import fly_isolated
from ..master.notes import note
from ..master.progress import progress_bar
from ..master.recover import asked
from ..master.recover import recover as recover_rows
from ..master.results import write
from ..names import safe
from .load import load_ssp

DEFAULT_STEP = 0.01  # s, as that of `ahv run`


def simulate(path: Path, step: float | None, stop: float | None, algorithm: str, out: Path | None,
             time_limit: float | None = None, stream: bool = False) -> tuple[dict[str, Any], Flight, str]:
    """Fly the system in `path`; the summary, the flight, and which results did not find room (empty if all did). They
    go to `out`, else to results/simulate/FILE. An FMU call that takes longer than `time_limit` (s) ends the flight;
    `stream` writes rows to the disk as it flies.

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
        tick_count(size, end, found.start)
        said = {"system": found.name, "components": list(found.sources), "algorithm": algorithm, "step_s": size,
                "stop_s": end}
        files = {component: f"{path}/{source}" for component, source in found.sources.items()}
        # A signal lets the writing end; rows of a stream are on the disk already.
        holding: AbstractContextManager[list[int]] = nullcontext([]) if stream else interruptions()
        with (claimed(out, "simulate", safe(path.stem)) as folder,
              holding as interrupted):
            rows = asked(folder, {**said, "files": files}) if stream else None
            bar, progress = progress_bar(found.name, end)
            with bar:  # FMUs of unknown origin may crash
                flight = fly_isolated(found, size, end, algorithm, progress, time_limit, rows)
            summary, trouble = kept(folder, flight, said, files, rows)
    flight.interrupted = interrupted[0] if interrupted else flight.interrupted
    for warning in flight.warnings:
        note(warning)
    return summary, flight, trouble


def kept(folder: Path, flight: Flight, said: dict[str, Any], files: dict[str, str], rows: Path | None
         ) -> tuple[dict[str, Any], str]:
    """The summary of a flight whose results are written to a claimed folder, and which of them did not find room.

    `said` is what run.json says of the request, `files` each component's FMU, `rows` the file of a stream's rows.
    """
    for component, fmu in flight.fmus.items():
        fmu["file"] = files[component]
    summary = {**said, "ticks": flight.ticks, "finished": flight.finished,
               "departed_at_s": None if flight.finished else flight.reached, "ended_at_s": flight.ended_at,
               "real_time_factor": flight.reached / flight.wall_s if flight.wall_s else None}
    published = write(folder, "simulate", flight, summary, rows=rows)
    return {**summary, "out": str(published.folder)}, published.trouble


def recover(left: Path, out: Path | None = None) -> tuple[dict[str, Any], Flight, str]:
    """Make results, in `out` or there, of the rows that a killed simulation with --stream left in the folder `left`;
    what `simulate` returns. Raises what `master.recover.recover` raises."""
    def keep(folder: Path, flight: Flight, said: dict[str, Any], rows: Path) -> tuple[dict[str, Any], Flight, str]:
        files = said.pop("files")
        summary, trouble = kept(folder, flight, said, files, rows)
        return summary, flight, trouble

    return recover_rows(left, out, "simulate", keep)
