"""What a campaign flies. `Subject` is all that a campaign knows of it; `SystemSubject` is that of any system's file."""
from collections.abc import Callable, Container, Mapping, Sequence, Set
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Protocol

from pydantic import AfterValidator, BaseModel, Field, field_validator

from .. import names
from ..fields import Finite, Name, Positive, Setting, Strict
from ..master.course import Course
from ..master.flight import Flight
from ..master.system import System, Value
from ..systems.load import load_system
from ..systems.words import experiment, with_fmus
from ..yaml_file import Source

if TYPE_CHECKING:
    from .spec import Campaign

Place = tuple[str | int, ...]
Measure = Callable[[Flight], Mapping[str, float | None]]
TakeCourse = Callable[[Flight, str], Course]


class Figure(Protocol):
    """What pages say of a metric."""

    @property
    def unit(self) -> str:
        """Its unit; empty where it is not known."""

    @property
    def headline(self) -> str:
        """In words, if it is one of those that variants are judged by; else empty."""


class Subject(Protocol):
    """What a campaign flies: a system in variants, with the metrics that are known of it.

    `field` is the field of the campaign file that names it, `fields` are the fields that belong to it; `column` and
    `noun` are what columns and sentences call a variant. `measure` and `course` go to the workers by pickle.
    """
    field: ClassVar[str]
    fields: ClassVar[type[BaseModel]]
    column: ClassVar[str]
    noun: ClassVar[str]
    drawn: ClassVar[tuple[str, str]]            # title and first words of what is said of `over_time`
    name: str                                   # as the report has it
    remark: str                                 # how it is flown, as the end of a sentence
    systems: Mapping[str, System]               # of each variant, with all values that are set
    places: Mapping[str, Place]                 # of each variant: where the file has it
    wires: Mapping[str, Place]                  # of each variant: the field to blame for connections that do not fit
    sets: Mapping[str, Mapping[str, Value]]     # of each variant: what the file sets of it alone
    start: float                                # s, as `stop` and `step`
    stop: float
    step: float
    algorithm: str
    tolerance: float | None
    remarks: Sequence[str]                      # what a user should know, in sentences
    said: Mapping[str, Any]                     # what campaign.json has in place of the file's fields
    metrics: Mapping[str, Figure]               # that `measure` gives
    worst_by: str | None                        # a metric of them
    over_time: Mapping[str, tuple[str, str]]    # name -> (the axis, the expression of `course`)
    measure: Measure                            # None of a metric where a flight does not have its signals
    course: TakeCourse

    def __init__(self, campaign: Any, source: Source) -> None:
        """Raises UsageError, with line and field, for what is not known or does not fit."""

    def needed(self, signals: Set[str]) -> set[str]:
        """Which of `signals` `measure` and `over_time` are computed from."""

    def command(self, variant: str) -> list[str]:
        """The words that fly a variant, but for values and folder."""

    def implied(self, variant: str, drawn: Container[str]) -> Mapping[str, Value]:
        """Values that these words have to name beside those of the campaign file, where it draws `drawn`."""


class Variant(Strict):
    """The system with other values, or with other FMUs in some places."""
    name: Annotated[str, AfterValidator(names.checked)]
    set: dict[Name, Setting] = Field(default={})
    fmus: dict[str, str] = Field(default={}, description="component -> FILE.fmu, relative to the campaign file")


class SystemFields(Strict):
    """What a campaign file may say of any system."""
    system: str = Field(description="FILE.ssp, .ssd, .yaml or .fmu, relative to the campaign file")
    variants: list[Variant] = Field(default=[], description="else one, called like the system")
    start: Finite | None = None
    tolerance: Positive | None = None
    over_time: list[str] = Field(default=[], description="component.variable: drawn over time")

    @field_validator("variants")
    @classmethod
    def differ(cls, value: list[Variant]) -> list[Variant]:
        names.distinct("variants", (variant.name for variant in value))
        return value


def nothing(flight: Flight) -> dict[str, float | None]:
    """The metrics that are known of any system."""
    return {}


def signal(flight: Flight, expression: str) -> Course:
    """As `Flight.course`."""
    return flight.course(expression)


