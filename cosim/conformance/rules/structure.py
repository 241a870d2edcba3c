"""ModelStructure (FMI 2.0: section 2.2.8, 3.0: 2.4.8): outputs, derivatives, initial unknowns, and dependencies."""
from collections.abc import Iterator
from itertools import pairwise

from ...master.declared import CAUSALITIES, Unknown, Variable
from ..repeats import repeated
from ..rule import static
from ..subject import Fault, Fmu


def entry_name(fmu: Fmu, tag: str, unknown: Unknown) -> str:
    """An entry of ModelStructure as messages call it."""
    variable = fmu.description.variable(unknown.index)
    return f"{tag}: {variable.name if variable else unknown.index}"


@static("structure.index")
def index(fmu: Fmu) -> Iterator[Fault]:
    for tag, unknown in fmu.description.structure:
        if unknown.index is not None and fmu.description.variable(unknown.index) is None:
            yield Fault(tag, *nowhere(fmu, unknown.index))


def nowhere(fmu: Fmu, index: int | None) -> tuple[str, str]:
    """What is there and what should be there where an entry leads to no variable."""
    if fmu.description.flat:
        return "a value reference that no variable has", "the value reference of a variable"
    return f"index {index}", f"an index from 1 to {len(fmu.description.variables)}"


@static("structure.unique")
def unique(fmu: Fmu) -> Iterator[Fault]:
    for tag in ("Outputs", "Derivatives", "InitialUnknowns"):
        listed = [u.index for t, u in fmu.description.structure if t == tag]
        for number, count in repeated(n for n in listed if n):  # FMI 3.0: 0 for what leads nowhere
            variable = fmu.description.variable(number)
            yield Fault(f"{tag}: {variable.name if variable else number}", f"{count} entries", "one")


@static("structure.outputs-complete")
def outputs_complete(fmu: Fmu) -> Iterator[Fault]:
    listed = {unknown.index for unknown in fmu.description.outputs}
    for v in fmu.description.variables:
        if v.causality == "output" and v.index not in listed:
            yield Fault(v.name, "an output that is not in Outputs", f"{entry(fmu, v)} in Outputs")


@static("structure.outputs-only")
def outputs_only(fmu: Fmu) -> Iterator[Fault]:
    for unknown in fmu.description.outputs:
        variable = fmu.description.variable(unknown.index)
        if variable is not None and variable.causality != "output":
            yield Fault(variable.name, f"a {variable.causality} in Outputs", "outputs only")


@static("structure.derivative")
def derivative(fmu: Fmu) -> Iterator[Fault]:
    for unknown in fmu.description.derivatives:
        variable = fmu.description.variable(unknown.index)
        if variable is not None and "derivative" not in variable.own:
            yield Fault(variable.name, "in Derivatives without attribute `derivative`", "the index of its state")


@static("structure.state")
def state(fmu: Fmu) -> Iterator[Fault]:
    for number in sorted(fmu.description.states):
        variable = fmu.description.variable(number)
        if variable is not None and variable.causality not in ("local", "output"):
            yield Fault(variable.name, f"a state of causality {variable.causality}", "causality local or output")


def unknowns_to_list(fmu: Fmu) -> list[Variable]:
    """What InitialUnknowns must list: outputs, calculated parameters, states and derivatives, unless exact.

    In FMI 3.0 not what is clocked.
    """
    of_states = fmu.description.states | {unknown.index for unknown in fmu.description.derivatives}
    return [v for v in fmu.description.variables if v.causality == "calculatedParameter"
            or (v.initial in ("approx", "calculated") and not is_clocked(v)
                and (v.causality == "output" or v.index in of_states))]


def is_clocked(v: Variable) -> bool:
    """Whether the variable is a clock or belongs to one (FMI 3.0): the FMU may list it or not."""
    return v.type == "Clock" or "clocks" in v.attributes


@static("structure.initial-complete")
def initial_complete(fmu: Fmu) -> Iterator[Fault]:
    listed = {unknown.index for unknown in fmu.description.initial_unknowns}
    for v in unknowns_to_list(fmu):
        if v.index not in listed:
            yield Fault(v.name, f"{v.causality}, initial '{v.initial}', not in InitialUnknowns",
                        f"{entry(fmu, v)} in InitialUnknowns")


def entry(fmu: Fmu, v: Variable) -> str:
    """How ModelStructure refers to a variable."""
    return f'valueReference="{v.reference}"' if fmu.description.flat else f'<Unknown index="{v.index}"/>'


@static("structure.initial-only")
def initial_only(fmu: Fmu) -> Iterator[Fault]:
    allowed = {v.index for v in unknowns_to_list(fmu)}
    for unknown in fmu.description.initial_unknowns:
        variable = fmu.description.variable(unknown.index)
        if variable is not None and variable.index not in allowed and not is_clocked(variable):
            what = f"{variable.causality}, initial '{variable.initial}', in InitialUnknowns"
            yield Fault(variable.name, what, "only what is calculated during initialization")


