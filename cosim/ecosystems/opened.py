"""What users of other tools name a system by: data, a file, or a scenario of ours."""
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from numbers import Real
from os import PathLike

from ..errors import UsageError
from ..master.system import System
from ..systems.load import ENDINGS, load_system
from ..systems.system_file import is_system_file
from ..text import in_python

DEFAULT_STEP = 0.01  # s, of a scenario's flight, as that of `ahv run`


@contextmanager
def pythons_words() -> Iterator[None]:
    """Sentences of UsageError that are raised inside name arguments of Python, not options of the command line."""
    try:
        yield
    except UsageError as error:
        raise type(error)(in_python(str(error))) from None


def opened(system: System | str | PathLike[str], stack: ExitStack) -> tuple[System, str]:
    """The system, with the step and the stop that its file suggests, and the algorithm; `stack` keeps its files.

    `system` is a System, the path of an FMU, an SSP or a system file, or what `ahv run` flies: a built-in scenario or a
    scenario file, with the neural law. Raises UsageError, one sentence, for anything else.
    """
    if isinstance(system, System):
        return system, "gauss-seidel"
    if not isinstance(system, str | PathLike):
        raise UsageError(f"system = {system!r} is not allowed: it must be a cosim.System, a file or a scenario.")
    word = str(system)
    ending = f".{word.rpartition('.')[2].lower()}"
    if ending in ENDINGS and (not ending.startswith(".y") or is_system_file(word)):
        found = stack.enter_context(load_system(word))
        return found.system, found.algorithm or "gauss-seidel"
    from ..vehicle import scenarios
    from ..vehicle.closed_loop import closed_loop

    plan = scenarios.load(word)
    return replace(closed_loop(plan).system, step=DEFAULT_STEP, stop=plan.stop), "gauss-seidel"


def needed(name: str, value: float | None, suggested: float | None) -> float:
    """The time (s) that is given, else what the system's file suggests. Raises UsageError if neither is a number."""
    found = suggested if value is None else value
    if found is None:
        raise UsageError(f"{name} is missing: give it in seconds, such as {name}=0.01.")
    if not isinstance(found, Real) or isinstance(found, bool):
        raise UsageError(f"{name} = {found!r} is not allowed: it must be a number of seconds.")
    return float(found)
