"""What FMI 3.0 alone has: arrays, clocks, value references for all (sections 2.4.4, 2.4.7 and 2.4.8)."""
from collections.abc import Iterator
from math import prod

from lxml import etree

from ...master.declared import Variable, integer, is_true, number
from ..repeats import repeated
from ..rule import static
from ..subject import Fault, Fmu

PERIODIC = ("constant", "fixed", "tunable")


def elements(fmu: Fmu) -> Iterator[tuple[Variable, etree._Element]]:
    """The variables with their elements."""
    yield from zip(fmu.description.variables, fmu.description.elements, strict=True)


def by_reference(fmu: Fmu, text: str | None) -> Variable | None:
    """The variable with this value reference."""
    return fmu.description.variable(fmu.description.index_of(text))


def clocks(fmu: Fmu) -> list[Variable]:
    """The variables of type Clock."""
    return [v for v in fmu.description.variables if v.type == "Clock"]


@static("variable.reference-unique")
def reference_unique(fmu: Fmu) -> Iterator[Fault]:
    for reference, count in repeated(v.reference for v in fmu.description.variables if v.reference is not None):
        names = [v.name for v in fmu.description.variables if v.reference == reference]
        yield Fault(names[1], f"value reference {reference} of {count} variables: {', '.join(names)}", "one variable")


@static("variable.independent-type")
def independent_type(fmu: Fmu) -> Iterator[Fault]:
    for v in fmu.description.variables:
        if v.causality == "independent" and v.family != "Real":
            yield Fault(v.name, f"of type {v.type}", "Float64 or Float32")


@static("variable.multiple-set-input")
def multiple_set_input(fmu: Fmu) -> Iterator[Fault]:
    for v in fmu.description.variables:
        if "canHandleMultipleSetPerTimeInstant" in v.attributes and v.causality != "input":
            yield Fault(v.name, f"canHandleMultipleSetPerTimeInstant of causality {v.causality}", "no such attribute")


@static("variable.intermediate")
def intermediate(fmu: Fmu) -> Iterator[Fault]:
    for v in fmu.description.variables:
        if is_true(v.attributes.get("intermediateUpdate")) and v.variability != "continuous":
            yield Fault(v.name, f"intermediateUpdate of a {v.variability} {v.type}", "no intermediateUpdate")


@static("variable.previous")
def previous(fmu: Fmu) -> Iterator[Fault]:
    having = [v for v in fmu.description.variables if "previous" in v.attributes]
    for v in having:
        of = by_reference(fmu, v.attributes["previous"])
        if of is None or of is v:
            yield Fault(v.name, f"previous {v.attributes['previous']}", "the value reference of another variable")
        elif v.type == "Clock" or v.variability != "discrete" or "clocks" not in v.attributes:
            clocked = "clocked" if "clocks" in v.attributes else "unclocked"
            yield Fault(v.name, f"previous of a {v.variability}, {clocked} {v.type}", "a discrete clocked variable")
        elif (of.type, of.variability) != (v.type, "discrete"):
            yield Fault(v.name, f"previous '{of.name}', a {of.variability} {of.type}", f"a discrete {v.type}")
    for reference, count in repeated(v.attributes["previous"] for v in having):
        yield Fault(reference, f"the previous value of {count} variables", "of one")


# --- arrays ----------------------------------------------------------------------------------------------------------

def dimensions(fmu: Fmu) -> Iterator[tuple[Variable, etree._Element]]:
    """Each dimension with its array."""
    for v, element in elements(fmu):
        yield from ((v, dimension) for dimension in element.iterfind("Dimension"))


@static("array.dimension")
def array_dimension(fmu: Fmu) -> Iterator[Fault]:
    for v, dimension in dimensions(fmu):
        reference = dimension.get("valueReference")
        of = by_reference(fmu, reference)
        if reference is None:
            continue
        if of is None:
            yield Fault(v.name, f"a dimension with value reference {reference}, which no variable has",
                        "that of a structural parameter")
        elif of.type != "UInt64" or (of.causality != "structuralParameter" and of.variability != "constant"):
            yield Fault(v.name, f"a dimension by '{of.name}', a {of.variability} {of.causality} of type {of.type}",
                        "a structuralParameter or constant of type UInt64")


@static("array.size")
def array_size(fmu: Fmu) -> Iterator[Fault]:
    for v, dimension in dimensions(fmu):
        start, reference = dimension.get("start"), dimension.get("valueReference")
        of = by_reference(fmu, reference)
        if (start is None) == (reference is None):
            yield Fault(v.name, f"a dimension with {'neither' if start is None else 'both'}",
                        "either start or valueReference")
        elif integer(start if of is None else of.start) == 0:
            yield Fault(v.name, "a dimension of size 0", "at least 1")


@static("array.starts")
def array_starts(fmu: Fmu) -> Iterator[Fault]:
    for v in fmu.description.variables:
        size = 1 if v.shape is None else prod(v.shape)
        given = len(v.starts) if v.shape is not None else len((v.start or "").split()) if v.family in (
            "Real", "Integer", "Enumeration", "Boolean") else 1
        if size and v.start is not None and given not in (1, size):
            yield Fault(v.name, f"{given} start values for {size} element{'s' * (size > 1)}", f"1 or {size}")


