"""What `import cosim` offers beside the data: fly a system, fit its parameters, check an FMU."""
from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from math import isfinite
from numbers import Real
from os import PathLike
from os.path import isfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .errors import UsageError
from .master.system import System, Value, as_path
from .text import in_python

if TYPE_CHECKING:
    from .conformance.report import Report
    from .fitting.fit import Fit
    from .master.flight import Flight
    from .master.progress import Progress


def fly(system: System, step: float | None = None, stop: float | None = None, *, start: float | None = None,
        tolerance: float | None = None, algorithm: str = "gauss-seidel",
        record: Sequence[str] | None = None, decimate: int = 1, progress: "bool | Progress" = True,
        isolate: bool = False, time_limit: float | None = None, real_time: float | None = None,
        stream: str | PathLike[str] | None = None, save: str | PathLike[str] | None = None,
        restore: str | PathLike[str] | None = None, plain: bool = False,
        inputs: str | PathLike[str] | None = None) -> "Flight":
    """Fly `system` from `start` to `stop` (s) in communication steps of `step` (s); by default what its file suggests.

    tolerance   the relative one that the FMUs are asked to keep; None for what each declares in its default experiment
    algorithm   gauss-seidel, jacobi, multi-rate, iterated or variable, with options such as
                "multi-rate,controller=5,hold=linear"
    record      patterns of component.variable, with * for any: the signals to keep; None for all numeric outputs
    decimate    keep every n-th step
    progress    a bar in a terminal or notebook (True), nothing (False), or a function that is told the time (s)
    isolate     fly in a process of its own, so that an FMU that crashes ends the flight and not the program
    time_limit  longest time (s) of one FMU call; isolates
    real_time   pace the flight, this many simulated seconds a second
    stream      write all signals to this Parquet file, or Arrow stream (.arrows), as it flies; the result keeps a part
                of the rows
    save        write the state of the flight at its stop to this file; all FMUs must be able to write down theirs
    restore     go on from a state that was saved in this file, with its values and in its steps
    plain       tick in plain Python, not in compiled code
    inputs      a CSV or Parquet file of inputs over time: a column `time` (s), and one for each input

    Returns a Flight: `flight["component.variable"]` has shape (rows,) and the unit that the FMU declares,
    `flight.time` has shape (rows,), s. An FMU that refuses a step, and Ctrl-C, end the flight early: what was flown is
    in the result, `finished` is False and `message` says why.

    Raises UsageError before anything flies if the system or an argument does not fit, and RunError if the FMUs
    cannot be started.
    """
    from .master.state import read_state

    demand(isinstance(system, System), "system", system, "a cosim.System")
    step = given("step", step, system.step)
    stop = given("stop", stop, system.stop, signed=True)
    demand(start is None or restore is None, "start", start, "left out with restore, which says where it goes on")
    state = None if restore is None else read_state(as_path(restore))
    start = given("start", start, state.time if state else system.start, signed=True)
    demand(stop > start, "stop", stop, f"a number of seconds after the start at {start:g} s")
    for name, value in (("tolerance", tolerance), ("time_limit", time_limit), ("real_time", real_time)):
        if value is not None:
            positive(name, value)
    demand(isinstance(decimate, int) and decimate is not True and decimate > 0, "decimate", decimate, "1, 2, 3 ...")
    demand(isinstance(algorithm, str), "algorithm", algorithm, "a text such as 'jacobi'")
    demand(record is None or is_texts(record), "record", record, "a list of texts such as ['plant.*']")
    demand(isinstance(progress, bool) or callable(progress), "progress", progress, "True, False or a function")
    file = None if stream is None else as_path(stream)
    demand(file is None or file.parent.is_dir(), "stream", str(file), "a file in a folder that exists")
    if not system.components:
        raise UsageError("The system has no components.")

    from .master.isolated import launch
    from .master.progress import progress_bar
    from .master.table import read_table

    title = ", ".join(component.name for component in system.components)
    bar, tell = progress_bar(title, stop) if progress is True else (None, progress or None)
    options: dict[str, Any] = {"start": start, "tolerance": tolerance,
                               "record": None if record is None else list(record), "decimate": decimate,
                               "real_time": real_time, "plain": plain, "stream": file,
                               "save": None if save is None else as_path(save).absolute(), "restore": state,
                               "inputs": None if inputs is None else read_table(inputs)}
    try:
        with bar or nullcontext():
            return launch(system, step, stop, algorithm, tell, isolate, time_limit, **options)
    except UsageError as error:
        raise type(error)(in_python(str(error))) from None


