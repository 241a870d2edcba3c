"""The folder of a fit: fit.json, fit.parquet, pictures, the inputs of flights that have some, and commands that fly the
fitted system."""
import shlex
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.csv

from ..master.folder import claimed
from ..master.publish import publish
from ..master.results import write_parquet
from ..master.table import TIME
from ..pictures import PNG, Format
from .fit import Fit, Subject, fit


def fit_into(out: Path | None, subject: Subject, data: Sequence[str], parameters: Sequence[str], *words: Sequence[str],
             form: Format = PNG, **options: Any) -> tuple[Fit, dict[str, Any], str]:
    """What `fit.fit` finds, its summary as fit.json has it, and which results did not find room (empty if all did).
    They go to `out`, else to results/fit/SYSTEM, with pictures as `form` says. Raises what `fit` raises."""
    with claimed(out, "fit", subject.found.name) as folder:
        done = fit(subject, data, parameters, *words, **options)
        for k, flight in enumerate(done.summary["flights"]):
            flight["command"] = command(subject, done, k, folder)
        published = publish(folder, "fit", done.summary, partial(write, done), [partial(draw, done, form)])
    return done, {**done.summary, "out": str(published.folder)}, published.trouble


def command(subject: Subject, done: Fit, place: int, folder: Path) -> str | None:
    """The command that flies the flight at `place` with the fitted values; None if there is none."""
    said, flight = done.summary, done.summary["flights"][place]
    if not subject.command or (flight["inputs"] and not subject.feeds):
        return None
    words = [*subject.command, "--step", repr(said["step_s"]), "--stop", repr(flight["stop_s"]), "--algorithm",
             said["algorithm"]]
    if said["start_s"] != subject.found.system.start:
        words += ["--start", repr(said["start_s"])]
    if said["tolerance"] not in (None, subject.found.tolerance):
        words += ["--tolerance", repr(said["tolerance"])]
    fitted = [f"{p.target}={done.values[p.name]!r}" for p in done.request.parameters if p.flight in (None, place)]
    for word in (*flight["set"], *fitted):
        words += ["--set", word]
    return shlex.join([*words, *(["--input", str(folder / inputs_file(place))] if flight["inputs"] else [])])


def inputs_file(place: int) -> str:
    """The file with the inputs of the flight at `place`."""
    return f"inputs_{place + 1}.csv"


def write(done: Fit, folder: Path) -> None:
    """All rows, and the inputs of flights that have some. Raises OSError."""
    write_parquet(done.table, folder / "fit.parquet")
    for place, one in enumerate(done.request.measured):
        if one.inputs:
            columns = pa.table({TIME: one.inputs.times, **one.inputs.values})
            pyarrow.csv.write_csv(columns, (folder / inputs_file(place)).absolute())


def draw(done: Fit, form: Format, folder: Path) -> None:
    """The pictures. Raises OSError."""
    from .picture import Course, Panel  # matplotlib is slow to import
    from .picture import draw as draw_panels

    names, rows, panels = [one.file for one in done.request.measured], done.request.rows, []
    time, after = (np.asarray(done.table[column]) for column in ("time", "after"))
    for s, about in enumerate(done.request.signals.values()):
        here = [(k, (rows.signal == s) & (rows.flight == k)) for k in range(len(names))]
        courses = [Course(k, time[mask], rows.values[mask], after[mask]) for k, mask in here if mask.any()]
        unit = about.display_unit or about.unit
        panels.append(Panel(about.name, "" if unit == "1" else unit, about.display_factor, about.display_offset,
                            done.summary["signals"][about.name]["noise"], courses))
    found = ", ".join(f"{p.name} = {done.values[p.name]:.5g}{spread(done, p.name)} {p.unit}".rstrip()
                      for p in done.request.parameters[:3])
    more = f" and {len(done.request.parameters) - 3} more" if len(done.request.parameters) > 3 else ""
    draw_panels(folder, panels, names, f"{found}{more}", form)


def spread(done: Fit, name: str) -> str:
    """The half-width of a parameter's interval as a title has it."""
    interval = done.intervals_95[name]
    return f" ± {(interval[1] - interval[0]) / 2:.2g}" if interval else ""
