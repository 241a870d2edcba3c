"""Rewards, conditions and figures: functions of the user's, or expressions as `master.measures` reads them."""
from collections.abc import Callable, Collection, Mapping
from typing import Any

from ..errors import RunError, UsageError
from ..master.evaluate import NUMBER, TRUTH
from ..master.flight import Flight
from ..master.fmu import FmuFile
from ..master.measures import Expression, check, parse
from .moment import Moment
from .ports import variable


def expression(word: str, given: object) -> Expression | None:
    """The expression `given`, or None if it is a function or nothing. Raises UsageError, calling it `word`, for what
    cannot be read, and for anything else."""
    if given is None or callable(given):
        return None
    if not isinstance(given, str):
        raise UsageError(f"{word} = {given!r} is not allowed: it must be a function or an expression.")
    try:
        return parse(given)
    except ValueError as error:
        raise UsageError(f"{word}: {error}.") from None


def of_moment(word: str, given: Any, truth: bool, files: Mapping[str, FmuFile]
              ) -> tuple[Callable[[Moment], Any] | None, list[str]]:
    """A function of a Moment from one, from an expression on the signals of one time, or None; and the signals that it
    names. The function raises RunError where an expression has no value. Raises UsageError for an expression that does
    not fit, or is no number, or no `truth`."""
    found = expression(word, given)
    if found is None:
        return given, []
    for name in found.names:
        variable(word, name, files)
    checked(word, found, (), found.names, TRUTH if truth else NUMBER)

    def judge(now: Moment) -> float | bool:
        try:
            return found.value(no_course, now)  # type: ignore[arg-type]
        except ValueError as error:
            raise RunError(f"{word}: {error} at t = {now.time:.6g} s.") from None
    return judge, list(found.names)


def of_flight(word: str, given: Any, signals: Collection[str]) -> Callable[[Flight], float]:
    """A function of a Flight from one, or from an expression on `signals`, which raises ValueError where that has no
    value. Raises UsageError for an expression that does not fit or is no number."""
    found = expression(word, given)
    if given is None:
        raise UsageError(f"{word} is missing: give a function or an expression.")
    if found is None:
        function: Callable[[Flight], float] = given
        return function
    checked(word, found, signals, (), NUMBER)
    return lambda flight: float(found.value(flight.course, {}))


def checked(word: str, found: Expression, signals: Collection[str], numbers: Collection[str], wanted: str) -> None:
    """Raises UsageError, calling it `word`, for an expression that does not fit."""
    try:
        check(found, signals, numbers, wanted)
    except ValueError as error:
        raise UsageError(f"{word}: {error}.") from None


def no_course(name: str) -> Any:
    """Signals of one time have no course: all that is named is a number."""
    raise KeyError(name)
