"""The probability of a rare failure, from far fewer runs than plain sampling needs.

The uncertain numbers are points of the standard normal space, and each point has a margin: a failure is a margin of at
most 0. Both methods go there by levels. Of the runs of a level the tenth with the least margin gives the next threshold.

    subset-simulation   Markov chains fill what lies below the threshold (Au and Beck, 2001); the probability is the
                        product of the levels' shares
    cross-entropy       a normal distribution is fitted to what lies below the threshold (Rubinstein and Kroese, 2004);
                        the last level's failures are weighted by the ratio of the two densities

The algorithms are OpenTURNS's. Coefficients of variation are computed here: for subset simulation OpenTURNS 1.27 leaves
out what the first level contributes.
"""
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..errors import UsageError
from .spec import Rare

SHARE = 0.1          # of a level's runs lies below its threshold
PROPOSAL = 2.0       # width of the uniform steps of a chain, in standard deviations; OpenTURNS's own choice
FAR = 1e300          # the margin of a run that was not judged: chains do not go there
NORMAL_95 = 1.959963984540054
Margins = Callable[[int, np.ndarray], np.ndarray]  # first run, points (runs, dimensions) -> margins (runs,)


@dataclass(frozen=True)
class Level:
    """The runs first ... last - 1: the threshold that they give, and the share of the failures among them."""
    first: int
    last: int
    threshold: float
    probability: float | None   # of a margin of at most `threshold`, by all levels so far; None if not known
    failed: float               # the share of its runs that failed
    margins: tuple[float, ...]  # their least, 5 %, 50 % and 95 % quantiles


@dataclass(frozen=True)
class Estimate:
    """What the runs say of the probability of failure: None where no level reached it, for the `reason`."""
    probability: float | None
    variation: float | None     # coefficient of variation
    levels: tuple[Level, ...]
    runs: int
    reason: str = ""
    weights: np.ndarray = field(default_factory=lambda: np.empty(0))  # of the last level's runs, by cross-entropy

    @property
    def interval(self) -> tuple[float, float]:
        """About 95 %: log-normal, by the coefficient of variation."""
        if not self.probability or self.variation is None:
            return 0.0, 1.0
        spread = math.exp(NORMAL_95 * math.sqrt(math.log1p(self.variation**2)))
        return self.probability / spread, min(1.0, self.probability * spread)

    @property
    def plain_runs(self) -> float | None:
        """How many plain runs have the same coefficient of variation."""
        if not self.probability or not self.variation:
            return None
        return (1 - self.probability) / (self.probability * self.variation**2)


class NotReached(Exception):
    """No level will reach the failures; the reason."""


def library() -> Any:
    """OpenTURNS. Raises UsageError if it is not installed."""
    try:
        import openturns
    except ImportError:
        raise UsageError("rare needs OpenTURNS, which is not installed: install the extra `rare` of this package, or "
                         "openturns itself.") from None
    return openturns


class Watched:
    """The system as OpenTURNS calls it. It remembers points and margins, and ends the algorithm where it must."""

    def __init__(self, rare: Rare, dimensions: int, margins: Margins):
        self.rare, self.margins = rare, margins
        self.points, self.found = np.empty((0, dimensions)), np.empty(0)
        self.error: BaseException | None = None

    def __call__(self, sample: Any) -> list[list[float]]:
        points = np.array(sample, float)
        first = len(self.found)
        try:
            if self.error is None:
                self.check()
                new = np.clip(np.nan_to_num(self.margins(first, points), nan=-FAR), -FAR, FAR)
                self.points, self.found = np.vstack([self.points, points]), np.append(self.found, new)
                return new[:, np.newaxis].tolist()  # type: ignore[no-any-return]
        except BaseException as error:  # through OpenTURNS it would lose its type, and print a traceback
            self.error = error
        return [[FAR]] * len(points)

    def check(self) -> None:
        """Raises NotReached at the beginning of a level that would lead nowhere."""
        size, number = self.rare.runs_per_level, len(self.found) // self.rare.runs_per_level
        if len(self.found) % size or number == 0:
            return
        last, before = (np.sort(self.found[first:first + size]) for first in ((number - 1) * size, max(0, number - 2) * size))
        tenth = round(SHARE * size) - 1
        if number > 1 and last[0] == last[tenth] == before[0] == before[tenth] > 0:
            raise NotReached(f"a tenth of the runs of two levels has one and the same margin, {last[0]:.6g}, so that "
                             "it does not lead to a failure")
        if number >= self.rare.most_levels:
            raise NotReached(f"{self.rare.most_levels} levels did not reach a failure")

    def stopped(self) -> bool:
        """Whether the algorithm must end."""
        return self.error is not None

    def level(self, number: int, threshold: float, probability: float | None) -> Level:
        """A level that was flown."""
        first = number * self.rare.runs_per_level
        mine = self.found[first:first + self.rare.runs_per_level]
        return Level(first, first + len(mine), threshold, probability, float((mine <= 0).mean()),
                     tuple(float(x) for x in np.quantile(mine, (0.0, 0.05, 0.5, 0.95))))


