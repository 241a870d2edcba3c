"""What `import cosim` offers beside the data: fly a system, check an FMU."""
import re
from collections.abc import Sequence
from contextlib import nullcontext
from numbers import Real
from os import PathLike
from typing import TYPE_CHECKING, Any

from .errors import UsageError
from .master.system import System, as_path

if TYPE_CHECKING:
    from .conformance.report import Report
    from .master.flight import Flight
    from .master.progress import Progress


def fly(system: System, step: float | None = None, stop: float | None = None, *, algorithm: str = "gauss-seidel",
        record: Sequence[str] | None = None, decimate: int = 1, progress: "bool | Progress" = True,
        isolate: bool = False, time_limit: float | None = None, real_time: float | None = None,
        stream: str | PathLike[str] | None = None, plain: bool = False) -> "Flight":
    """Fly `system` from 0 to `stop` (s) in communication steps of `step` (s); by default what its file suggests.

    algorithm   gauss-seidel, jacobi, multi-rate, iterated or variable, with options such as
                "multi-rate,controller=5,hold=linear"
    record      patterns of component.variable, with * for any: the signals to keep; None for all numeric outputs
    decimate    keep every n-th step
    progress    a bar in a terminal or notebook (True), nothing (False), or a function that is told the time (s)
    isolate     fly in a process of its own, so that an FMU that crashes ends the flight and not the program
    time_limit  longest time (s) of one FMU call; isolates
    real_time   pace the flight, this many simulated seconds a second
    stream      write all signals to this Parquet file as it flies; the result keeps a part of the rows
    plain       tick in plain Python, not in compiled code

    Returns a Flight: `flight["component.variable"]` has shape (rows,) and the unit that the FMU declares,
    `flight.time` has shape (rows,), s. An FMU that refuses a step, and Ctrl-C, end the flight early: what was flown is
    in the result, `finished` is False and `message` says why.

    Raises UsageError before anything flies if the system or an argument does not fit, and RunError if the FMUs
    cannot be started.
    """
    if not isinstance(system, System):
        raise UsageError(f"system = {system!r} is not allowed: it must be a cosim.System.")
    step, stop = (given(name, value, getattr(system, name)) for name, value in (("step", step), ("stop", stop)))
    for name, value in (("time_limit", time_limit), ("real_time", real_time)):
        if value is not None:
            positive(name, value)
    if isinstance(decimate, bool) or not isinstance(decimate, int) or decimate < 1:
        raise UsageError(f"decimate = {decimate!r} is not allowed: it must be a whole number from 1 on.")
    if not isinstance(algorithm, str):
        raise UsageError(f"algorithm = {algorithm!r} is not allowed: it must be a text such as 'jacobi'.")
    if isinstance(record, str) or not all(isinstance(pattern, str) for pattern in record or ()):
        raise UsageError(f"record = {record!r} is not allowed: it must be a list of texts such as ['plant.*'].")
    if not isinstance(progress, bool) and not callable(progress):
        raise UsageError(f"progress = {progress!r} is not allowed: it must be True, False or a function of the time.")
    if not system.components:
        raise UsageError("The system has no components.")
    if system.start != 0:
        raise UsageError(f"The system starts at t = {system.start:g} s; a start other than 0 is not supported.")

    if stream is not None and not as_path(stream).parent.is_dir():
        raise UsageError(f"stream = {str(stream)!r} cannot be written: there is no such folder.")

    from .master.isolated import launch
    from .master.progress import progress_bar

    title = ", ".join(component.name for component in system.components)
    bar, tell = progress_bar(title, stop) if progress is True else (None, progress or None)
    options: dict[str, Any] = {"record": None if record is None else list(record), "decimate": decimate,
                               "real_time": real_time, "plain": plain,
                               "stream": None if stream is None else as_path(stream)}
    try:
        with bar or nullcontext():
            return launch(system, step, stop, algorithm, tell, isolate, time_limit, **options)
    except UsageError as error:
        raise type(error)(in_python(str(error))) from None


def check(path: str | PathLike[str], dynamic: bool = True, time_limit: float = 30.0, cycles: int = 1000) -> "Report":
    """Check one FMU against FMI 2.0, its file and what it does when it runs: a Report with `.passed`, `.findings`.

    `dynamic` also runs the FMU, in child processes; `time_limit` is how long (s) one call of it may take; `cycles` how
    many lives of an instance the search for memory leaks takes.
    Raises UsageError if there is no such file.
    """
    file = as_path(path)
    if not file.is_file():
        raise UsageError(f"There is no file {file}.")
    positive("time_limit", time_limit)
    from .conformance import check as examine

    return examine(file, dynamic, time_limit, cycles)


def given(name: str, value: float | None, suggested: float | None) -> float:
    """The value of an argument, else what the system's file suggests. Raises UsageError if neither is a time."""
    if value is None:
        value = suggested
    if value is None:
        raise UsageError(f"{name} is missing: give it in seconds, such as {name}=0.01.")
    return positive(name, value)


def positive(name: str, value: object) -> float:
    """Raises UsageError unless `value` is a finite number above 0."""
    if isinstance(value, bool) or not isinstance(value, Real) or not 0 < float(value) < float("inf"):
        raise UsageError(f"{name} = {value!r} is not allowed: it must be a number above 0.")
    return float(value)


def in_python(sentence: str) -> str:
    """The master's sentences name the options of the command line: `--time-limit` is `time_limit` here."""
    return re.sub(r"--([a-z][a-z-]*)", lambda option: option[1].replace("-", "_"), sentence)
