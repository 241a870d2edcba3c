"""The master: loads a system's FMUs, initialises them together, steps them, keeps what they say.

All numbers of a run live in one flat vector, `signals`: every output of every component, as doubles.
A component's inputs are gathered from it, so a connection is a pair of indices.
"""
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .errors import RunError, UsageError
from .fmu import FmuFile, Instance
from .system import System

NUMERIC = ("Real", "Integer", "Boolean", "Enumeration")


@dataclass
class Group:
    """Variables of one type of one component that move in one FMI call."""
    kind: str
    names: list[str]
    references: np.ndarray
    buffer: np.ndarray
    call: Any
    where: np.ndarray                    # indices into `signals`: read into, or gathered from
    factor: np.ndarray | None = None     # for inputs: factor and offset, or None if all are 1 and 0
    offset: np.ndarray | None = None
    arguments: tuple = ()


@dataclass
class Member:
    """A component while it runs."""
    instance: Instance
    outputs: list[Group] = field(default_factory=list)
    inputs: list[Group] = field(default_factory=list)


@dataclass
class Signal:
    """One column of the results."""
    name: str
    unit: str
    description: str


class Master:
    """A loaded system. `signals` holds all outputs at the current time, `columns` says which is which."""

    def __init__(self, system: System, files: dict[str, FmuFile]):
        """`files` has the open FMU file of every component.

        Raises UsageError for values or connections that do not fit the FMUs, RunError if an FMU does
        not instantiate.
        """
        self.system, self.files = system, files
        self.values = {c.name: {n: files[c.name].checked(n, x, c.name) for n, x in c.values.items()}
                       for c in system.components}
        self.columns: list[Signal] = []
        self.index: dict[str, int] = {}
        for component in system.components:
            for name in files[component.name].names("output"):
                v = files[component.name].variables[name]
                if v.type in NUMERIC:
                    self.index[f"{component.name}.{name}"] = len(self.columns)
                    self.columns.append(Signal(f"{component.name}.{name}", v.unit or "", v.description or ""))
        self.signals = np.zeros(len(self.columns))
        sources = self._sources()
        self.members: list[Member] = []
        try:
            for component in system.components:
                self.members.append(Member(Instance(files[component.name], component.name)))
            for member in self.members:
                self._wire(member, sources)
        except BaseException:
            self.close()
            raise

    def _sources(self) -> dict[str, tuple[int, float, float]]:
        """Input `component.variable` -> (index of its source, factor, offset)."""
        sources: dict[str, tuple[int, float, float]] = {}
        for connection in self.system.connections:
            if connection.source not in self.index:
                raise UsageError(f"{connection.source} is not a numeric output that a connection can start from.")
            component, _, name = connection.target.partition(".")
            if component not in self.files or self.files[component].variable(name).causality != "input":
                raise UsageError(f"{connection.target} is not an input that a connection can end at.")
            if connection.target in sources:
                raise UsageError(f"{connection.target} has more than one connection.")
            sources[connection.target] = (self.index[connection.source], connection.factor, connection.offset)
        return sources

    def _wire(self, member: Member, sources: dict[str, tuple[int, float, float]]) -> None:
        instance = member.instance
        file, prefix = instance.file, instance.name + "."
        for kind in NUMERIC:
            def group(verb: str, names: list[str], where: list[int], kind: str = kind) -> Group:
                references = np.array([file.variables[n].valueReference for n in names], dtype=np.uint32)
                buffer = np.zeros(len(names), dtype=np.float64 if kind == "Real" else np.int32)
                made = Group(kind, names, references, buffer, instance.accessor(verb, kind),
                             np.array(where, dtype=np.intp))
                made.arguments = (instance.component, references.ctypes.data, len(names), buffer.ctypes.data)
                return made

            outputs = [n for n in file.names("output") if file.variables[n].type == kind]
            if outputs:
                member.outputs.append(group("Get", outputs, [self.index[prefix + n] for n in outputs]))
            inputs = [n for n in file.names("input") if prefix + n in sources and file.variables[n].type == kind]
            if inputs:
                made = group("Set", inputs, [sources[prefix + n][0] for n in inputs])
                if any(sources[prefix + n][1:] != (1.0, 0.0) for n in inputs):
                    made.factor = np.array([sources[prefix + n][1] for n in inputs])
                    made.offset = np.array([sources[prefix + n][2] for n in inputs])
                member.inputs.append(made)

    # --- one component's share of a tick ------------------------------------------------------------

    def set_inputs(self, member: Member, time: float) -> None:
        for group in member.inputs:
            gathered = self.signals[group.where]
            if group.factor is not None:
                gathered = group.factor * gathered + group.offset
            group.buffer[:] = gathered
            status = group.call(*group.arguments)
            if status > 1:
                member.instance.check(status, f"fmi2Set{group.kind}", time)

    def read_outputs(self, member: Member, time: float) -> None:
        for group in member.outputs:
            status = group.call(*group.arguments)
            if status > 1:
                member.instance.check(status, f"fmi2Get{group.kind}", time)
            self.signals[group.where] = group.buffer

    def step(self, member: Member, time: float, step: float) -> None:
        status = member.instance.do_step(member.instance.component, time, step, 1)
        if status > 1:
            member.instance.check(status, "fmi2DoStep", time)

    # --- life cycle -----------------------------------------------------------------------------------

    def initialise(self, start: float, stop: float) -> None:
        """Set values, then pass outputs to inputs in initialisation mode until nothing changes any more.

        Raises RunError if an FMU refuses, or if the values do not settle.
        """
        for member in self.members:
            instance = member.instance
            instance.set(self.values[instance.name])
            instance.setup(start, stop)
            instance.simple("fmi2EnterInitializationMode")
            self.read_outputs(member, start)
        for _ in range(2 * len(self.members) + 10):
            before = self.signals.copy()
            for member in self.members:
                self.set_inputs(member, start)
                self.read_outputs(member, start)
            if np.array_equal(before, self.signals, equal_nan=True):
                break
        else:
            restless = [c.name for c, a, b in zip(self.columns, before, self.signals) if a != b]
            raise RunError(f"The initial values do not settle: {', '.join(restless[:5])} change with every pass.")
        for member in self.members:
            member.instance.simple("fmi2ExitInitializationMode")
            self.read_outputs(member, start)

    def tick(self, time: float, step: float) -> None:
        """Gauss-Seidel: each component in turn takes its inputs as they are now, steps, and shows its outputs."""
        for member in self.members:
            self.set_inputs(member, time)
            self.step(member, time, step)
            self.read_outputs(member, time + step)

    def jacobi_tick(self, time: float, step: float) -> None:
        """Jacobi: all take the inputs of the tick's start, all step, then all show their outputs."""
        for member in self.members:
            self.set_inputs(member, time)
        for member in self.members:
            self.step(member, time, step)
        for member in self.members:
            self.read_outputs(member, time + step)

    def close(self) -> None:
        for member in self.members:
            member.instance.close()
        self.members = []


ALGORITHMS: dict[str, Callable[[Master, float, float], None]] = {
    "gauss-seidel": Master.tick,
    "jacobi": Master.jacobi_tick,
}


@contextmanager
def open_files(system: System) -> Iterator[dict[str, FmuFile]]:
    """The FMU files of a system, extracted; each file once, however many components use it."""
    opened: dict[str, FmuFile] = {}
    try:
        for component in system.components:
            path = str(component.fmu.resolve())
            if path not in opened:
                opened[path] = FmuFile.open(component.fmu)
        yield {c.name: opened[str(c.fmu.resolve())] for c in system.components}
    finally:
        for file in opened.values():
            file.close()