def fit(system: System, data: "Sequence[str | PathLike[str]] | Mapping[str | PathLike[str], Mapping[str, Value]]",
        parameters: Sequence[str], *, signals: "Sequence[str] | Mapping[str, float]" = (), step: float | None = None,
        start: float | None = None, algorithm: str = "gauss-seidel", tolerance: float | None = None, starts: int = 1,
        seed: int = 1, workers: int = 0, time_limit: float | None = None, progress: bool = True) -> "Fit":
    """Find parameters with which `system` shows what was measured; docs/fitting.md says how.

    data        CSV or Parquet files, a flight each: a column `time` (s), and columns called component.variable; those
                that are inputs drive the system, the others are compared. A dict gives each file's own start values,
                {"low.csv": {"plant.h_start": 80000.0}}
    parameters  "plant.mass", or "plant.mass=300", "plant.mass=280:400", "plant.mass=300:280:400" with a start and
                bounds; "low.csv:plant.theta_start" for one flight only
    signals     the signals to compare, or a dict with their noise levels; without it all columns that are signals
    step, start, algorithm, tolerance  as for `fly`; each flight ends with its table
    starts      how many points the search begins at; `seed` is that of their draw
    workers     processes that fly; 0: this process, which an FMU that crashes ends
    time_limit  longest wall time (s) of a flight; one that takes longer counts as lost; needs workers
    progress    whether lines about the search go to stderr

    Returns a Fit: `values` and `intervals_95` by parameter, the `systems` to fly with these values, a flight each, and
    `summary`, which has what makes the intervals untrustworthy under "warnings".

    Raises UsageError, one sentence, for what does not fit, RunError if no flight begins with the start values.
    """
    demand(isinstance(system, System), "system", system, "a cosim.System")
    demand(not isinstance(data, str | PathLike), "data", data, "a list of files, or a dict of them")
    demand(is_texts(parameters), "parameters", parameters, "a list of texts such as ['plant.mass']")
    demand(not isinstance(signals, str), "signals", signals, "a list of texts, or a dict with noise levels")
    demand(isinstance(workers, int) and workers >= 0, "workers", workers, "0, 1, 2 ...")
    demand(time_limit is None or workers > 0, "time_limit", time_limit, "left out without workers")
    step = given("step", step, system.step)
    from .fitting.fit import Subject
    from .fitting.fit import fit as search
    from .master.notes import note
    from .systems.load import Loaded
    from .systems.words import assigned

    found = Loaded(Path("the system"), "system", system, {})
    own = [f"{file}:{name}={value}" for file, values in data.items()
           for name, value in values.items()] if isinstance(data, Mapping) else []
    words = [f"{name}:{level!r}" for name, level in signals.items()] if isinstance(signals, Mapping) else signals
    try:
        return search(Subject(found, lambda values: assigned(values, found)), [str(as_path(file)) for file in data],
                      parameters, words, own, start=start, step=step, algorithm=algorithm, tolerance=tolerance,
                      begin_at=starts, seed=seed, workers=workers, time_limit=time_limit,
                      tell=note if progress else lambda line: None)
    except UsageError as error:
        raise type(error)(in_python(str(error))) from None


def check(path: str | PathLike[str], dynamic: bool = True, time_limit: float = 30.0, cycles: int = 1000) -> "Report":
    """Check one FMU against FMI 2.0 or 3.0, its file and what it does when it runs: a Report with `.passed` and
    `.findings`.

    `dynamic` also runs the FMU, in child processes; `time_limit` is how long (s) one call of it may take; `cycles` how
    many lives of an instance the search for memory leaks takes.
    Raises UsageError if there is no such file.
    """
    file = as_path(path)
    if not isfile(file):
        raise UsageError(f"There is no file {file}.")
    positive("time_limit", time_limit)
    from .conformance import check as examine

    return examine(file, dynamic, time_limit, cycles)


def given(name: str, value: float | None, suggested: float | None, signed: bool = False) -> float:
    """The value of an argument, else what the system's file suggests.

    Raises UsageError if neither is a time; one that is `signed` may be 0 or below.
    """
    if value is None:
        value = suggested
    if value is None:
        raise UsageError(f"{name} is missing: give it in seconds, such as {name}=0.01.")
    if not signed:
        return positive(name, value)
    is_number = isinstance(value, Real) and not isinstance(value, bool)
    demand(is_number and isfinite(value), name, value, "a number of seconds")
    return value


def positive(name: str, value: object) -> float:
    """`value` as a number. Raises UsageError unless it is finite and above 0."""
    is_number = isinstance(value, Real) and not isinstance(value, bool)
    demand(is_number and 0 < float(value) < float("inf"), name, value, "a number above 0")  # type: ignore[arg-type]
    return float(value)  # type: ignore[arg-type]


def is_texts(value: object) -> bool:
    """Whether `value` is a list of texts."""
    return isinstance(value, Sequence) and not isinstance(value, str) and all(isinstance(x, str) for x in value)


def demand(holds: bool, name: str, value: object, wanted: str) -> None:
    """Raises UsageError, one sentence about an argument, unless it `holds`."""
    if not holds:
        raise UsageError(f"{name} = {value!r} is not allowed: it must be {wanted}.")
