"""What a model is, and its table of variables made into records.

A model is a module with
    NAME, DESCRIPTION      identifier and one line of text
    VARIABLES              rows (name, causality, unit, start, min, max, nominal, description);
                           angles in rad, and shown in degrees; "rad/s frequency" is the unit rad/s of what is no
                           rate of an angle, and shown as it is; "Pa in bar" is shown in bar; "1 discrete" makes a
                           Real that changes at the end of steps only, such as a flag, 0 or 1; the unit "" makes a
                           Boolean, every other a Real
    UNITS                  optional: name -> (how many, of which unit), units beside those of `fmus.units`
    PRESETS                name -> {parameter: value}
    AUTHOR, COPYRIGHT,     optional: lines of text for the FMU's description; without them it says nothing of them
    LICENSE, VERSION
    TERMINALS              optional: name -> names of the inputs and outputs that belong together on a connection
    start(m, u, p) -> x                    initial state, a list of floats, from inputs and parameters
    outputs(m, t, x, u, p) -> {name: value}   every output and calculated parameter of the table
and, where there is a state, one of the two, or both:
    derivative(m, t, x, u, p) -> rates     dx/dt of the first len(STATES) entries of x, per second; the further entries
                                           are memories, which do not change
    advance(m, t, h, x, u, p, c) -> x      the state h seconds later, with the inputs held
    prepare(m, p, h) -> c                  optional: numbers that `advance` needs, of parameters and step only
where m is the mathematics backend (`fmus.floats` or `fmus.symbols`) and u, p have the inputs and the
parameters as attributes.

Beside `derivative` stands
    STATES                 an entry for each rate: the name of the output that shows this very state, or a row with
                           the causality "local" for a state that is no output
    ORDER                  optional, 1, 2, 4 or 6: the method of `fmus.integrators` that integrates `derivative` where
                           there is no `advance`; else 4

A model is advanced in equal steps of at most its parameter `internal_step`, where it has one. A model with a parameter
`sample_time` is a discrete law: it runs `advance` with that h, and then `outputs`, at the start time and at each
multiple of `sample_time` after it, whatever the communication step, and its outputs are held in between (see
`fmus.functions`). The range of an output is where the model is valid, the range of an input where it can start.

`fmus.check_model` finds the mistakes of a model before it becomes an FMU; nothing here looks for them.
"""
from dataclasses import dataclass, replace
from math import ceil
from types import ModuleType

from .units import DEGREES, si_base

COLUMNS = ("name", "causality", "unit", "start", "min", "max", "nominal", "description")
CAUSALITIES = ("input", "output", "calculatedParameter", "parameter")
ORIGIN = ("VERSION", "AUTHOR", "COPYRIGHT", "LICENSE")  # optional parts of a model
GIVEN = ("input", "parameter")  # these have a start value, the others are computed
ROUNDING = 1e-9  # of an internal step: 10 ms in steps of 1 ms are 10, not 11

Row = tuple[str, str, str, float | bool | None, float | None, float | None, float | None, str]


@dataclass(frozen=True)
class Variable:
    """One row of a model's table; `value_reference` is its place in the table."""
    name: str
    causality: str
    unit: str
    start: float | bool | None
    minimum: float | None
    maximum: float | None
    nominal: float | None
    description: str
    value_reference: int
    display_unit: str | None  # the unit that people read, deg for rad; None where it is `unit`
    discrete: bool = False    # changes at the end of communication steps only
    derivative_of: str | None = None  # the continuous state that this is the rate of (see `fmus.references`)

    @property
    def type(self) -> str:
        """The FMI type, Real or Boolean."""
        return "Real" if self.unit else "Boolean"

    @property
    def factor(self) -> float:
        """How many of its display unit one of its unit is."""
        if self.display_unit in (None, self.unit.replace("rad", "deg")):
            return DEGREES if self.display_unit else 1.0
        return si_base(self.unit)[0] / si_base(str(self.display_unit))[0]

    @property
    def unit_suffix(self) -> str:
        """What follows a number of this variable in a sentence: " deg", or nothing for a plain number."""
        return "" if self.unit in ("", "1") else f" {self.display_unit or self.unit}"

    def displayed(self, value: float) -> float:
        """A value of this variable in its display unit."""
        return value * self.factor if self.display_unit else value


def record(row: Row, value_reference: int) -> Variable:
    """A row of a table, which stands at `value_reference`, as a record."""
    name, causality, unit, start, low, high, nominal, description = row
    unit, _, kind = unit.partition(" ")
    shown = unit.replace("rad", "deg") if unit.startswith("rad") and kind != "frequency" else None
    if kind.startswith("in "):
        shown = kind.removeprefix("in ")
    return Variable(name, causality, unit, start, low, high, nominal, description, value_reference, shown,
                    kind == "discrete" or not unit)


def variables(rows: list[Row]) -> list[Variable]:
    """The table of a model (its VARIABLES) as records, in the table's order."""
    table = [record(row, i) for i, row in enumerate(rows)]
    sampled = sample_time(table) is not None
    return [replace(v, discrete=True) if sampled and v.causality == "output" else v for v in table]


def sample_time(table: list[Variable]) -> float | None:
    """The time between the instants of a discrete law, s, as its parameter starts; None for other models."""
    return next((v.start for v in table if v.name == "sample_time" and v.causality == "parameter"), None)


def longest_step(table: list[Variable]) -> str | None:
    """The name of the parameter that no internal step is longer than, None where there is none."""
    return next((name for name in names(table, "parameter") if name in ("internal_step", "sample_time")), None)


def states(model: ModuleType) -> list[Variable]:
    """The continuous states of `model`, in the order of its STATES: rows of its table, and local variables, whose value
    references go on after the table's."""
    table = {v.name: v for v in variables(model.VARIABLES)}
    found, place = [], len(table)
    for entry in getattr(model, "STATES", []):
        if isinstance(entry, str):
            found.append(table[entry])
        else:
            found.append(record(entry, place))
            place += 1
    return found


def names(table: list[Variable], *causalities: str) -> list[str]:
    """Names of the variables of these causalities, in the table's order."""
    return [v.name for v in table if v.causality in causalities]


def computed(table: list[Variable]) -> list[str]:
    """Names of what `outputs` returns, in the table's order."""
    return names(table, "output", "calculatedParameter")


def internal_steps(step: float, longest: float) -> int:
    """How many equal internal steps of at most `longest` seconds a communication step of `step` seconds takes."""
    return max(1, ceil(step / longest - ROUNDING))
