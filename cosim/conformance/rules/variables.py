"""Variables and their names (FMI 2.0: sections 2.2.7 and 2.2.9, 3.0: 2.4.7)."""
import re
from collections import defaultdict
from collections.abc import Iterator

from ...master.declared import VARIABILITIES, Variable, integer, number
from ..repeats import repeated
from ..rule import FORMAL, static
from ..subject import Fault, Fmu

# Section 2.2.9, the grammar of "structured" names. The specification's escapes are \' \" \? \\ \a \b \f \n \r \t \v.
B_NAME = r"""(?:[A-Za-z_][A-Za-z_0-9]*|'(?:[A-Za-z0-9_!#$%&()*+,\-./:;<>=?@\[\]^{}|~ ]|\\['"?\\abfnrtv])+')"""
PART = rf"{B_NAME}(?:\[\d+(?:,\d+)*\])?"
IDENTIFIER = rf"{PART}(?:\.{PART})*"
STRUCTURED = re.compile(rf"{IDENTIFIER}|der\({IDENTIFIER}(?:,\d+)?\)")


@static("variable.unique")
def unique(fmu: Fmu) -> Iterator[Fault]:
    for name, count in repeated(v.name for v in [*fmu.description.variables, *fmu.description.aliases]):
        yield Fault(name, f"{count} variables of this name", "one")


@static("variable.named")
def named(fmu: Fmu) -> Iterator[Fault]:
    for v in fmu.description.variables:
        if "name" in v.attributes and v.name == "":
            yield Fault(f"variable {v.index}", "an empty name", "a name")


@static("variable.name-spaces")
def name_spaces(fmu: Fmu) -> Iterator[Fault]:
    for v in fmu.description.variables:
        if is_flat(fmu) and v.name != v.name.strip(" "):
            yield Fault(v.name, f"'{v.name}'", f"'{v.name.strip()}'")


@static("variable.flat-name")
def flat_name(fmu: Fmu) -> Iterator[Fault]:
    for v in fmu.description.variables:
        if is_flat(fmu) and re.search(r"[\t\n\r]", v.name):
            yield Fault(v.name, repr(v.name), "a name without tab, line feed and carriage return")


@static("variable.structured-name")
def structured_name(fmu: Fmu) -> Iterator[Fault]:
    for v in fmu.description.variables:
        if not is_flat(fmu) and v.name and not STRUCTURED.fullmatch(v.name):
            yield Fault(v.name, f"'{v.name}'", "a structured name such as a.b[3].c or der(a.b)")


def is_flat(fmu: Fmu) -> bool:
    """Whether names are flat, not structured."""
    return fmu.description.attributes.get("variableNamingConvention", "flat") != "structured"


@static("variable.derivative-name")
def derivative_name(fmu: Fmu) -> Iterator[Fault]:
    for v in fmu.description.variables:
        if not is_flat(fmu) and v.name.startswith("der(") and v.family not in ("Real", ""):
            yield Fault(v.name, f"a {v.type}", "a Real: derivatives are")


@static("variable.causality")
def causality(fmu: Fmu) -> Iterator[Fault]:
    for v in fmu.description.variables:
        allowed = [variability for variability, causality in fmu.version.initial if causality == v.causality]
        known = allowed and v.variability in VARIABILITIES  # else the schema's finding
        if known and v.variability not in allowed:
            yield Fault(v.name, f"a {v.variability} {v.causality}", f"variability {' or '.join(allowed)}")


@static("variable.continuous-real")
def continuous_real(fmu: Fmu) -> Iterator[Fault]:
    for v in fmu.description.variables:
        allowed = (v.variability, v.causality) in fmu.version.initial
        if allowed and v.variability == "continuous" and v.family not in ("Real", ""):
            implied = "" if "variability" in v.attributes else " (the default)"
            yield Fault(v.name, f"a continuous {v.type}{implied}", "variability discrete, or type Real")


