"""Campaigns of this vehicle: a scenario, flown by one or several control laws, as `cosim.campaign` wants it."""
from collections.abc import Container, Mapping, Sequence, Set
from os.path import isfile
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from pydantic import BaseModel, Field, field_validator

from .. import names
from ..fields import Name, Setting, Strict
from ..master.system import System, Value
from ..yaml_file import Source
from . import scenarios
from .closed_loop import FLAVOURS, FOLLOWS, ClosedLoop, absolute, assignments, closed_loop, law_name, names_file
from .metrics import METRICS, OVER_TIME, measured, needed
from .registry import PLANTS
from .signals import course

if TYPE_CHECKING:
    from ..campaign.subject import Figure, Measure, TakeCourse


class Law(Strict):
    """A controller to fly, by a word or as NAME=FILE.fmu; `name` tells two presets of one law apart."""
    law: str
    preset: str | None = Field(default=None, description="else the scenario's, or the law's own")
    name: str = ""
    set: dict[Name, Setting] = Field(default={})

    @field_validator("name")
    @classmethod
    def is_name(cls, value: str) -> str:
        return names.checked(value) if value else value


class ScenarioFields(Strict):
    """What a campaign file says of a scenario's flights."""
    scenario: str
    controllers: list[Law] = Field(default=["neural"], min_length=1, validate_default=True)  # type: ignore[list-item]
    presets: dict[str, str] = Field(default={}, description="of other components")
    plant: str = "ideal"
    flavour: str = "native"

    @field_validator("controllers", mode="before")
    @classmethod
    def words(cls, value: Any) -> Any:
        return [{"law": item} if isinstance(item, str) else item for item in value] if isinstance(value, list) \
            else value

    @field_validator("controllers")
    @classmethod
    def named(cls, value: list[Law]) -> list[Law]:
        found = [law if law.name else law.model_copy(update={"name": law_name(law.law)}) for law in value]
        names.distinct("controllers", (law.name for law in found))
        return found


class Laws:
    """The closed loop of each law on one scenario."""
    field: ClassVar[str] = "scenario"
    fields: ClassVar[type[BaseModel]] = ScenarioFields
    column: ClassVar[str] = "controller"
    noun: ClassVar[str] = "law"
    drawn: ClassVar[tuple[str, str]] = "Errors over time", "Plant minus reference"

    def __init__(self, campaign: Any, source: Source) -> None:
        """Raises UsageError, with line and field, for what is not known or does not fit."""
        asked: ScenarioFields = campaign
        folder = source.path.parent
        if asked.flavour not in FLAVOURS:
            source.fail(("flavour",), f"there is no {asked.flavour}; there are {', '.join(FLAVOURS)}")
        if asked.plant not in PLANTS and not names_file(asked.plant):
            source.fail(("plant",), f"there is no {asked.plant}; there are {', '.join(PLANTS)}, or a FILE.fmu")
        with source.at("scenario"):
            self.word = beside(source.path, asked.scenario)
            self.scenario = scenarios.load(self.word)
        self.name, self.asked, self.folder = self.scenario.name, asked, folder
        self.start = 0.0
        self.stop: float = campaign.stop or self.scenario.stop
        self.step: float = campaign.step or 0.01
        self.algorithm: str = campaign.algorithm or "gauss-seidel"
        self.tolerance: float | None = None
        self.laws = {law.name: law for law in asked.controllers}
        self.loops: dict[str, ClosedLoop] = {}
        for i, law in enumerate(asked.controllers):
            with source.at("controllers", i):
                presets = {**asked.presets, **({"controller": law.preset} if law.preset else {})}
                values = assignments([f"{name}={value}" for name, value in {**campaign.set, **law.set}.items()])
                self.loops[law.name] = closed_loop(self.scenario, law.law, asked.plant, asked.flavour, presets, values,
                                                   folder=folder)
        self.places: Mapping[str, tuple[str | int, ...]] = {law: ("controllers", i) for i, law in enumerate(self.laws)}
        self.wires: Mapping[str, tuple[str | int, ...]] = dict.fromkeys(self.laws, ("plant",))
        self.sets: Mapping[str, Mapping[str, Value]] = {name: law.set for name, law in self.laws.items()}
        self.systems: Mapping[str, System] = {name: loop.system for name, loop in self.loops.items()}
        self.remark = f", flavour {asked.flavour}, plant {asked.plant}"
        self.remarks: Sequence[str] = []
        self.said: Mapping[str, Any] = {"scenario": self.scenario.model_dump(mode="json"), "step": self.step,
                                        "stop": self.stop, "algorithm": self.algorithm}
        self.metrics: Mapping[str, Figure] = METRICS
        self.worst_by: str | None = next(iter(METRICS))
        self.over_time: Mapping[str, tuple[str, str]] = OVER_TIME
        self.measure: Measure = measured
        self.course: TakeCourse = course

    def needed(self, signals: Set[str]) -> set[str]:
        """Which of `signals` the metrics are computed from."""
        return needed(signals)

    def command(self, variant: str) -> list[str]:
        """The words that fly a law, but for values and folder."""
        asked = self.asked
        presets = ",".join(f"{component}={name}" for component, name in self.loops[variant].presets.items())
        return ["ahv", "run", self.word, "--controller", absolute(self.laws[variant].law, self.folder),
                "--preset", presets, "--flavour", asked.flavour, "--plant", absolute(asked.plant, self.folder),
                "--step", repr(self.step), "--stop", repr(self.stop), "--algorithm", self.algorithm]

    def implied(self, variant: str, drawn: Container[str]) -> Mapping[str, Value]:
        """The commands of the campaign where a start is drawn: on the command line they would follow that start."""
        scenario = self.loops[variant].system.components[0]
        return {f"scenario.{command}": scenario.values[command] for command, start in FOLLOWS.items()
                if f"plant.{start}" in drawn}


def beside(path: Path, scenario: str) -> str:
    """`scenario`, or the path of the file of that name beside the campaign file at `path`."""
    file = path.parent / scenario
    return str(file.resolve()) if scenario not in scenarios.BUILT_IN and isfile(file) else scenario