@static("structure.initial-order")
def initial_order(fmu: Fmu) -> Iterator[Fault]:
    indices = [unknown.index or 0 for unknown in fmu.description.initial_unknowns]
    for first, second in pairwise(indices):
        if first > second:
            yield Fault("InitialUnknowns", f"index {first} before {second}", "increasing indices")
            return


@static("dependency.index")
def dependency_index(fmu: Fmu) -> Iterator[Fault]:
    for tag, unknown in fmu.description.structure:
        for number in unknown.dependencies or []:
            if fmu.description.variable(number) is None:
                found, expected = nowhere(fmu, number)
                yield Fault(entry_name(fmu, tag, unknown), f"dependency: {found}", expected)


@static("dependency.order")
def dependency_order(fmu: Fmu) -> Iterator[Fault]:
    for tag, unknown in fmu.description.structure:
        if any(first > second for first, second in pairwise(unknown.dependencies or [])):
            found = " ".join(map(str, unknown.dependencies or []))
            yield Fault(entry_name(fmu, tag, unknown), f"dependencies '{found}'", "increasing indices")


@static("dependency.unique")
def dependency_unique(fmu: Fmu) -> Iterator[Fault]:
    for tag, unknown in fmu.description.structure:
        for number, count in repeated(unknown.dependencies or []):
            yield Fault(entry_name(fmu, tag, unknown), f"dependency {number} listed {count} times", "once")


@static("dependency.kind-count")
def kind_count(fmu: Fmu) -> Iterator[Fault]:
    for tag, unknown in fmu.description.structure:
        if unknown.kinds is None:
            continue
        if unknown.dependencies is None:
            yield Fault(entry_name(fmu, tag, unknown), "dependenciesKind without dependencies", "both, or neither")
        elif len(unknown.kinds) != len(unknown.dependencies):
            found = f"{len(unknown.kinds)} kinds for {len(unknown.dependencies)} dependencies"
            yield Fault(entry_name(fmu, tag, unknown), found, "one kind for each dependency")


@static("dependency.initial-kind")
def initial_kind(fmu: Fmu) -> Iterator[Fault]:
    for unknown in fmu.description.initial_unknowns:
        for kind in sorted({"fixed", "tunable", "discrete"} & set(unknown.kinds or [])):
            name = entry_name(fmu, "InitialUnknowns", unknown)
            yield Fault(name, f"dependenciesKind '{kind}'", "dependent or constant")


@static("dependency.kind-real")
def kind_real(fmu: Fmu) -> Iterator[Fault]:
    for tag, unknown in fmu.description.structure:
        target = fmu.description.variable(unknown.index)
        for number, kind in zip(unknown.dependencies or [], unknown.kinds or [], strict=False):
            known = fmu.description.variable(number)
            if kind == "dependent" or known is None or target is None:
                continue
            if target.family != "Real" or (known.family != "Real" and not fmu.description.flat):
                found = f"'{kind}' dependency of a {target.type} on '{known.name}', a {known.type}"
                yield Fault(entry_name(fmu, tag, unknown), found, "kind 'dependent'")


def is_known(fmu: Fmu, v: Variable, tag: str) -> bool:
    """Whether an entry of the list `tag` may depend on the variable."""
    if v.causality in ("input", "independent") or v.index in fmu.description.states:
        return True
    if v.causality not in CAUSALITIES:
        return True  # the schema's finding
    if fmu.description.flat and (is_clocked(v) or v.variability == "discrete" or v.causality.endswith("arameter")):
        return v.causality != "calculatedParameter"  # discrete-time states are not told apart
    if tag == "InitialUnknowns":
        return v.initial == "exact"
    return v.causality == "parameter" and v.variability == "tunable"


@static("dependency.known")
def dependency_known(fmu: Fmu) -> Iterator[Fault]:
    for tag, unknown in fmu.description.structure:
        for number in unknown.dependencies or []:
            v = fmu.description.variable(number)
            if v is not None and not is_known(fmu, v, tag):
                found = f"depends on '{v.name}', a {v.variability} {v.causality}"
                yield Fault(entry_name(fmu, tag, unknown), found, "inputs, states, time (initially also what is exact)")


@static("dependency.missing")
def dependency_missing(fmu: Fmu) -> Iterator[Fault]:
    has_inputs = any(v.causality == "input" for v in fmu.description.variables)
    unsaid = [u for u in fmu.description.outputs if u.dependencies is None and u.kinds is None]
    if has_inputs and unsaid:
        found = f"{len(unsaid)} outputs without dependencies: a master must assume that they feed through every input"
        yield Fault(entry_name(fmu, "Outputs", unsaid[0]), found, "dependencies, empty where an output has none")
