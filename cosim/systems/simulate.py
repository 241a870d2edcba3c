"""`ahv simulate`: any system flown by the master, results as `ahv run` writes them."""
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

from ..errors import UsageError
from ..master.flight import Flight
from ..master.fly import tick_count
from ..master.folder import flown_into
from ..master.isolated import fly_isolated
from ..master.notes import note
from ..master.progress import progress_bar
from ..master.recover import asked
from ..master.recover import recover as recover_rows
from ..master.results import write
from ..master.state import State, read_state
from ..master.table import read_table
from ..names import safe
from ..pictures import PNG, Format
from .load import load_system
from .words import assigned, experiment, files, patterns, with_fmus

ALGORITHM = "gauss-seidel"


def simulate(path: Path, step: float | None, stop: float | None, algorithm: str | None, out: Path | None,
             time_limit: float | None = None, stream: bool = False, *, start: float | None = None,
             tolerance: float | None = None, values: Sequence[str] = (), inputs: Path | None = None,
             record: Sequence[str] | None = None, decimate: int = 1, plot: bool = False, save: Path | None = None,
             restore: Path | None = None, fmus: Sequence[str] = (), command: str = "", form: Format = PNG
             ) -> tuple[dict[str, Any], Flight, str]:
    """Fly the system in `path`, see `load_system`; the summary, the flight, and which results did not find room (empty
    if all did). They go to `out`, else to results/simulate/FILE.

    What is None is what the file suggests. Times are in s. `values` are COMPONENT.VARIABLE=VALUE words, `record`
    patterns of COMPONENT.VARIABLE; of one FMU, its variables will do in both. `inputs` is a table of inputs over time,
    `plot` draws what is recorded, as `form` says. `fmus` are COMPONENT=FILE.fmu words, other FMUs for these places.
    `save` is a file for the state at the end, `restore` such a file to go on from. An FMU call that takes longer than
    `time_limit` ends the flight; `stream` writes rows to the disk as it flies. `command` is what the page says that it
    was made by.

    Raises UsageError for a file or numbers that do not fit, RunError if the FMUs cannot be started.
    """
    state = state_of(restore, start, values) if restore else None
    with load_system(path) as found:
        if state:
            start, step = state.start, state.step if step is None else step
        others = files(fmus)
        sources = {**found.sources, **{component: str(file) for component, file in others.items()}}
        begin, end, size, remarks = experiment(found, start, stop, step)
        tick_count(size, end, begin)
        word = algorithm or (state.algorithm if state else found.algorithm) or ALGORITHM
        options: dict[str, Any] = {
            "start": begin, "tolerance": found.tolerance if tolerance is None else tolerance, "decimate": decimate,
            "record": patterns(record, found) if record else None, "save": save and savable(save), "restore": state,
            "inputs": read_table(inputs) if inputs else None}
        system = with_fmus(assigned(values, found), others)
        for remark in (*remarks, *found.remarks):
            note(remark)
        said = {"system": found.name, "components": list(sources), "algorithm": word, "step_s": size,
                "stop_s": end, "start_s": state.time if state else begin}
        with flown_into(out, "simulate", safe(path.stem), stream) as (folder, interrupted):
            rows = asked(folder, {**said, "files": sources}) if stream else None
            bar, progress = progress_bar(found.name, end)
            with bar:  # FMUs of unknown origin may crash
                flight = fly_isolated(system, size, end, word, progress, time_limit, rows, **options)
            summary, trouble = kept(folder, flight, said, sources, rows, plot, command, form)
    flight.interrupted = interrupted[0] if interrupted else flight.interrupted
    for warning in flight.warnings:
        note(warning)
    return summary, flight, trouble


def state_of(restore: Path, start: float | None, values: Sequence[str]) -> State:
    """The state to go on from. Raises UsageError for options that have no meaning beside it."""
    if start is not None:
        raise UsageError(f"--start and --restore exclude each other: {restore} says where the flight goes on.")
    if values:
        raise UsageError(f"--set and --restore exclude each other: {restore} has the values of all variables.")
    return read_state(restore)


def savable(path: Path) -> Path:
    """`path`, absolute. Raises UsageError if no file can be written there."""
    path = path.absolute()
    if path.is_dir() or not path.parent.is_dir():
        raise UsageError(f"--save {path} is not a file in a folder that exists.")
    return path


def kept(folder: Path, flight: Flight, said: dict[str, Any], files: dict[str, str], rows: Path | None,
         plot: bool = False, command: str = "", form: Format = PNG) -> tuple[dict[str, Any], str]:
    """The summary of a flight whose results are written to a claimed folder, and which of them did not find room.

    `said` is what run.json says of the request, `files` each component's FMU, `rows` the file of a stream's rows.
    """
    for component, fmu in flight.fmus.items():
        fmu["file"] = files[component]
    flown = flight.reached - said.get("start_s", 0.0)
    summary = {**said, "ticks": flight.ticks, "finished": flight.finished,
               "departed_at_s": None if flight.finished else flight.reached, "ended_at_s": flight.ended_at,
               "real_time_factor": flown / flight.wall_s if flight.wall_s else None}
    published = write(folder, "simulate", flight, summary, extras=[
        *([partial(draw, flight, form)] if plot else []), partial(write_page, flight, summary, command)], rows=rows)
    return {**summary, "out": str(published.folder)}, published.trouble


def draw(flight: Flight, form: Format, folder: Path) -> None:
    """Pictures of all that is recorded into `folder`."""
    from ..master.plot import draw_all  # matplotlib is slow to import

    draw_all(flight, folder / "figures", form)


def write_page(flight: Flight, summary: dict[str, Any], command: str, folder: Path) -> None:
    """The flight's page into `folder`. Raises OSError."""
    from ..pages.flown import Flown
    from ..pages.write import REPORT, page

    name = str(summary["system"])
    (folder / REPORT).write_text(page(name, [Flown(name, flight, summary)], command=command), encoding="utf-8")


def recover(left: Path, out: Path | None = None, command: str = "") -> tuple[dict[str, Any], Flight, str]:
    """Make results, in `out` or there, of the rows that a killed simulation with --stream left in the folder `left`;
    what `simulate` returns. Raises what `master.recover.recover` raises."""
    def keep(folder: Path, flight: Flight, said: dict[str, Any], rows: Path) -> tuple[dict[str, Any], Flight, str]:
        files = said.pop("files")
        summary, trouble = kept(folder, flight, said, files, rows, command=command)
        return summary, flight, trouble

    return recover_rows(left, out, "simulate", keep)
