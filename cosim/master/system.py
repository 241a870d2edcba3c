"""A system to fly, as data: which FMUs, with which values, wired how."""
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import Any

from ..errors import UsageError

Value = float | int | bool | str


@dataclass(frozen=True, init=False)
class Component:
    """One FMU instance: its name in the system, its file, and the start values and parameters to set.

    Values are in the units that the FMU declares. Raises UsageError for a name that is empty or has a dot, and for
    arguments of the wrong type.
    """
    name: str
    fmu: Path
    values: dict[str, Value]

    def __init__(self, name: str, fmu: str | PathLike[str], values: Mapping[str, Value] | None = None):
        if not isinstance(name, str) or not name or "." in name:
            raise UsageError(f"The component name {name!r} is not allowed: it must be a text without dots.")
        if not isinstance(values, Mapping | None):
            raise UsageError(f"The values of {name} are {values!r}; they must be a dict such as {{'mass': 300.0}}.")
        assign(self, name=name, fmu=as_path(fmu), values=dict(values or {}))

    def with_values(self, values: Mapping[str, Value]) -> "Component":
        """The same component with `values` set as well; they replace those of the same names."""
        return replace(self, values={**self.values, **values})


@dataclass(frozen=True)
class Connection:
    """target = factor * source + offset, both named `component.variable`."""
    source: str
    target: str
    factor: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True, init=False)
class System:
    """Components in the order in which they step, and the connections between them.

    `step`, `stop` and `start` (s) are what the system's file suggests; None if it does not say.
    Raises UsageError for two components of the same name, or for entries that are none.
    """
    components: tuple[Component, ...]
    connections: tuple[Connection, ...]
    step: float | None
    stop: float | None
    start: float

    def __init__(self, components: Sequence[Component], connections: Sequence[Connection] = (),
                 step: float | None = None, stop: float | None = None, start: float = 0.0):
        assign(self, components=checked(components, Component), connections=checked(connections, Connection),
               step=step, stop=stop, start=start)
        names = [c.name for c in self.components]
        for name in names:
            if names.count(name) > 1:
                raise UsageError(f"Two components are called {name}.")

    def with_values(self, values: Mapping[str, Value]) -> "System":
        """The same system with values of `component.variable` set as well. Raises UsageError for no such component."""
        found: dict[str, dict[str, Value]] = {c.name: {} for c in self.components}
        for name, value in values.items():
            component, _, variable = name.partition(".")
            self.component(component)
            found[component][variable] = value
        return replace(self, components=tuple(c.with_values(found[c.name]) for c in self.components))

    def without(self, *names: str) -> "System":
        """The same system without the components called `names` and their connections: nothing feeds the inputs that
        they fed. Raises UsageError for no such component."""
        gone = {self.component(name).name for name in names}
        links = tuple(link for link in self.connections
                      if gone.isdisjoint(end.partition(".")[0] for end in (link.source, link.target)))
        return replace(self, components=tuple(c for c in self.components if c.name not in gone), connections=links)

    def component(self, name: str) -> Component:
        """The component called `name`. Raises UsageError if there is none."""
        known = {c.name: c for c in self.components}
        if name not in known:
            raise UsageError(f"There is no component {name}; there are {', '.join(known)}.")
        return known[name]


def as_path(given: str | PathLike[str]) -> Path:
    """Raises UsageError unless `given` is a text or a path."""
    if not isinstance(given, str | PathLike):
        raise UsageError(f"{given!r} is not the path of a file.")
    return Path(given)


def assign(frozen: Any, **values: Any) -> None:
    """Set attributes of a frozen dataclass, in its __init__."""
    for name, value in values.items():
        object.__setattr__(frozen, name, value)


def checked(given: Any, kind: type) -> tuple[Any, ...]:
    """`given` as a tuple. Raises UsageError unless it is a sequence of `kind`."""
    word = kind.__name__.lower()
    if isinstance(given, str) or not isinstance(given, Sequence):
        raise UsageError(f"A system's {word}s must be a list of cosim.{kind.__name__}, not {given!r}.")
    for entry in given:
        if not isinstance(entry, kind):
            raise UsageError(f"A system's {word}s must be cosim.{kind.__name__} each; {entry!r} is not.")
    return tuple(given)