@static("variable.initial")
def initial(fmu: Fmu) -> Iterator[Fault]:
    for v in fmu.description.variables:
        allowed = fmu.version.initial.get((v.variability, v.causality))
        given = v.attributes.get("initial")
        if allowed is not None and given in ("exact", "approx", "calculated") and given not in allowed:
            expected = " or ".join(allowed) if allowed else "no `initial`"
            yield Fault(v.name, f"initial '{given}' of a {v.variability} {v.causality}", expected)


def wants_start(fmu: Fmu, v: Variable) -> bool | None:
    """Whether a start value must (True) or must not (False) be given; None if the attributes contradict each other."""
    allowed = fmu.version.initial.get((v.variability, v.causality))
    given = v.attributes.get("initial")
    if allowed is None or (given is not None and given not in allowed) or v.type == "Clock":
        return None
    return v.causality == "input" or (given or (allowed or ("",))[0]) in ("exact", "approx")


@static("variable.start-missing")
def start_missing(fmu: Fmu) -> Iterator[Fault]:
    for v in fmu.description.variables:
        if v.type and v.start is None and wants_start(fmu, v) is True:
            why = "an input" if v.causality == "input" else f"initial '{v.initial}'"
            yield Fault(v.name, "no start value", f"a start value ({why})")


@static("variable.start-forbidden")
def start_forbidden(fmu: Fmu) -> Iterator[Fault]:
    for v in fmu.description.variables:
        if v.start is not None and wants_start(fmu, v) is False:
            why = "independent" if v.causality == "independent" else "initial 'calculated'"
            yield Fault(v.name, f"start '{v.start}'", f"no start value ({why})")


@static("variable.start-range")
def start_range(fmu: Fmu) -> Iterator[Fault]:
    for v in fmu.description.variables:
        low, high = number(v.resolved("min")), number(v.resolved("max"))
        if v.family not in ("Real", "Integer", "Enumeration"):
            continue
        if low is not None and high is not None and low > high:
            continue  # rule range.min-max
        for start in (number(text) for text in starts(v)):
            if start is not None and ((low is not None and start < low) or (high is not None and start > high)):
                bounds = f"{v.resolved('min') or '-inf'} to {v.resolved('max') or 'inf'}"
                yield Fault(v.name, f"start {start:g}", bounds)
                break


def starts(v: Variable) -> list[str | None]:
    """The start values: one, or those of an array."""
    return list(v.starts) if v.shape is not None else [v.start]


@static("variable.start-item")
def start_item(fmu: Fmu) -> Iterator[Fault]:
    for v in fmu.description.variables:
        if v.type == "Enumeration" and v.declared is not None and v.declared.items and integer(v.start) is not None:
            values = [integer(item.get("value")) for item in v.declared.items]
            if integer(v.start) not in values:
                yield Fault(v.name, f"start {v.start}", f"one of {', '.join(map(str, values))}")


@static("variable.independent")
def independent(fmu: Fmu) -> Iterator[Fault]:
    names = [v.name for v in fmu.description.variables if v.causality == "independent"]
    if fmu.description.flat and not names:
        yield Fault("independent", "no independent variable", "exactly one")
    if len(names) > 1:
        yield Fault(names[1], f"{len(names)} independent variables: {', '.join(names)}", "at most one")


@static("variable.derivative-index")
def derivative_index(fmu: Fmu) -> Iterator[Fault]:
    for v in fmu.description.variables:
        if v.derivative is not None and (v.derivative == v.index or fmu.description.variable(v.derivative) is None):
            found, others = f"derivative {v.derivative}", f"an index from 1 to {len(fmu.description.variables)}"
            if fmu.description.flat:
                found, others = "derivative of itself or of what no variable has", "the value reference of a variable"
            yield Fault(v.name, found, f"{others} other than {v.index if not fmu.description.flat else v.reference}")


@static("variable.derivative-real")
def derivative_real(fmu: Fmu) -> Iterator[Fault]:
    for v in fmu.description.variables:
        of = fmu.description.variable(v.derivative)
        if of is None or of is v:
            continue
        for one in (v, of):
            if (one.family, one.variability) != ("Real", "continuous"):
                yield Fault(v.name, f"'{one.name}' is a {one.variability} {one.type}", "a continuous Real")


