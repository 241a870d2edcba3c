"""Would a naive importer manage? What the standard allows, and importers that were tried do not bear."""
import re
from collections.abc import Iterator

from ..rule import static
from ..subject import Fault, Fmu

# Products and quotients of names with whole powers, which UDUNITS reads: kg.m/s2, (m/s)^2, 1/s. pint wants s^2 for s2.
NAME = r"[A-Za-z_µμΩÅ°%'\"]+"
FACTOR = rf"(?:\d+(?:\.\d+)?(?:[eE][-+]?\d+)?|{NAME})(?:(?:\^|\*\*)?[-+]?\d+)?"
PLAIN = re.compile(rf"\s*{FACTOR}(?:\s*[.*/·⋅ ]\s*{FACTOR})*\s*")
INNER = re.compile(r"\(([^()]*)\)")


def is_plain(unit: str) -> bool:
    """Whether a unit's name is a product that parsers of units read."""
    while found := INNER.search(unit):
        before = unit[:found.start()].rstrip()
        if not PLAIN.fullmatch(found[1]) or before[-1:].isalnum():
            return False  # what follows a name in brackets is a function, such as sqrt(m)
        unit = f"{unit[:found.start()]}1{unit[found.end():]}"
    return bool(PLAIN.fullmatch(unit))


@static("naive.non-real-output")
def non_real_output(fmu: Fmu) -> Iterator[Fault]:
    found = [f"{v.name} ({v.type})" for v in fmu.description.variables
             if v.causality == "output" and v.type not in ("Real", "")]
    if found:
        yield Fault("outputs", f"{len(found)} are no Reals: {', '.join(found)}", "Reals, such as 0 and 1 for a flag")


@static("naive.needs-inputs")
def needs_inputs(fmu: Fmu) -> Iterator[Fault]:
    inputs = {v.index for v in fmu.description.variables if v.causality == "input"}
    found = []
    for unknown in fmu.description.initial_unknowns:
        v = fmu.description.variable(unknown.index)
        if v is not None and v.causality == "output" and inputs & set(unknown.dependencies or ()):
            found.append(v.name)
    if found:
        yield Fault("outputs", f"{len(found)} need inputs before initialization ends: {', '.join(found)}",
                    "outputs that do not, or importers that set the inputs first")


@static("naive.unit-name")
def unit_name(fmu: Fmu) -> Iterator[Fault]:
    found = sorted(name for name in {v.unit for v in fmu.description.variables} if name and not is_plain(name))
    if found:
        yield Fault("units", f"no parser of units reads {', '.join(repr(name) for name in found)}",
                    "products of names with whole powers, such as kg.m/s^2; '1' without a dimension")