@static("array.structural")
def array_structural(fmu: Fmu) -> Iterator[Fault]:
    for v in fmu.description.variables:
        if v.causality == "structuralParameter" and v.shape is not None:
            yield Fault(v.name, "a structural parameter with dimensions", "a single number")


# --- clocks ----------------------------------------------------------------------------------------------------------

@static("clock.event-mode")
def event_mode(fmu: Fmu) -> Iterator[Fault]:
    found = clocks(fmu)
    if found and fmu.description.co_simulation is not None and not fmu.description.claims("hasEventMode"):
        yield Fault("hasEventMode", f"false, with {len(found)} clocks such as '{found[0].name}'", "true")


@static("clock.causality")
def clock_causality(fmu: Fmu) -> Iterator[Fault]:
    for v in clocks(fmu):
        interval = resolved(v, "intervalVariability")
        if v.causality not in ("input", "output", "local") or v.variability != "discrete":
            yield Fault(v.name, f"a {v.variability} clock of causality {v.causality}",
                        "a discrete input, output or local")
        elif v.causality == "output" and interval not in ("triggered", None):
            yield Fault(v.name, f"an output clock with intervalVariability '{interval}'", "triggered")
        elif v.causality == "output" and resolved(v, "priority") is not None:
            yield Fault(v.name, "an output clock with a priority", "no priority")


def resolved(v: Variable, attribute: str) -> str | None:
    """An attribute of a clock, its own or its type's."""
    return v.attributes.get(attribute) or v.resolved(attribute)


@static("clock.interval")
def clock_interval(fmu: Fmu) -> Iterator[Fault]:
    for v in clocks(fmu):
        found = interval_fault(v)
        if found:
            yield Fault(v.name, *found)


def interval_fault(v: Variable) -> tuple[str, str] | None:
    """What is wrong with a clock's interval, and what should be there."""
    kind, words = resolved(v, "intervalVariability"), "intervalDecimal intervalCounter shiftDecimal shiftCounter"
    given = {word: number(resolved(v, word)) for word in words.split()}
    interval, counter, shift, shift_counter = given.values()
    if kind == "constant" and interval is None:
        return "a constant clock without intervalDecimal", "intervalDecimal above 0"
    for word in ("intervalDecimal", "intervalCounter"):
        value = given[word]
        if value is not None and kind not in PERIODIC:
            return f"{word} of a {kind} clock", f"no {word}"
        if value is not None and value <= 0:
            return f"{word} {value:g}", "a value above 0"
    if counter is not None and not (is_true(resolved(v, "supportsFraction")) and resolved(v, "resolution")):
        return "intervalCounter without supportsFraction and resolution", "all three, or none"
    if (shift is not None and shift < 0) or (shift_counter is not None and shift_counter < 0):
        return f"a shift of {shift if shift is not None else shift_counter:g}", "0 or more"
    if (shift is not None and interval is None) or (shift_counter is not None and counter is None):
        return "a shift without an interval", "both, or neither"
    if resolved(v, "resolution") is not None and kind not in PERIODIC:
        return f"resolution of a {kind} clock", "no resolution"
    return None


@static("clock.reference")
def clock_reference(fmu: Fmu) -> Iterator[Fault]:
    for v in fmu.description.variables:
        listed = v.attributes.get("clocks", "").split()
        for reference in listed:
            of = by_reference(fmu, reference)
            if of is None or of.type != "Clock" or of is v:
                found = "which no variable has" if of is None else "itself" if of is v else f"'{of.name}', a {of.type}"
                yield Fault(v.name, f"clocks {reference}: {found}", "value references of clocks")
        if any(repeated(listed)):
            yield Fault(v.name, f"clocks '{' '.join(listed)}'", "each clock once")
        if "clocks" in v.attributes and v.variability not in ("discrete", "tunable"):
            yield Fault(v.name, f"a clocked {v.variability} {v.type}", "variability discrete or tunable")


@static("clock.state")
def clock_state(fmu: Fmu) -> Iterator[Fault]:
    for entry in fmu.description.root.iterfind("ModelStructure/ClockedState"):
        v = by_reference(fmu, entry.get("valueReference"))
        if v is None:
            yield Fault("ClockedState", f"value reference {entry.get('valueReference')}, which no variable has",
                        "a clocked variable")
        elif not {"previous", "clocks"} <= v.attributes.keys() or v.type == "Clock" or v.variability != "discrete":
            yield Fault(v.name, "a ClockedState that lacks `previous` or `clocks`, or is not discrete",
                        "a discrete clocked variable with `previous`")


@static("structure.event-indicator")
def event_indicator(fmu: Fmu) -> Iterator[Fault]:
    initial = {unknown.index for unknown in fmu.description.initial_unknowns}
    for entry in fmu.description.root.iterfind("ModelStructure/EventIndicator"):
        v = by_reference(fmu, entry.get("valueReference"))
        if v is None:
            yield Fault("EventIndicator", f"value reference {entry.get('valueReference')}, which no variable has",
                        "a continuous float")
        elif (v.family, v.variability) != ("Real", "continuous") or v.causality not in ("local", "output"):
            yield Fault(v.name, f"a {v.variability} {v.causality} of type {v.type}", "a continuous local or output")
        elif v.index in initial and v.causality == "local" and v.index not in fmu.description.states:
            yield Fault(v.name, "an event indicator in InitialUnknown", "no such entry")