class SystemSubject:
    """Any system: one FMU, an SSP, or a system file."""
    field: ClassVar[str] = "system"
    fields: ClassVar[type[BaseModel]] = SystemFields
    column: ClassVar[str] = "variant"
    noun: ClassVar[str] = "variant"
    drawn: ClassVar[tuple[str, str]] = "Signals over time", "Each signal"

    def __init__(self, campaign: Any, source: Source) -> None:
        asked: SystemFields = campaign
        base: Campaign = campaign
        self.folder = source.path.parent
        self.open = ExitStack()  # an SSP's FMUs are unpacked for as long as it is
        with source.at("system"):
            self.path = (self.folder / Path(asked.system).expanduser()).resolve()
            found = self.open.enter_context(load_system(self.path))
        if base.stop is None and found.system.stop is None:
            source.fail(("system",), f"{asked.system} does not say when to stop: stop is missing")
        with source.at("stop" if base.stop else "system"):
            self.start, self.stop, self.step, remarks = experiment(found, asked.start, base.stop, base.step)
        self.suggested = found.system.start  # s
        self.remarks: Sequence[str] = [*remarks, *found.remarks]
        self.algorithm = base.algorithm or found.algorithm or "gauss-seidel"
        self.tolerance = found.tolerance if asked.tolerance is None else asked.tolerance
        self.name = found.name
        variants = asked.variants or [Variant(name=found.name)]
        self.variants = {variant.name: variant for variant in variants}
        self.places: Mapping[str, Place] = {v.name: ("variants", i) if asked.variants else ("system",)
                                            for i, v in enumerate(variants)}
        self.wires: Mapping[str, Place] = self.places
        self.sets: Mapping[str, Mapping[str, Value]] = {v.name: v.set for v in variants}
        self.systems: Mapping[str, System] = {
            v.name: self.exchanged(found.system, v, base.set, source) for v in variants}
        self.remark = f", algorithm {self.algorithm}"
        self.metrics: Mapping[str, Figure] = {}
        self.worst_by: str | None = None
        self.over_time: Mapping[str, tuple[str, str]] = {name: (name, name) for name in asked.over_time}
        self.measure: Measure = nothing
        self.course: TakeCourse = signal
        self.said: Mapping[str, Any] = {
            "system": {"name": found.name, "components": {c.name: c.values for c in found.system.components},
                       "connections": [[c.source, c.target, c.factor, c.offset] for c in found.system.connections]},
            "start": self.start, "stop": self.stop, "step": self.step, "algorithm": self.algorithm,
            "tolerance": self.tolerance}

    def exchanged(self, system: System, variant: Variant, values: Mapping[str, Value], source: Source) -> System:
        """`system` with the FMUs of a variant, with `values` and with those of the variant. Raises UsageError, with
        line and field, for a component or a file that is not there."""
        for component, file in self.fmus(variant).items():
            with source.at(*self.places[variant.name], "fmus", component):
                system = with_fmus(system, {component: file})
        system = with_fmus(system, {})
        for place, given in ((), values), (self.places[variant.name], variant.set):
            for name, value in given.items():
                with source.at(*place, "set", name):
                    system = system.with_values({name: value})
        return system

    def fmus(self, variant: Variant) -> dict[str, Path]:
        """Component -> the file that a variant has there."""
        return {component: (self.folder / Path(word).expanduser()).resolve()
                for component, word in variant.fmus.items()}

    def needed(self, signals: Set[str]) -> set[str]:
        """Which of `signals` are drawn over time."""
        return {name for name in self.over_time if name in signals}

    def implied(self, variant: str, drawn: Container[str]) -> Mapping[str, Value]:
        """Nothing: the file of the system says the rest."""
        return {}

    def command(self, variant: str) -> list[str]:
        """The words that fly a variant, but for values and folder."""
        words = ["ahv", "simulate", str(self.path)]
        for component, file in self.fmus(self.variants[variant]).items():
            words += ["--fmu", f"{component}={file}"]
        if self.start or self.start != self.suggested:
            words += ["--start", repr(self.start)]
        words += ["--step", repr(self.step), "--stop", repr(self.stop), "--algorithm", self.algorithm]
        return [*words, "--tolerance", repr(self.tolerance)] if self.tolerance is not None else words
