"""The distributions of a campaign file: their fields, and the value at a probability. `docs/campaigns.md` lists them.

Values are computed one at a time: a vectorised function may round differently at the end of an array, and then a run's
draws would depend on the task that it is in.
"""
import math
from fractions import Fraction
from functools import lru_cache
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator, Field, field_validator, model_validator

from ..errors import did_you_mean
from ..fields import Exact, Finite, Positive, Strict, exact
from ..master.system import Value

Whole = Annotated[int, Field(strict=True)]  # neither 1.0 nor true


class Distribution(Strict):
    """What all distributions can do."""
    distribution: str

    @property
    def ends(self) -> tuple[float | None, float | None]:
        """`low` and `high`, as far as it has them."""
        return getattr(self, "low", None), getattr(self, "high", None)

    @model_validator(mode="after")
    def ascending_ends(self) -> "Distribution":
        low, high = self.ends
        if low is not None and high is not None and not low < high:
            raise ValueError("low must be below high")
        return self

    @property
    def single(self) -> bool:
        """Whether the values are single ones, which a whole number or a truth can take."""
        return False

    @property
    def ordered(self) -> bool:
        """Whether the value rises with the probability, so that draws can be correlated."""
        return True

    def quantile(self, u: float) -> Value:
        """The value at the probability `u`, from 0 to 1."""
        raise NotImplementedError

    def extremes(self) -> list[Value]:
        """Values that must be allowed: both ends if it has both; else the middle."""
        low, high = self.ends
        return [self.quantile(0.5)] if low is None or high is None else [low, high]

    def levels(self) -> list[Value]:
        """The values in a grid. Raises ValueError for a distribution that has none."""
        raise ValueError("a grid takes values, or low, high and points")


class Uniform(Distribution):
    """Between `low` and `high`; in a grid at `points` values that lie evenly, ends included."""
    distribution: Literal["uniform"]
    low: Finite
    high: Finite
    points: Annotated[Whole, Field(ge=2, le=100_000)] | None = None

    @property
    def single(self) -> bool:
        """Whether it is for a grid."""
        return self.points is not None

    def quantile(self, u: float) -> Value:
        """The value at the probability `u`."""
        return self.low + u * (self.high - self.low)

    def extremes(self) -> list[Value]:
        """The ends, or the points of a grid."""
        return [self.low, self.high] if self.points is None else self.levels()

    def levels(self) -> list[Value]:
        """Each is the double nearest to the decimal: 0.2 to 0.6 at 9 points has 0.3, not 0.30000000000000004."""
        if self.points is None:
            raise ValueError("points is missing, which a grid needs beside low and high")
        low, high = Fraction(repr(self.low)), Fraction(repr(self.high))
        return [float(low + (high - low) * i / (self.points - 1)) for i in range(self.points)]


class Integer(Distribution):
    """A whole number from `low` to `high`, each equally likely."""
    distribution: Literal["integer"]
    low: Annotated[Whole, Field(ge=-2**53, le=2**53)]
    high: Annotated[Whole, Field(ge=-2**53, le=2**53)]

    @property
    def single(self) -> bool:
        """It is."""
        return True

    def quantile(self, u: float) -> Value:
        """The value at the probability `u`."""
        return float(self.low + min(math.floor(u * (self.high - self.low + 1)), self.high - self.low))

    def extremes(self) -> list[Value]:
        """The ends."""
        return [float(self.low), float(self.high)]

    def levels(self) -> list[Value]:
        """All of them. Raises ValueError if these are more than a million."""
        if self.high - self.low >= 1_000_000:
            raise ValueError("a grid takes at most 1,000,000 values of one variable")
        return [float(i) for i in range(self.low, self.high + 1)]


class Normal(Distribution):
    """Cut off at `low` and `high` where these are given."""
    distribution: Literal["normal"]
    mean: Finite
    std: Positive
    low: Finite | None = None
    high: Finite | None = None

    def quantile(self, u: float) -> Value:
        """The value at the probability `u`."""
        return normal(u, self.mean, self.std, self.low, self.high)


class LogNormal(Distribution):
    """Its logarithm is normal, with standard deviation `sigma` about the logarithm of `median`, before it is cut off at
    `low` and `high` where these are given."""
    distribution: Literal["log-normal"]
    median: Positive
    sigma: Positive
    low: Positive | None = None
    high: Positive | None = None

    def quantile(self, u: float) -> Value:
        """The value at the probability `u`."""
        low, high = (None if x is None else math.log(x / self.median) for x in (self.low, self.high))
        found = self.median * math.exp(normal(u, 0.0, self.sigma, low, high))
        return within(found, self.low, self.high)


