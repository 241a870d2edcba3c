"""What a model is, and its table of variables made into checked records.

A model is a module with
    NAME, DESCRIPTION      identifier and one line of text
    VARIABLES              rows (name, causality, unit, start, min, max, nominal, description);
                           angles in rad, and shown in degrees; "rad/s frequency" is the unit rad/s of what is no
                           rate of an angle, and shown as it is; the unit "" makes a Boolean, every other a Real
    PRESETS                name -> {parameter: value}
    start(m, u, p) -> x                    initial state, a list of floats, from inputs and parameters
    advance(m, t, h, x, u, p, c) -> x      the state h seconds later, with the inputs held
    outputs(m, t, x, u, p) -> {name: value}   every output and calculated parameter of the table
    prepare(m, p, h) -> c                  optional: numbers that depend on parameters and step only
where m is the mathematics backend (`fmus.floats` or `fmus.symbols`) and u, p have the inputs and the
parameters as attributes. A model with a parameter `internal_step` is advanced in equal steps no longer
than that; the range of an output is where the model is valid.
"""
from dataclasses import dataclass

CAUSALITIES = ("input", "output", "calculatedParameter", "parameter")


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

    @property
    def type(self) -> str:
        return "Real" if self.unit else "Boolean"


def record(row, value_reference: int) -> Variable:
    name, causality, unit, *rest = row
    unit, _, kind = unit.partition(" ")
    shown = unit.replace("rad", "deg") if unit.startswith("rad") and kind != "frequency" else None
    return Variable(name, causality, unit, *rest, value_reference, shown)  # type: ignore[call-arg]


def variables(rows) -> list[Variable]:
    """The table of a model as records.

    Raises ValueError naming the variable whose row contradicts itself.
    """
    table = [record(row, i) for i, row in enumerate(rows)]
    names = set()
    for v in table:
        has_start = v.start is not None
        low = v.minimum if v.minimum is not None else float("-inf")
        high = v.maximum if v.maximum is not None else float("inf")
        if v.name in names:
            raise ValueError(f"{v.name} stands twice in the table")
        if v.causality not in CAUSALITIES:
            raise ValueError(f"{v.name}: causality {v.causality!r} is none of {', '.join(CAUSALITIES)}")
        if has_start != (v.causality in ("input", "parameter")):
            raise ValueError(f"{v.name}: inputs and parameters have a start value, outputs have none")
        if has_start and not low <= v.start <= high:  # type: ignore[operator]
            raise ValueError(f"{v.name}: start {v.start} is outside [{low}, {high}]")
        names.add(v.name)
    return table


def names(table, *causalities) -> list[str]:
    return [v.name for v in table if v.causality in causalities]


def computed(table) -> list[str]:
    """Names of what `outputs` returns, in the table's order."""
    return names(table, "output", "calculatedParameter")
