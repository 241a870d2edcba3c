"""What users say of a system on the command line: values to set, signals to record, and the experiment."""
from collections.abc import Iterable, Mapping
from fnmatch import fnmatchcase
from math import isfinite
from os.path import isfile
from pathlib import Path

from ..errors import UsageError, did_you_mean
from ..master.system import Component, System, Value
from .load import POINTS, Loaded

DEFAULT_STEP = 0.01  # s, as that of `ahv run`


def assigned(words: Iterable[str], found: Loaded) -> System:
    """The system with the values of COMPONENT.VARIABLE=VALUE words; of one FMU, VARIABLE=VALUE will do.

    Raises UsageError for a word of another form or an unknown component.
    """
    values: dict[str, Value] = {}
    known = [c.name for c in found.system.components]
    for word in words:
        target, equals, value = word.partition("=")
        component, dot, variable = target.partition(".")
        if found.alone and (target in found.variables or component != found.alone):
            component, dot, variable = found.alone, ".", target
        if not (equals and dot and variable):
            form = "VARIABLE=VALUE" if found.alone else "COMPONENT.VARIABLE=VALUE"
            raise UsageError(f"--set {word} is not of the form {form}.")
        if component not in known:
            raise UsageError(f"--set {component}: there is no such component{did_you_mean(component, known)}")
        values[f"{component}.{variable}"] = value
    return found.system.with_values(values)


def files(words: Iterable[str]) -> dict[str, Path]:
    """COMPONENT=FILE.fmu words. Raises UsageError for one of another form."""
    found = {}
    for word in words:
        component, _, file = word.partition("=")
        if not (component and file):
            raise UsageError(f"--fmu {word} is not of the form COMPONENT=FILE.fmu.")
        found[component] = Path(file)
    return found


def with_fmus(system: System, fmus: Mapping[str, Path]) -> System:
    """`system` with other FMUs for some components. Raises UsageError for a component or a file that is not there."""
    known = [c.name for c in system.components]
    for component, file in fmus.items():
        if component not in known:
            raise UsageError(f"There is no component {component}{did_you_mean(component, known)}")
        if not isfile(file):
            raise UsageError(f"There is no file {file}.")
    return System([Component(c.name, fmus.get(c.name, c.fmu), c.values) for c in system.components],
                  system.connections, system.step, system.stop, system.start)


def patterns(words: Iterable[str], found: Loaded) -> list[str]:
    """Patterns of component.variable; of one FMU, those of its variables will do."""
    if not found.alone:
        return list(words)
    full = [f"{found.alone}.{name}" for name in found.variables]
    return [word if any(fnmatchcase(name, word) for name in full) or word in full else f"{found.alone}.{word}"
            for word in words]


def experiment(found: Loaded, start: float | None, stop: float | None, step: float | None
               ) -> tuple[float, float, float, list[str]]:
    """(start, stop, step) in s: what the user says, else what the file does; and what should be known of them.

    Raises UsageError if nobody says when to stop.
    """
    remarks, system, path = [], found.system, found.path
    begin = system.start if start is None else start
    end = system.stop if stop is None else stop
    if end is None:
        raise UsageError(f"{path} does not say when to stop: give --stop.")
    size = system.step if step is None else step
    if size is None:
        size = DEFAULT_STEP if not found.alone or not isfinite(end - begin) or end <= begin else (end - begin) / POINTS
        remarks.append(f"{path} does not say how large the step is: {size:.6g} s is taken.")
    if stop is None and found.alone and size > 0 and end > begin and isfinite((end - begin) / size):
        count = max(1, round((end - begin) / size))
        if abs(begin + count * size - end) > 1e-6 * size:
            remarks.append(f"{path} suggests a stop at {end:g} s, which is not a whole number of steps of {size:g} s: "
                           f"{begin + count * size:.6g} s is taken.")
            end = begin + count * size
    return begin, end, size, remarks
