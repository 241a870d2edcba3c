"""A system to fly, as data: which FMUs, with which values, wired how."""
from dataclasses import dataclass, field, replace
from pathlib import Path

Value = float | int | bool | str


@dataclass(frozen=True)
class Component:
    """One FMU instance: its name in the system, its file, and the start values and parameters to set."""
    name: str
    fmu: Path
    values: dict[str, Value] = field(default_factory=dict)

    def with_values(self, values: dict[str, Value]) -> "Component":
        return replace(self, values={**self.values, **values})


@dataclass(frozen=True)
class Connection:
    """target = factor * source + offset, both named `component.variable`."""
    source: str
    target: str
    factor: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True)
class System:
    """Components in the order in which they step, and the connections between them."""
    components: tuple[Component, ...]
    connections: tuple[Connection, ...]
