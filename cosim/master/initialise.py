"""Initialisation: values go from outputs to inputs in the order that the FMUs declare in InitialUnknowns.

What depends on nothing comes first. An algebraic loop is repeated until its values stay the same.
"""
from collections.abc import Iterable, Mapping
from itertools import groupby
from types import MappingProxyType

import numpy as np

from ..errors import RunError
from .declared import number
from .dependencies import strongly_connected, value_needs
from .fmu import FmuFile
from .instance import Instance
from .system import Connection, System

MOST_PASSES = 200
SETTLED = 1e-13  # of the value, or of the variable's nominal one

Batch = list[str]  # component.variable, all of one component and all inputs or all outputs


def order(system: System, files: Mapping[str, FmuFile], targets: Mapping[str, Connection]) -> list[list[Batch]]:
    """What to set and get, in order: a list of one batch is done once, a list of several is an algebraic loop."""
    needs = value_needs(system, files, targets, initially=True)
    groups = strongly_connected(needs)
    level: dict[str, int] = {}
    for group in groups:
        depth = 1 + max((level[n] for name in group for n in needs[name] if n in level), default=-1)
        level.update(dict.fromkeys(group, depth))

    def kind(name: str) -> tuple[str, bool]:
        return name.partition(".")[0], name in targets

    single = sorted((g[0] for g in groups if len(g) == 1), key=lambda n: (level[n], kind(n)))
    steps = [(level[batch[0]], [batch]) for _, names in groupby(single, lambda n: (level[n], kind(n)))
             for batch in [list(names)]]
    steps += [(level[group[0]], [list(names) for _, names in groupby(sorted(group, key=kind), kind)])
              for group in groups if len(group) > 1]
    return [batches for _, batches in sorted(steps, key=lambda item: item[0])]


class Exchange:
    """Sets and gets batches during initialisation; `known` has the connected outputs."""

    def __init__(self, instances: Mapping[str, Instance], targets: Mapping[str, Connection]):
        self.instances, self.targets = instances, targets
        self.known: dict[str, float | str] = {}

    def move(self, batch: Batch) -> None:
        """Set the inputs of a batch, or get its outputs."""
        component = batch[0].partition(".")[0]
        instance, names = self.instances[component], [n.partition(".")[2] for n in batch]
        if batch[0] not in self.targets:
            self.known.update(zip(batch, instance.get(names)))
            return
        values = {}
        for full, name in zip(batch, names):
            link = self.targets[full]
            value = self.known[link.source]
            same = isinstance(value, str) or (link.factor, link.offset) == (1.0, 0.0)  # all digits of a whole number
            values[name] = value if same else link.factor * float(value) + link.offset
        instance.set(values)

    def numbers(self, names: list[str]) -> np.ndarray:
        """The known values of `names`, which are numbers, shape (names,)."""
        return np.array([self.known[n] for n in names], dtype=float)

    def settle(self, batches: list[Batch]) -> None:
        """Repeat a loop until its outputs stay the same, to SETTLED.

        Raises RunError naming the outputs that do not.
        """
        shown = [n for batch in batches if batch[0] not in self.targets for n in batch]
        given = [batch for batch in batches if batch[0] in self.targets]
        read = [batch for batch in batches if batch[0] not in self.targets]
        for batch in read:
            self.move(batch)
        numeric = [n for n in shown if not isinstance(self.known[n], str)]
        nominal = np.array([abs(self.instances[n.partition(".")[0]].file.variable(n.partition(".")[2]).nominal or 1.0)
                            for n in numeric])
        for _ in range(MOST_PASSES):
            before = self.numbers(numeric)
            for batch in given:  # each component's inputs, then at once its outputs
                self.move(batch)
                component = batch[0].partition(".")[0]
                for other in read:
                    if other[0].partition(".")[0] == component:
                        self.move(other)
            after = self.numbers(numeric)
            settled = np.abs(after - before) <= SETTLED * np.maximum(np.abs(after), nominal)
            if np.all(settled):
                return
        unsettled = [n for n, still in zip(numeric, settled) if not still]
        raise RunError(f"The initial values do not settle: {', '.join(unsettled[:5])} still change after "
                       f"{MOST_PASSES} passes through the loop of {', '.join(n for b in given for n in b[:3])}.")


def initialise(batches: Iterable[list[Batch]], instances: Mapping[str, Instance], targets: Mapping[str, Connection],
               start: float, stop: float | None, tolerance: float | None = None,
               inputs: Mapping[str, Mapping[str, float]] = MappingProxyType({})) -> None:
    """From instantiated, with parameters set, to ready to step; `batches` are those of `order`. Times in s; the
    relative tolerance is each FMU's own, of its default experiment, if it is None. `inputs` has values of inputs that
    nothing is connected to: component -> variable -> value.

    Raises RunError if an FMU refuses, or if the values of a loop do not settle.
    """
    for instance in instances.values():
        own = number(instance.file.description.experiment.get("tolerance"))
        instance.enter(start, stop, own if tolerance is None else tolerance)
        instance.set({n: x if instance.file.variables[n].family == "Real" else int(x)
                      for n, x in inputs.get(instance.name, {}).items()})
    exchange = Exchange(instances, targets)
    for group in batches:
        if len(group) == 1:
            exchange.move(group[0])
        else:
            exchange.settle(group)
    for instance in instances.values():
        instance.leave(start)