@static("variable.reinit")
def reinit(fmu: Fmu) -> Iterator[Fault]:
    for v in fmu.description.variables:
        if "reinit" in v.own and fmu.description.model_exchange is None:
            yield Fault(v.name, f"reinit '{v.own['reinit']}'", "no `reinit` (for ModelExchange only)")


@static("variable.reinit-state")
def reinit_state(fmu: Fmu) -> Iterator[Fault]:
    states = fmu.description.states
    if fmu.description.flat:  # FMI 3.0: derivatives need not be listed for co-simulation
        states = {v.derivative for v in fmu.description.variables if v.derivative}
    for v in fmu.description.variables:
        is_judged = fmu.description.model_exchange is not None or fmu.description.flat
        if "reinit" in v.own and is_judged and v.index not in states:
            yield Fault(v.name, f"reinit '{v.own['reinit']}'", "no `reinit`: the variable is not a state")


@static("variable.multiple-set")
def multiple_set(fmu: Fmu) -> Iterator[Fault]:
    for v in fmu.description.variables:
        if "canHandleMultipleSetPerTimeInstant" in v.attributes and fmu.description.model_exchange is None:
            yield Fault(v.name, "canHandleMultipleSetPerTimeInstant", "no such attribute (for ModelExchange only)")


def alias_sets(fmu: Fmu) -> Iterator[list[Variable]]:
    """Variables of one base type and one value reference: they share their value."""
    sets: dict[tuple[str, int | None], list[Variable]] = defaultdict(list)
    for v in fmu.description.variables:
        sets[v.base, v.reference].append(v)
    yield from (variables for variables in sets.values() if len(variables) > 1)


def quoted_names(variables: list[Variable]) -> str:
    """The names of variables in quotes."""
    return ", ".join(f"'{v.name}'" for v in variables)


def is_settable(v: Variable) -> bool:
    """Whether the environment can set the variable."""
    return v.variability != "constant" and (v.causality == "input" or v.initial in ("exact", "approx"))


@static("alias.settable")
def alias_settable(fmu: Fmu) -> Iterator[Fault]:
    for variables in alias_sets(fmu):
        settable = [v for v in variables if is_settable(v)]
        if len(settable) > 1:
            found = f"{quoted_names(settable)} share a value and can all be set"
            yield Fault(settable[1].name, found, "at most one of them")


@static("alias.constant")
def alias_constant(fmu: Fmu) -> Iterator[Fault]:
    for variables in alias_sets(fmu):
        constant = [v for v in variables if v.variability == "constant"]
        if constant and len(constant) < len(variables):
            yield Fault(constant[0].name, f"{quoted_names(variables)} share a value", "all of them constant, or none")


@static("alias.constant-start")
def alias_constant_start(fmu: Fmu) -> Iterator[Fault]:
    for variables in alias_sets(fmu):
        starts = {v.start for v in variables if v.variability == "constant"}
        if len(starts) > 1:
            yield Fault(variables[1].name, f"starts {', '.join(sorted(map(str, starts)))}", "one start value for all")


@static("alias.unit")
def alias_unit(fmu: Fmu) -> Iterator[Fault]:
    for variables in alias_sets(fmu):
        units = {v.resolved("unit") for v in variables}
        if len(units) > 1:
            found = f"units {', '.join(sorted(map(str, units)))} in one alias set"
            contradicts = len(units - {None}) > 1
            yield Fault(variables[1].name, found, "one unit", None if contradicts else FORMAL)


@static("alias.variability")
def alias_variability(fmu: Fmu) -> Iterator[Fault]:
    for variables in alias_sets(fmu):
        found = {v.variability for v in variables}
        if len(found) > 1 and "constant" not in found and not any(v.causality == "independent" for v in variables):
            told = f"{quoted_names(variables)} share a value and are {', '.join(sorted(found))}"
            yield Fault(variables[1].name, told, "one variability")


@static("alias.independent")
def alias_independent(fmu: Fmu) -> Iterator[Fault]:
    for variables in alias_sets(fmu):
        settable = [v for v in variables if is_settable(v)]
        if settable and any(v.causality == "independent" for v in variables):
            yield Fault(settable[0].name, f"{quoted_names(variables)} share a value", "time alone")
