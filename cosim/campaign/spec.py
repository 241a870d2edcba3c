"""The campaign file's models. `docs/campaigns.md` says it in words."""
import math
import re
from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, Field, field_validator, model_validator

from .. import names
from ..fields import Finite, Name, Positive, Setting, Strict
from ..master.measures import parse
from .distributions import (
    Choice,
    Empirical,
    Integer,
    LogNormal,
    Normal,
    Scalar,
    Scipy,
    Triangular,
    Uniform,
    Whole,
)

Readable = Annotated[str, AfterValidator(lambda text: parse(text).text)]  # an expression


def metric_name(text: str) -> str:
    """`text` itself. Raises ValueError if it is no name that expressions can have without quotes."""
    if not re.fullmatch(r"[^\W\d]\w*(\.[^\W\d]\w*)*", text):
        raise ValueError(f"{text!r} is no name for a metric: it must have letters, digits and _, begin with a letter "
                         "or _, and may have dots between such words")
    return text


MetricName = Annotated[str, AfterValidator(metric_name)]


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


class Signals(Strict):
    """Whose signals are kept: of a share of the runs, and of the failures."""
    share: float = Field(default=0.0, ge=0, le=1)
    failures: bool | int = False
    record: list[str] = Field(default=[], description="component.variable, * for any; none: what metrics need")
    decimate: Whole = Field(default=10, ge=1)

    @field_validator("failures", mode="before")
    @classmethod
    def truth_or_number(cls, value: Any) -> Any:
        if not isinstance(value, int) or value < 0:
            raise ValueError("true, false or a whole number is wanted")
        return value

    @property
    def most_failures(self) -> float:
        """Of how many failures of each law signals are kept."""
        return math.inf if self.failures is True else int(self.failures)


class StopWhen(Strict):
    """Ends a campaign when the interval of a probability is narrow enough, for all laws; see `sequential`."""
    probability: str = "success"
    half_width: float = Field(gt=0, lt=0.5)
    confidence: float = Field(default=0.95, gt=0, lt=1)

    @property
    def column(self) -> str:
        """The column of runs.parquet with what the probability is of."""
        return "success" if self.probability == "success" else f"success.{self.probability}"


class Rare(Strict):
    """Flies towards a failure that is too rare for plain sampling, level by level; see `rare`."""
    failure: str | None = Field(default=None, description="a name of success; else all of them together")
    method: Literal["subset-simulation", "cross-entropy"] = "subset-simulation"
    runs_per_level: Whole = Field(default=1000, ge=100, le=1_000_000, multiple_of=10)
    most_levels: Whole = Field(default=10, ge=1, le=100)

    @property
    def most_runs(self) -> int:
        """Of all levels."""
        return self.runs_per_level * self.most_levels


class Named(Strict):
    """What a campaign is called."""
    name: Annotated[str, AfterValidator(names.checked)]


class Campaign(Named):
    """What a campaign file may say, whatever its subject is; the subject's own fields are added to it."""
    step: Positive | None = Field(default=None, description="s; else the subject's, as stop and algorithm")
    stop: Positive | None = None
    algorithm: str | None = None
    set: dict[Name, Setting] = Field(default={})
    runs: Whole = Field(default=0, ge=1, le=100_000_000, description="else all of the samples, or of the grid")
    seed: Whole = Field(default=0, ge=0, lt=2**63, description="required where something is drawn")
    sampling: Literal["random", "latin-hypercube", "sobol", "grid"] = "random"
    samples: str | None = Field(default=None, description="a .csv or .parquet file: a column a variable, a row a run")
    dispersions: dict[Name, Dispersion] = Field(default={}, min_length=1)
    correlations: list[Correlation] = Field(default=[])
    metrics: dict[MetricName, Readable] = Field(default={}, description="expressions; columns of runs.parquet")
    success: dict[str, Readable] = Field(default={}, min_length=1, description="besides reaching the end")
    worst_by: str | None = Field(default=None, description="a metric; else the first that success names")
    signals: Signals = Signals()
    rare: Rare | None = None
    stop_when: StopWhen | None = None
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
        """Nothing is missing that is wanted only in some campaigns."""
        grid, own = self.sampling == "grid", self.samples is not None
        for missing, field in ((not self.runs and not grid and not own, "runs"),
                               (not self.dispersions and not own, "dispersions"),
                               ("seed" not in self.model_fields_set and not grid and self.dispersions, "seed"),
                               (not self.success and not grid, "success")):
            if missing:
                raise ValueError(f"{field} is missing")
        return self

    def out_of_place(self) -> Iterator[tuple[str, str]]:
        """Fields that do not fit others, and why."""
        if self.rare and self.samples is not None:
            yield "samples", "rare chooses its own points: samples does not belong here"
        if self.sampling == "grid" and self.samples is not None:
            yield "samples", "a grid takes no samples"
        elif self.samples is not None and not self.dispersions and self.sampling != "random":
            yield "sampling", "samples without dispersions draw nothing: leave sampling out"
        if self.sampling == "grid" and self.correlations:
            yield "correlations", "a grid takes no correlations"

    @model_validator(mode="before")
    @classmethod
    def runs_of_levels(cls, given: Any) -> Any:
        """Runs that the levels make at most, where the file says none."""
        if not isinstance(given, dict) or given.get("rare") is None or "runs" in given:
            return given
        try:
            return {**given, "runs": Rare.model_validate(given["rare"]).most_runs}
        except ValueError:  # what is wrong with it is said at its own place
            return {**given, "runs": 1}


def with_distribution(one: Any) -> Any:
    """A dispersion of a grid with its distribution: `values` are a choice, `points` lie evenly."""
    if not isinstance(one, dict) or "distribution" in one:
        return one
    return {"distribution": "choice" if "values" in one else "uniform", **one}
