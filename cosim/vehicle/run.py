"""One flight of a scenario, from words to a folder of results: what `ahv run` does."""
from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from ..master.aside import Aside, aside
from ..master.flight import Flight
from ..master.folder import flown_into
from ..master.isolated import launch
from ..master.progress import progress_bar
from ..master.recover import asked
from ..master.recover import recover as recover_rows
from ..pictures import PNG, Format
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
    trouble: str = ""   # results that did not find room, in one sentence


def run(scenario: str | Scenario, controller: str = "neural", preset: Mapping[str, str] | str | None = None,
        plant: str = "ideal", flavour: str | None = None, step: float = 0.01, stop: float | None = None,
        algorithm: str = "gauss-seidel", values: Values | None = None, uncertainty: float | None = None,
        decimate: int = 1, stream: bool = False, isolate: bool = False, time_limit: float | None = None,
        plain: bool = False, real_time: float | None = None, out: Path | None = None, progress: bool = False,
        record: Sequence[str] = (), command: str = "", form: Format = PNG,
        live: Callable[[str], None] | None = None) -> Run:
    """Fly `scenario` (a built-in name, a YAML file or a Scenario) and write signals, run.json, figures
    and a page.

    `controller` and `plant` are words of the registry or anybody's FMUs (NAME=FILE.fmu); `preset` is the controller's,
    or component -> name. `values` are set last: component -> variable -> value. `step`, `stop` are in s. The results
    go to `out`, else to results/run/SCENARIO. `record` picks the signals, as patterns of component.variable (none: all
    outputs); metrics and figures whose signals are left out are left out, too. `command` is what the page says that it
    was made by, `form` says how figures are written. Other arguments are those of `master.fly.fly`.

    Raises UsageError for what cannot be flown, RunError if an FMU does not start. A flight that ends early is a
    result: `flight.finished` is False and `flight.message` says why. After a signal there are no figures and
    no CSV, and `flight.interrupted` is its number.
    """
    plan = scenarios.load(scenario) if isinstance(scenario, str) else scenario
    presets = {"controller": preset} if isinstance(preset, str) else dict(preset or {})
    loop = closed_loop(plan, controller, plant, flavour, presets, values, uncertainty)
    end, show = plan.stop if stop is None else stop, None
    if live:
        from .live import shown_live

        real_time = 1.0 if real_time is None else real_time
        show = shown_live(loop, title_of(plan.name, loop.controller, loop.preset), end, real_time, live)
    isolated = isolate or loop.foreign or time_limit is not None or show is not None
    with (aside(isolated, prepare, *WORKS) as drawing,  # first: it must not have the folder's lock
          flown_into(out, "run", plan.name, stream) as (folder, interrupted), show or nullcontext()):
        said = said_of(plan, loop, algorithm, step, end)
        rows = asked(folder, said) if stream else None
        options: dict[str, Any] = {"decimate": decimate, "stream": rows} if rows else {}
        if record:
            options["record"] = list(record)
        if show:
            options |= {"desk": show.desk, "watch": show}
        bar, tell = progress_bar(plan.name, end)
        with bar:
            flight = explained(launch(loop.system, step, end, algorithm, tell if progress else None,
                                      isolated, time_limit, plain=plain, real_time=real_time, meanwhile=import_writers,
                                      **options))
        notes = [*loop.notes, *part_of_the_rows(flight, stream)]
        if show:
            show.ended(flight)
            said["live"] = show.desk.made()
        done = kept(folder, flight, said, notes, decimate, rows, command, drawing, form)
        if show:
            show.written(done.out)
    flight.interrupted = interrupted[0] if interrupted else flight.interrupted
    return done


def recover(left: Path, out: Path | None = None, command: str = "") -> Run:
    """Make results, in `out` or there, of the rows that a killed run with --stream left in the folder `left`.

    Its figures of merit are computed from a part of the rows, as those of every streamed run. Raises what
    `master.recover.recover` raises.
    """
    return recover_rows(left, out, "run", lambda folder, flight, said, rows: kept(
        folder, explained(flight), said, part_of_the_rows(flight, True), rows=rows, command=command))


