"""What depends on what, as the FMUs declare it (ModelStructure), and the order that follows from it."""
from collections.abc import Hashable, Iterable, Mapping
from typing import TypeVar

from .fmu import FmuFile
from .system import Connection, System

Node = TypeVar("Node", bound=Hashable)


def strongly_connected(needs: Mapping[Node, Iterable[Node]]) -> list[list[Node]]:
    """The nodes in groups, each after all that it needs; a group of several is a loop.

    Tarjan's algorithm (SIAM J. Comput. 1, 1972), without recursion; within a group the order of `needs`.
    """
    number: dict[Node, int] = {}
    lowest: dict[Node, int] = {}
    waiting: dict[Node, None] = {}
    found: list[list[Node]] = []
    place = {node: i for i, node in enumerate(needs)}
    for root in needs:
        if root in number:
            continue
        path = [(root, iter(needs[root]))]
        number[root] = lowest[root] = len(number)
        waiting[root] = None
        while path:
            node, further = path[-1]
            for other in further:
                if other not in number:
                    number[other] = lowest[other] = len(number)
                    waiting[other] = None
                    path.append((other, iter(needs[other])))
                    break
                if other in waiting:
                    lowest[node] = min(lowest[node], number[other])
            else:
                path.pop()
                if path:
                    lowest[path[-1][0]] = min(lowest[path[-1][0]], lowest[node])
                if lowest[node] == number[node]:
                    group: list[Node] = []
                    while not group or group[-1] != node:
                        group.append(waiting.popitem()[0])
                    found.append(sorted(group, key=place.__getitem__))
    return found


def inputs_behind(file: FmuFile, initially: bool = False) -> dict[str, set[str]]:
    """Output -> the inputs on which it depends directly; all of them where the FMU does not say."""
    inputs = set(file.names("input"))
    unknowns = file.description.initial_unknowns if initially else file.description.outputs
    names_of: dict[int, list[str]] = {}  # of an array those of its elements
    for v in file.scalars:
        names_of.setdefault(v.index, []).append(v.name)
    declared = {name: inputs if u.dependencies is None
                else inputs.intersection(n for i in u.dependencies for n in names_of.get(i, []))
                for u in unknowns if u.index for name in names_of.get(u.index, [])}
    return {name: declared.get(name, inputs) for name in file.names("output")}


def direct_needs(system: System, files: Mapping[str, FmuFile],
                 targets: Mapping[str, Connection]) -> dict[str, list[str]]:
    """Component -> those that feed an input on which any of its outputs depends directly."""
    needs: dict[str, list[str]] = {}
    for component in system.components:
        direct = set().union(*inputs_behind(files[component.name]).values())
        sources = [link.source.partition(".")[0] for target, link in targets.items()
                   if target.partition(".")[0] == component.name and target.partition(".")[2] in direct]
        needs[component.name] = sources
    return needs


def value_needs(system: System, files: Mapping[str, FmuFile], targets: Mapping[str, Connection],
                initially: bool = False) -> dict[str, list[str]]:
    """Connected input -> its source; connected output -> the inputs on which it depends directly. Loops in it are
    algebraic loops."""
    sources = sorted({link.source for link in targets.values()})
    needs: dict[str, list[str]] = {}
    for component in system.components:
        full = component.name + "."
        behind = inputs_behind(files[component.name], initially)
        for name in files[component.name].names("input"):
            if full + name in targets:
                needs[full + name] = [targets[full + name].source]
        for name in sources:
            if name.startswith(full):
                needs[name] = [full + n for n in behind[name[len(full):]] if full + n in targets]
    return needs


def looped(needs: Mapping[str, Iterable[str]]) -> set[str]:
    """The components in algebraic loops."""
    return {name.partition(".")[0] for group in strongly_connected(needs) if len(group) > 1 for name in group}


def step_order(system: System, files: Mapping[str, FmuFile], targets: Mapping[str, Connection]) -> list[list[str]]:
    """Components in the order in which they should step, loops together: each after those on whose outputs its own
    depend directly; the system's order wherever that leaves a choice."""
    needs = direct_needs(system, files, targets)
    groups = strongly_connected(needs)
    group_of = {name: i for i, group in enumerate(groups) for name in group}
    left = {i: {group_of[n] for name in group for n in needs[name]} - {i} for i, group in enumerate(groups)}
    first = {i: min(list(needs).index(n) for n in group) for i, group in enumerate(groups)}
    ordered: list[list[str]] = []
    while left:
        ready = min((i for i, waits in left.items() if not waits), key=first.__getitem__)
        ordered.append(groups[ready])
        del left[ready]
        for waits in left.values():
            waits.discard(ready)
    return ordered