class Triangular(Distribution):
    """From `low` to `high`, most likely at `mode`."""
    distribution: Literal["triangular"]
    low: Finite
    mode: Finite
    high: Finite

    @model_validator(mode="after")
    def checked(self) -> "Triangular":
        if not self.low <= self.mode <= self.high:
            raise ValueError("mode must lie between low and high")
        return self

    def quantile(self, u: float) -> Value:
        """The value at the probability `u`."""
        width, rise, fall = self.high - self.low, self.mode - self.low, self.high - self.mode
        found = self.low + math.sqrt(u * width * rise) if u * width < rise \
            else self.high - math.sqrt((1 - u) * width * fall)
        return within(found, self.low, self.high)


class Choice(Distribution):
    """One of `values`, equally likely or by `weights`."""
    distribution: Literal["choice"]
    values: list[Annotated[bool | Finite | str, BeforeValidator(exact)]] = Field(min_length=1)
    weights: list[Annotated[float, Field(ge=0, allow_inf_nan=False)]] | None = None

    @model_validator(mode="after")
    def checked(self) -> "Choice":
        if self.weights is not None and (len(self.weights) != len(self.values) or not 0 < sum(self.weights) < math.inf):
            raise ValueError("weights must be one for each of values, with a finite sum above 0")
        if len({str if isinstance(v, str) else bool if isinstance(v, bool) else float for v in self.values}) > 1:
            raise ValueError("values must be all numbers, all truths or all words")
        return self

    @property
    def single(self) -> bool:
        """It is."""
        return True

    @property
    def ordered(self) -> bool:
        """It is not: the values stand as in the file."""
        return False

    def quantile(self, u: float) -> Value:
        """The value at the probability `u`, in the order of the file."""
        weights = np.cumsum([1.0] * len(self.values) if self.weights is None else self.weights)
        return self.values[min(int(np.searchsorted(weights, u * weights[-1], side="right")), len(self.values) - 1)]

    def extremes(self) -> list[Value]:
        """All values that can be drawn."""
        return [v for v, w in zip(self.values, self.weights or [1.0] * len(self.values)) if w > 0]

    def levels(self) -> list[Value]:
        """The values. Raises ValueError where they have weights, or one is there twice."""
        if self.weights is not None:
            raise ValueError("weights mean nothing in a grid: each value is flown as often as the others")
        if len(set(self.values)) < len(self.values):
            raise ValueError("a value is given twice")
        return list(self.values)


class Empirical(Distribution):
    """Measured numbers: `values`, or the `column` of a `file`, all equally likely; if `interpolated`, straight lines
    join them (numpy's quantiles by the method `linear`)."""
    distribution: Literal["empirical"]
    values: list[Exact] = Field(default=[], max_length=1_000_000)
    file: str | None = None
    column: str | None = None
    interpolated: bool = False

    @field_validator("values")
    @classmethod
    def ascending(cls, value: list[float]) -> list[float]:
        return sorted(value)

    @model_validator(mode="after")
    def checked(self) -> "Empirical":
        if bool(self.values) == (self.file is not None) or (self.file is None) != (self.column is None):
            raise ValueError("either values, or a file and its column, is wanted")
        return self

    @property
    def single(self) -> bool:
        """Whether the values are taken as they are."""
        return not self.interpolated

    def quantile(self, u: float) -> Value:
        """The value at the probability `u`."""
        last = len(self.values) - 1
        if not self.interpolated:
            return self.values[min(int(u * (last + 1)), last)]
        i = min(int(u * last), max(last - 1, 0))
        a, b = self.values[i], self.values[min(i + 1, last)]
        return min(max(a + (u * last - i) * (b - a), a), b)

    def extremes(self) -> list[Value]:
        """All values, or the ends where they are interpolated."""
        return [self.values[0], self.values[-1]] if self.interpolated else list(dict.fromkeys(self.values))


