"""What is fitted: parameters and start values, with their bounds and sizes."""
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, isfinite

from ..errors import UsageError, did_you_mean
from ..master.fmu import FmuFile, settable
from ..master.system import System, Value
from .data import Known, owner

FORM = "[FILE:]COMPONENT.VARIABLE[=START|=LOW:HIGH|=START:LOW:HIGH]"


@dataclass(frozen=True)
class Parameter:
    """A value to find, of all flights or of one (`flight`, its place); `target` is component.variable.

    `low` and `high` may be infinite. `scale` is by how much it is expected to change, `unit` is that of all of them.
    Other starts are drawn between the bounds where `bounded`, else around the start.
    """
    name: str
    target: str
    flight: int | None
    start: float
    low: float
    high: float
    scale: float
    unit: str
    bounded: bool

    def range(self) -> tuple[float, float]:
        """Between which values other starts are drawn."""
        if self.bounded:
            return self.low, self.high
        return max(self.low, self.start - 0.5 * self.scale), min(self.high, self.start + 0.5 * self.scale)


def parameter(word: str, known: Known, files: Sequence[str], systems: Sequence[System]) -> Parameter:
    """The parameter of a word, see FORM; `files` are the flights' names, `systems` theirs.

    Raises UsageError for a variable that is not there or cannot be fitted, and for bounds that do not fit.
    """
    flight, rest = owner(word, files)
    name, equals, numbers = rest.partition("=")
    target = known.full(name)
    component, dot, variable = target.partition(".")
    if component not in known.files or not dot:
        near = known.shown(known.numeric(["parameter", "input", "local"]))
        raise UsageError(f"--parameter {word}: there is no variable {name}{did_you_mean(name, near)}")
    file = known.files[component]
    if reason := unfit(target, variable, file, known):
        raise UsageError(f"--parameter {word}: {target} {reason}.")
    given = numbers.split(":") if equals else []
    if len(given) > 3 or given == [""]:
        raise UsageError(f"--parameter {word} is not of the form {FORM}.")
    first, low_word, high_word = [["", "", ""], [*given, "", ""], ["", *given], given][len(given)]
    v = file.variables[variable]
    low = checked(low_word, target, file, -inf if v.min is None else v.min)
    high = checked(high_word, target, file, inf if v.max is None else v.max)
    if not low < high:
        raise UsageError(f"--parameter {word}: the lower bound {low:g} must be below the upper bound {high:g}.")
    start = checked(first, target, file, start_of(component, variable, file, systems[flight or 0]))
    if not low <= start <= high:
        raise UsageError(f"--parameter {word}: the start {start:g} is not between {low:g} and {high:g}.")
    size = abs(v.nominal or 0.0) or abs(start) or (high - low if isfinite(high - low) else 1.0)
    label = f"{files[flight]}:{target}" if flight is not None else target
    return Parameter(label, target, flight, start, low, high, size, "" if v.unit == "1" else v.unit,
                     bool(low_word and high_word))


def unfit(target: str, variable: str, file: FmuFile, known: Known) -> str:
    """Why a variable cannot be fitted; empty if it can. Raises UsageError for one that the FMU does not have."""
    v = file.variable(variable)
    if not settable(v) or v.causality == "structuralParameter":
        return f"is a {v.variability} {v.causality}, which cannot be set"
    if v.family != "Real":
        return f"is of type {v.type}; only real numbers can be fitted"
    if target in known.targets:
        return f"is an input that {known.targets[target].source} feeds"
    return ""


def checked(word: str, target: str, file: FmuFile, otherwise: float) -> float:
    """The number of a word in the variable's unit; `otherwise` for an empty word. Raises UsageError for what the FMU
    does not take."""
    component, _, variable = target.partition(".")
    return float(file.checked(variable, word, component)) if word else otherwise


def start_of(component: str, variable: str, file: FmuFile, system: System) -> float:
    """What the system sets a variable to, else its start value in the FMU."""
    values: dict[str, Value] = next(c.values for c in system.components if c.name == component)
    return float(file.checked(variable, values.get(variable, file.start(variable)), component))


def check_apart(parameters: Sequence[Parameter], own: Sequence[Sequence[str]], known: Known, driven: Sequence[set[str]],
                files: Sequence[str]) -> None:
    """Raises UsageError for a parameter that is named twice, is set for one flight by the words of `own`, or is an
    input that the data of a flight drive (`driven`)."""
    seen: set[tuple[str, int | None]] = set()
    for p in parameters:
        if (p.target, p.flight) in seen or (p.flight is not None and (p.target, None) in seen) or (
                p.flight is None and p.target in {target for target, _ in seen}):
            raise UsageError(f"--parameter {p.name}: {p.target} is fitted twice.")
        seen.add((p.target, p.flight))
        for k, file in enumerate(files):
            if p.flight in (None, k) and p.target in driven[k]:
                raise UsageError(f"--parameter {p.name}: {file} has a column that drives {p.target}.")
            if p.flight is None and p.target in {known.full(w.partition("=")[0]) for w in own[k]}:
                raise UsageError(f"--parameter {p.name}: --set {file}:{p.target} sets it for one flight.")