def estimate(rare: Rare, dimensions: int, seed: int, margins: Margins) -> Estimate:
    """The probability that a margin is at most 0, where the point is standard normal.

    The same settings, seed and margins give the same estimate. Raises UsageError without OpenTURNS, and whatever
    `margins` raises.
    """
    ot = library()
    watched = Watched(rare, dimensions, margins)
    system = ot.PythonFunction(dimensions, 1, func_sample=watched)
    event = ot.ThresholdEvent(ot.CompositeRandomVector(system, ot.RandomVector(ot.Normal(dimensions))),
                              ot.LessOrEqual(), 0.0)
    subset = rare.method == "subset-simulation"
    if subset:
        algorithm = ot.SubsetSampling(event, PROPOSAL, SHARE)
        size = round(SHARE * rare.runs_per_level)  # as many chains as seeds; a larger block would only restart them
    else:
        algorithm = ot.StandardSpaceCrossEntropyImportanceSampling(event, SHARE)
        size = rare.runs_per_level
    algorithm.setBlockSize(size)
    algorithm.setMaximumOuterSampling(rare.runs_per_level // size)
    stopped = watched.stopped  # OpenTURNS does not keep it alive
    algorithm.setStopCallback(stopped)
    state, shown = ot.RandomGenerator.GetState(), ot.Log.Flags()
    ot.Log.Show(ot.Log.NONE)
    try:
        ot.RandomGenerator.SetSeed(seed % 2**32)
        algorithm.run()
    except (RuntimeError, TypeError, ValueError) as fault:  # of OpenTURNS, whatever it was
        reason = str(fault)
    else:
        reason = ""
    finally:
        ot.RandomGenerator.SetState(state)
        ot.Log.Show(shown)
    if watched.error is not None and not isinstance(watched.error, NotReached):
        raise watched.error
    reason = str(watched.error or reason)
    return by_subsets(watched, algorithm, reason) if subset else by_weights(watched, algorithm, reason)


def by_subsets(watched: Watched, algorithm: Any, reason: str) -> Estimate:
    """The estimate of subset simulation. Its variance has a part of each level, larger by the correlation of a chain's
    points; levels are taken to be independent of each other."""
    size, runs = watched.rare.runs_per_level, len(watched.found)
    thresholds, below = list(algorithm.getThresholdPerStep()), [min(1.0, p) for p in
                                                                algorithm.getProbabilityEstimatePerStep()]
    levels = tuple(watched.level(*one) for one in zip(range(runs // size), thresholds, below))
    if not reason and thresholds[-1] > 0:  # the last level has no variance: all of it failed, or nothing moved
        late = watched.found[-size:]
        if not (late <= 0).any() or ((late > 0) & (late <= thresholds[-1])).any():
            reason = "all runs of a level have one and the same margin, so that it does not lead to a failure"
    if reason:
        return Estimate(None, None, levels, runs, reason)
    shares = np.array(below) / np.array([1.0, *below[:-1]])
    correlated = 1 + np.maximum(np.array(algorithm.getGammaPerStep()), 0.0)
    return Estimate(below[-1], float(np.sqrt(np.sum((1 - shares) / (shares * size) * correlated))), levels, runs)


def by_weights(watched: Watched, algorithm: Any, reason: str) -> Estimate:
    """The estimate of cross-entropy: the mean of the last level's weights, where those of successes are 0."""
    size, runs = watched.rare.runs_per_level, len(watched.found)
    thresholds = list(algorithm.getThresholdPerStep())
    if reason:
        return Estimate(None, None, tuple(watched.level(i, t, None) for i, t in enumerate(thresholds)), runs, reason)
    points, failed = watched.points[-size:], watched.found[-size:] <= 0
    ot, fitted = library(), algorithm.getResult().getAuxiliaryDistribution()
    logs = np.array(ot.Normal(points.shape[1]).computeLogPDF(points)) - np.array(fitted.computeLogPDF(points))
    weights = np.exp(logs[:, 0])
    counted = np.where(failed, weights, 0.0)
    p = float(counted.mean())
    if p == 0:
        return Estimate(None, None, (), runs, "all weights of the last level vanish")
    levels = tuple(watched.level(i, t, p if t <= 0 else None) for i, t in enumerate(thresholds))
    return Estimate(p, float(counted.std(ddof=1) / math.sqrt(size) / p), levels, runs, weights=weights)
