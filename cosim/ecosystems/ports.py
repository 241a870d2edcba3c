"""The inputs that an agent acts on and the signals that it observes, with their limits."""
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from math import isnan
from numbers import Real
from typing import Any

import numpy as np

from ..errors import UsageError, did_you_mean
from ..master.declared import NUMERIC, Variable
from ..master.fmu import FmuFile
from ..master.system import System, Value

FAR = 1000.0  # nominal values from 0: the limit of an observation for which the FMU declares none
Limits = tuple[float, float]
Ports = Iterable[str] | Mapping[str, Limits | None]
Draw = Value | tuple[float, float] | Callable[[np.random.Generator], Value]


@dataclass(frozen=True)
class Port:
    """An input or a signal, `component.variable`; `low` and `high` are its limits, in `unit`. What is not a real number
    is `whole`."""
    name: str
    unit: str
    low: float
    high: float
    whole: bool

    def __str__(self) -> str:
        return f"{self.name}: {self.low:g} to {self.high:g}{f' {self.unit}' if self.unit not in ('', '1') else ''}"


def actions_of(given: Ports, files: Mapping[str, FmuFile],
            start: Mapping[str, float]) -> list[Port]:
    """The inputs called `given`. Where neither the user nor the FMU says a limit, it is one nominal value from the
    `start` value (by name); a truth value is 0 or 1.

    Raises UsageError for what is no input that takes numbers, and for limits that are none.
    """
    found = []
    for name, limits in pairs("actions", given):
        v = variable("actions", name, files, ("input",))
        reach, file, (component, _, inner) = abs(v.nominal or 1.0), files[name.partition(".")[0]], name.partition(".")
        whole = v.family != "Real"
        low, high = limits or declared(v, start[name] - reach, start[name] + reach)
        for value in (low, high):  # refused now, and not by the FMU in a step
            file.checked(inner, int(value) if whole and value.is_integer() else value, component)
        found.append(Port(name, v.unit, low, high, whole))
    return found


def observations_of(given: Ports, files: Mapping[str, FmuFile]) -> list[Port]:
    """The signals called `given`, which are any variables that are numbers. Where neither the user nor the FMU says a
    limit, it is FAR nominal values from 0; a truth value is 0 or 1.

    Raises UsageError for what is no number, and for limits that are none.
    """
    found = []
    for name, limits in pairs("observations", given):
        v = variable("observations", name, files)
        far = FAR * abs(v.nominal or 1.0)
        found.append(Port(name, v.unit, *(limits or declared(v, -far, far)), v.family != "Real"))
    return found


def pairs(word: str, given: Ports) -> list[tuple[str, Limits | None]]:
    """Names with the limits that the user says, if any. Raises UsageError, calling them `word`, for anything else."""
    if isinstance(given, str) or not isinstance(given, Iterable):
        raise UsageError(f"{word} = {given!r} is not allowed: it must be a list of names, or a dict of names and "
                         f"(low, high).")
    said = given if isinstance(given, Mapping) else {}
    found = [(name, limits_of(word, name, said.get(name))) for name in given]
    names = [name for name, _ in found]
    if not names:
        raise UsageError(f"{word} is empty: name at least one, as component.variable.")
    for name in names:
        if names.count(name) > 1:
            raise UsageError(f"{word} has {name} twice.")
    return found


def limits_of(word: str, name: str, limits: Any) -> Limits | None:
    """Two numbers, the first the lower one, or None. Raises UsageError for anything else."""
    if limits is None:
        return None
    good = isinstance(limits, tuple | list) and len(limits) == 2 and all(
        isinstance(x, Real) and not isinstance(x, bool) and not isnan(x) for x in limits) and limits[0] < limits[1]
    if not good:
        raise UsageError(f"{word}: the limits of {name} are {limits!r}; they must be two numbers, (low, high), with "
                         f"low < high.")
    return float(limits[0]), float(limits[1])


def variable(word: str, name: Any, files: Mapping[str, FmuFile], causalities: tuple[str, ...] = ()) -> Variable:
    """What the FMUs declare of `component.variable`. Raises UsageError for one that is not there, is no number or has
    another causality."""
    known = {f"{component}.{v.name}": v for component, file in files.items() for v in file.variables.values()
             if v.family in NUMERIC and (not causalities or v.causality in causalities)}
    if name not in known:
        what = "no input that takes numbers" if causalities else "no variable that is a number"
        raise UsageError(f"{word}: {name} is {what}{did_you_mean(str(name), known)}")
    return known[name]


def declared(v: Variable, low: float, high: float) -> Limits:
    """The limits that the FMU declares, else these; of a truth value 0 and 1, of an enumeration its items."""
    if v.family == "Boolean":
        return 0.0, 1.0
    if v.items:
        low, high = min(v.items.values()), max(v.items.values())
    return float(low if v.min is None else v.min), float(high if v.max is None else v.max)


def bounds(ports: list[Port]) -> tuple[np.ndarray, np.ndarray]:
    """The lower and the upper limits, shape (ports,) each."""
    return np.array([port.low for port in ports]), np.array([port.high for port in ports])


def begins(system: System, files: Mapping[str, FmuFile]) -> dict[str, float]:
    """`component.variable` of each input that takes numbers -> what it has at the start. Raises UsageError for a value
    of the system that does not fit."""
    found = {}
    for component in system.components:
        file, values = files[component.name], component.values
        for name in file.names("input"):
            if file.variables[name].family in NUMERIC:
                found[f"{component.name}.{name}"] = float(
                    file.checked(name, values[name], component.name) if name in values else file.start(name))
    return found


def drawn(name: str, draw: Any, random: np.random.Generator) -> Value:
    """A value of `draw`: itself, uniform between two numbers, or what a function makes of `random`.

    Raises UsageError for anything else.
    """
    found: Any = draw(random) if callable(draw) else draw
    if isinstance(draw, tuple | list):
        found = random.uniform(*(limits_of("values", name, draw) or ()))
    found = found.item() if isinstance(found, np.generic) else found
    if not isinstance(found, bool | int | float | str):
        raise UsageError(f"values: {name} = {found!r} is not allowed: it must be a value, (low, high), or a function "
                         f"that makes a value of a random generator.")
    return found
