"""Which connections and recordings a system's FMUs allow."""
from collections.abc import Iterator
from dataclasses import replace
from fnmatch import fnmatchcase

from ..errors import UsageError
from .declared import NUMERIC
from .fmu import FmuFile, limits
from .system import Connection, System


def checked_connections(system: System, files: dict[str, FmuFile]) -> dict[str, Connection]:
    """Input `component.variable` -> its connection; of two arrays one for each element.

    Raises UsageError naming the connection that does not fit the FMUs.
    """
    targets: dict[str, Connection] = {}
    for link in (part for whole in system.connections for part in by_elements(whole, files)):
        source, target = (end.partition(".") for end in (link.source, link.target))
        if source[0] not in files or files[source[0]].variable(source[2]).causality != "output":
            raise UsageError(f"{link.source} is not an output that a connection can start from.")
        if target[0] not in files or files[target[0]].variable(target[2]).causality != "input":
            raise UsageError(f"{link.target} is not an input that a connection can end at.")
        if link.target in targets:
            raise UsageError(f"{link.target} has more than one connection.")
        ends = files[source[0]], source[2], files[target[0]], target[2]
        kinds = ends[0].variable(ends[1]).type, ends[2].variable(ends[3]).type
        if not fits(*ends):
            raise UsageError(f"{link.source} ({kinds[0]}) cannot be connected to {link.target} ({kinds[1]}).")
        if (link.factor, link.offset) != (1.0, 0.0) and ends[2].variable(ends[3]).family != "Real":
            raise UsageError(f"{link.target} is {kinds[1]}: its connection can have no factor or offset.")
        targets[link.target] = link
    return targets


def by_elements(link: Connection, files: dict[str, FmuFile]) -> Iterator[Connection]:
    """The connection itself, or if both ends are arrays one for each element.

    Raises UsageError for arrays of different shapes.
    """
    ends = [(component, files[component].arrays.get(name) if component in files else None)
            for component, _, name in (end.partition(".") for end in (link.source, link.target))]
    (source, outputs), (target, inputs) = ends
    if outputs is None or inputs is None:
        yield link
        return
    if [name.rpartition("[")[2] for name in outputs] != [name.rpartition("[")[2] for name in inputs]:
        raise UsageError(f"{link.source} ends at {outputs[-1]} and {link.target} at {inputs[-1]}: only arrays of the "
                         f"same shape can be connected.")
    for output, given in zip(outputs, inputs):
        yield replace(link, source=f"{source}.{output}", target=f"{target}.{given}")


def fits(one: FmuFile, source: str, other: FmuFile, target: str) -> bool:
    """Whether what the variable `source` of `one` can be is what `target` of `other` can be.

    A real number takes any number; a whole one those of types that are no wider, where an enumeration counts as 32 bits
    wide; texts and truth values take their own.
    """
    given, taken = one.variable(source), other.variable(target)
    if taken.family == "Real":
        return given.family in ("Real", "Integer", "Enumeration")
    if taken.family not in ("Integer", "Enumeration"):
        return given.family == taken.family and taken.family not in ("Binary", "Clock")
    if given.family not in ("Integer", "Enumeration"):
        return False
    least, most = limits("2.0" if given.family == "Enumeration" else one.description.version, given.type)
    low, high = limits(other.description.version, taken.type)
    return low <= least and most <= high


def recorded_names(system: System, files: dict[str, FmuFile], patterns: list[str] | None) -> set[str]:
    """The variables to record: all numeric outputs, or those whose component.variable fits a pattern.

    Raises UsageError for a pattern that fits nothing.
    """
    known = {f"{c.name}.{v.name}": v for c in system.components for v in files[c.name].variables.values()
             if v.family in NUMERIC}
    if patterns is None:
        return {name for name, v in known.items() if v.causality == "output"}
    chosen: set[str] = set()
    for pattern in patterns:
        literal = pattern.replace("[", "[[]")  # of x[1]
        found = {name for name in known if name == pattern or fnmatchcase(name, pattern) or fnmatchcase(name, literal)}
        if not found:
            raise UsageError(f"--record {pattern} fits no numeric variable of {', '.join(files)}.")
        chosen |= found
    return chosen