class Scipy(Distribution):
    """The distribution `name` of scipy.stats with its `parameters`; cut off at `low` and `high` where given."""
    distribution: Literal["scipy"]
    name: str
    parameters: dict[str, Finite] = Field(default={})
    low: Finite | None = None
    high: Finite | None = None

    @model_validator(mode="after")
    def checked(self) -> "Scipy":
        check_parameters(self.name, self.parameters)
        if self.low is not None or self.high is not None:
            below, above = self.cut
            if not (below[1] > below[0] or above[0] > above[1]):
                raise ValueError(f"{self.name} has no values between low and high")
        return self

    @property
    def single(self) -> bool:
        """Whether it is a distribution of whole numbers."""
        return hasattr(scipy_distribution(self.name), "pmf")

    @property
    def cut(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """The probabilities to be below `low` and up to `high`; those to be above."""
        return cut_at(self.name, tuple(self.parameters.items()), self.low, self.high)

    def quantile(self, u: float) -> Value:
        """The value at the probability `u`."""
        one = frozen(self.name, tuple(self.parameters.items()))
        if self.low is None and self.high is None:
            return float(one.ppf(u))
        below, above = ((1 - u) * a + u * b for a, b in self.cut)  # the smaller one has all its digits
        return within(float(one.ppf(below) if below < above else one.isf(above)), self.low, self.high)

    def extremes(self) -> list[Value]:
        """Both ends if it has both; else the middle."""
        ends = frozen(self.name, tuple(self.parameters.items())).support()
        low, high = (within(float(x), self.low, self.high) for x in ends)
        return [low, high] if math.isfinite(low) and math.isfinite(high) else [self.quantile(0.5)]


class Given(Distribution):
    """A column of the campaign's samples: nothing is drawn."""
    distribution: Literal["samples"] = "samples"
    file: str
    values: list[Value] = Field(exclude=True, description="that must be allowed")

    @property
    def single(self) -> bool:
        """It is: whole numbers are checked in the file."""
        return True

    @property
    def ordered(self) -> bool:
        """It is not: a row stays as it is."""
        return False

    def extremes(self) -> list[Value]:
        """The least and the greatest number, or all words."""
        return self.values


def within(x: float, low: float | None, high: float | None) -> float:
    """`x`, which rounding has not led out of `low` ... `high`."""
    return min(max(x, -math.inf if low is None else low), math.inf if high is None else high)


def normal(u: float, mean: float, std: float, low: float | None, high: float | None) -> float:
    """The value of a normal distribution that is cut off at `low` and `high` at the probability `u`."""
    if low is high is None:
        from scipy.special import ndtri

        return mean + std * float(ndtri(u))
    a, b = -math.inf if low is None else low, math.inf if high is None else high
    if u in (0.0, 1.0):
        return b if u else a
    from scipy.stats import truncnorm  # accurate in both tails, however far out; slow to import

    return min(max(float(truncnorm.ppf(u, (a - mean) / std, (b - mean) / std, mean, std)), a), b)


def scipy_distribution(name: str) -> Any:
    """The univariate distribution of that name. Raises ValueError if scipy.stats has none."""
    from scipy import stats

    found = getattr(stats, name, None)
    if not isinstance(found, stats.rv_continuous | stats.rv_discrete):
        known = [n for n in dir(stats) if isinstance(getattr(stats, n), stats.rv_continuous | stats.rv_discrete)]
        raise ValueError(f"scipy.stats has no distribution {name}{did_you_mean(name, known)}")
    return found


def check_parameters(name: str, parameters: dict[str, float]) -> None:
    """Raises ValueError for parameters that are missing, unknown, or that the distribution does not allow."""
    one = scipy_distribution(name)
    shapes = [word.strip() for word in (one.shapes or "").split(",") if word.strip()]
    known = [*shapes, "loc", *(() if hasattr(one, "pmf") else ("scale",))]
    for word in parameters:
        if word not in known:
            raise ValueError(f"{name} has no parameter {word}; there are {', '.join(known)}")
    if missing := [word for word in shapes if word not in parameters]:
        raise ValueError(f"{name} needs the parameter {missing[0]}")
    if any(map(math.isnan, one(**parameters).support())):
        given = ", ".join(f"{word} = {value:g}" for word, value in parameters.items())
        raise ValueError(f"{name} does not allow {given}")


@lru_cache(256)
def frozen(name: str, parameters: tuple[tuple[str, float], ...]) -> Any:
    """A distribution with its parameters; slow to make."""
    return scipy_distribution(name)(**dict(parameters))


@lru_cache(256)
def cut_at(name: str, parameters: tuple[tuple[str, float], ...], low: float | None, high: float | None
           ) -> tuple[tuple[float, float], tuple[float, float]]:
    """The probabilities to be below `low` and up to `high`; those to be from `low` and above `high`."""
    one = frozen(name, parameters)
    before = -math.inf if low is None else math.ceil(low) - 1 if hasattr(one.dist, "pmf") else low
    ends = before, math.inf if high is None else high
    below, above = ([float(f(x)) for x in ends] for f in (one.cdf, one.sf))
    return (below[0], below[1]), (above[0], above[1])


Scalar = Annotated[Uniform | Integer | Normal | LogNormal | Triangular | Choice | Empirical | Scipy,
                   Field(discriminator="distribution")]
