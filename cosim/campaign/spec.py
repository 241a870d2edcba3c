"""The campaign file's models. `docs/campaigns.md` says it in words."""
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, Field, field_validator, model_validator

from .. import names
from ..vehicle.closed_loop import law_name
from .criteria import Criterion
from .distributions import (
    Choice,
    Empirical,
    Finite,
    Integer,
    LogNormal,
    Normal,
    Positive,
    Scalar,
    Scipy,
    Strict,
    Triangular,
    Uniform,
    Whole,
)

Name = Annotated[str, Field(pattern=r"^\w+\.[^\s=]+$")]  # component.variable


class Sinusoid(Strict):
    """amplitude * sin(2 pi t / period + phase) on a scenario signal; each a number or a distribution."""
    distribution: Literal["sinusoid"]
    amplitude: Finite | Scalar
    period: Positive | Scalar
    phase: Finite | Scalar = Uniform(distribution="uniform", low=0.0, high=6.283185307179586)

    @field_validator("amplitude", "period", "phase", mode="before")
    @classmethod
    def number_or_distribution(cls, value: Any) -> Any:
        if not isinstance(value, dict | int | float | BaseModel) or isinstance(value, bool):
            raise ValueError("a number, or a distribution, is wanted")
        return value


class Options(Strict):
    """What every dispersed distribution may also say."""
    relative: bool = Field(default=False, description="the draw multiplies the nominal value")
    also: list[Name] = Field(default=[], description="variables that are set to the same value")


class DispersedUniform(Uniform, Options):
    """A uniform dispersion."""


class DispersedInteger(Integer, Options):
    """A dispersion with whole numbers."""


class DispersedNormal(Normal, Options):
    """A normal dispersion."""


class DispersedLogNormal(LogNormal, Options):
    """A log-normal dispersion."""


class DispersedTriangular(Triangular, Options):
    """A triangular dispersion."""


class DispersedChoice(Choice, Options):
    """A dispersion with given values."""

    @model_validator(mode="after")
    def numbers(self) -> "DispersedChoice":
        if self.relative and not all(isinstance(v, float) for v in self.values):
            raise ValueError("relative needs values that are numbers")
        return self


class DispersedEmpirical(Empirical, Options):
    """A dispersion with numbers that were measured."""


class DispersedScipy(Scipy, Options):
    """A dispersion by one of scipy's distributions."""


Dispersion = Annotated[DispersedUniform | DispersedInteger | DispersedNormal | DispersedLogNormal | DispersedTriangular
                       | DispersedChoice | DispersedEmpirical | DispersedScipy | Sinusoid,
                       Field(discriminator="distribution")]


class Correlation(Strict):
    """A Gaussian copula over draws: one coefficient for every pair, or a whole matrix."""
    draws: list[Name] = Field(min_length=2)
    coefficient: float | None = Field(default=None, ge=-1, le=1)
    matrix: list[list[float]] | None = None

    @model_validator(mode="after")
    def one_of_them(self) -> "Correlation":
        if (self.coefficient is None) == (self.matrix is None):
            raise ValueError("either coefficient or matrix is wanted")
        if len(set(self.draws)) < len(self.draws):
            raise ValueError("draws must differ")
        return self


class Law(Strict):
    """A controller to fly, by a word or as NAME=FILE.fmu; `name` tells two presets of one law apart."""
    law: str
    preset: str | None = Field(default=None, description="else the scenario's, or the law's own")
    name: str = ""
    set: dict[Name, Finite | bool | str] = Field(default={})

    @field_validator("name")
    @classmethod
    def is_name(cls, value: str) -> str:
        return names.checked(value) if value else value


class Signals(Strict):
    """Whose signals are kept: of a share of the runs, and of the failures."""
    share: float = Field(default=0.0, ge=0, le=1)
    failures: bool = False
    record: list[str] = Field(default=[], description="component.variable, * for any; none: what metrics need")
    decimate: Whole = Field(default=10, ge=1)


class Campaign(Strict):
    """What a campaign file may say."""
    name: Annotated[str, AfterValidator(names.checked)]
    scenario: str
    controllers: list[Law] = Field(default=["neural"], min_length=1, validate_default=True)  # type: ignore[list-item]
    presets: dict[str, str] = Field(default={}, description="of other components")
    plant: str = "ideal"
    flavour: str = "native"
    step: Positive = 0.01
    stop: Positive | None = None
    algorithm: str = "gauss-seidel"
    set: dict[Name, Finite | bool | str] = Field(default={})
    runs: Whole = Field(default=0, ge=1, le=100_000_000, description="else all of the samples, or of the grid")
    seed: Whole = Field(default=0, ge=0, lt=2**63, description="required where something is drawn")
    sampling: Literal["random", "latin-hypercube", "sobol", "grid"] = "random"
    samples: str | None = Field(default=None, description="a .csv or .parquet file: a column a variable, a row a run")
    dispersions: dict[Name, Dispersion] = Field(default={})
    correlations: list[Correlation] = Field(default=[])
    success: dict[str, Criterion] = Field(min_length=1, description="besides reaching the end")
    worst_by: str | None = Field(default=None, description="a metric; else the first that success names")
    signals: Signals = Signals()
    timeout_s: Positive = 60.0
    runs_per_task: Whole | None = Field(default=None, ge=1)

    @model_validator(mode="before")
    @classmethod
    def gridded(cls, data: Any) -> Any:
        """In a grid a dispersion need not say its distribution."""
        if not isinstance(data, dict) or data.get("sampling") != "grid" or not isinstance(
                given := data.get("dispersions"), dict):
            return data
        return {**data, "dispersions": {name: with_distribution(one) for name, one in given.items()}}

    @model_validator(mode="after")
    def enough(self) -> "Campaign":
        """Nothing is missing that is wanted only where something is drawn."""
        free = self.samples is not None or self.sampling == "grid"
        for field, missing in (("runs", not self.runs and not free), ("dispersions", not self.dispersions
                                                                      and self.samples is None),
                               ("seed", "seed" not in self.model_fields_set and bool(self.dispersions)
                                and self.sampling != "grid")):
            if missing:
                raise ValueError(f"{field} is missing")
        return self

    @field_validator("controllers", mode="before")
    @classmethod
    def words(cls, value: Any) -> Any:
        return [{"law": item} if isinstance(item, str) else item for item in value] if isinstance(value, list) \
            else value

    @field_validator("controllers")
    @classmethod
    def named(cls, value: list[Law]) -> list[Law]:
        found = [law if law.name else law.model_copy(update={"name": law_name(law.law)}) for law in value]
        called = [law.name for law in found]
        for name in called:
            if called.count(name) > 1:
                raise ValueError(f"two controllers are called {name}: give each a name of its own")
        return found


def with_distribution(one: Any) -> Any:
    """A dispersion of a grid with its distribution: `values` are a choice, `points` lie evenly."""
    if not isinstance(one, dict) or "distribution" in one:
        return one
    return {"distribution": "choice" if "values" in one else "uniform", **one}