def kept(folder: Path, flight: Flight, said: dict[str, Any], notes: list[str], decimate: int = 1,
         rows: Path | None = None, command: str = "", drawing: Aside | None = None, form: Format = PNG) -> Run:
    """The flight with its figures of merit, in a claimed folder; `said` is what run.json says of the request, `rows`
    the file of a stream's rows, `command` what the page says."""
    from ..master.results import write

    said = dict(said)
    presets, first_figure = said.pop("presets"), said.pop("first_figure")
    summary = {**said, **shown_by(flight), **({"lateness": flight.lateness} if flight.lateness else {})}
    title = title_of(said["scenario"], said["controller"], said["preset"])
    drawn = (drawing or Aside(WORKS)).start(flight, title, first_figure, summary, command, notes, form)
    published = write(folder, "run", flight, {**summary, "presets": presets}, decimate,
                      [drawn], rows)
    return Run(flight, {**summary, "out": str(published.folder)}, published.folder, notes, published.trouble)


def title_of(scenario: str, controller: str, preset: str | None) -> str:
    """What figures and pages call a flight."""
    return f"{scenario}, {controller}{f' ({preset})' if preset else ''}"


def said_of(plan: Scenario, loop: ClosedLoop, algorithm: str, step: float, stop: float
            ) -> dict[str, Any]:
    """What run.json says of the request, and the number of the first figure."""
    return {"scenario": plan.name, "controller": loop.controller, "preset": loop.preset, "flavour": loop.flavour,
            "algorithm": algorithm, "step_s": step, "stop_s": stop, "presets": presets_of(loop),
            "first_figure": plan.first_figure}


def shown_by(flight: Flight) -> dict[str, Any]:
    """What run.json says of the flight."""
    return {"ticks": flight.ticks, "finished": flight.finished,
            "departed_at_s": None if flight.finished else flight.reached, "ended_at_s": flight.ended_at,
            **metrics(flight), "real_time_factor": flight.reached / flight.wall_s if flight.wall_s else None}


def part_of_the_rows(flight: Flight, stream: bool) -> list[str]:
    """A sentence for whoever reads figures of a streamed flight, of which memory has only a part."""
    if not stream or len(flight.time) > flight.ticks:
        return []
    return [f"metrics and figures are computed from {len(flight.time)} of {flight.ticks + 1} rows: those that --stream "
            f"keeps in memory."]


def presets_of(loop: ClosedLoop) -> dict[str, dict[str, str]]:
    """Whose preset flew, and who said so."""
    return {component: {"name": name, "from": loop.preset_from[component]} for component, name in loop.presets.items()}


def prepare() -> None:
    """Import what `illustrate` needs: matplotlib takes long."""

    from . import figures, look  # noqa: F401


def import_writers() -> None:
    """Import what writes results, while the flight flies in another process."""
    from ..master import results  # noqa: F401


def draw(folder: Path, flight: Flight, title: str, first_figure: int | None, *rest: Any, share: slice = slice(None)
         ) -> None:
    """The scenario's figures, or a share of them, into `folder`; the last argument is their Format. Raises OSError."""
    from .figures import write  # matplotlib is slow to import

    write(folder, flight, title, first_figure, share, rest[-1])


def write_page(folder: Path, flight: Flight, title: str, _: int | None, summary: dict[str, Any], command: str,
               notes: list[str], _form: Format) -> None:
    """The flight's page into `folder`. Raises OSError."""
    from ..pages.write import REPORT, page
    from .look import PANELS, looked_at

    (folder / REPORT).write_text(page(title, [looked_at(summary["scenario"], flight, summary)], PANELS, command, notes),
                                 encoding="utf-8")


WORKS = (partial(draw, share=slice(0, None, 2)), partial(draw, share=slice(1, None, 2)), write_page)
