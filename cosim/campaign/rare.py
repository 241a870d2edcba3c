"""The probability of a rare failure, from far fewer runs than plain sampling needs.

The uncertain numbers are points of the standard normal space, and each point has a margin: a failure is a margin of at
most 0. Both methods go there by levels. The tenth of a level's runs with the least margins gives the next threshold.

    subset-simulation   Markov chains fill what lies below the threshold (Au and Beck, 2001); the probability is the
                        product of the levels' shares
    cross-entropy       a normal distribution is fitted to what lies below the threshold (Rubinstein and Kroese, 2004);
                        the last level's failures are weighted by the ratio of the two densities

The algorithms are OpenTURNS's. Coefficients of variation are computed here: that of OpenTURNS 1.27 leaves out what the
first level contributes, and takes the levels to be independent.
"""
import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

import numpy as np

from ..errors import UsageError
from .spec import Rare

SHARE = 0.1          # of a level's runs lies below its threshold
PROPOSAL = 2.0       # width of the uniform steps of a chain, in standard deviations; OpenTURNS's own choice
FAR = 1e300          # the margin of a run that was not judged: chains do not go there
NORMAL_95 = 1.959963984540054
# First run, points (runs, dimensions) -> margins (runs,), NaN of a run that was not judged.
Margins = Callable[[int, np.ndarray], np.ndarray]


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
    bound: float | None         # on it: as if levels were as dependent on each other as they can be
    levels: tuple[Level, ...]
    runs: int
    reason: str = ""
    points: np.ndarray = field(repr=False, default_factory=lambda: np.empty((0, 0)))  # of all runs
    margins: np.ndarray = field(repr=False, default_factory=lambda: np.empty(0))      # of all runs
    weights: np.ndarray = field(repr=False, default_factory=lambda: np.empty(0))      # of the last level, if there are

    @property
    def interval(self) -> tuple[float, float]:
        """95 %: log-normal, by the bound on the coefficient of variation."""
        if not self.probability or self.bound is None:
            return 0.0, 1.0
        spread = math.exp(NORMAL_95 * math.sqrt(math.log1p(self.bound**2)))
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


def block(rare: Rare) -> int:
    """How many runs are flown at a time. Of subset simulation it is one of each chain: with more OpenTURNS would start
    chains anew."""
    return round(SHARE * rare.runs_per_level) if rare.method == "subset-simulation" else rare.runs_per_level


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
                new = np.clip(np.nan_to_num(self.margins(first, points), nan=FAR), -FAR, FAR)
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
        late = np.sort(self.found[-2 * size:].reshape(-1, size))[:, [0, round(SHARE * size) - 1]]
        last = late[-1]
        if number > 1 and last[0] > 0 and (late == last[0]).all():
            raise NotReached(f"a tenth of the runs of two levels has one and the same margin, {last[0]:.6g}, so that "
                             "it does not lead to a failure")
        if number >= self.rare.most_levels:
            raise NotReached(f"no failure was reached within most_levels = {self.rare.most_levels}")

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
    algorithm = (ot.SubsetSampling(event, PROPOSAL, SHARE) if subset else
                 ot.StandardSpaceCrossEntropyImportanceSampling(event, SHARE))
    algorithm.setBlockSize(block(rare))
    algorithm.setMaximumOuterSampling(rare.runs_per_level // block(rare))
    stopped = watched.stopped  # OpenTURNS does not keep it alive
    algorithm.setStopCallback(stopped)
    reason = ran(algorithm, seed)
    if watched.error is not None and not isinstance(watched.error, NotReached):
        raise watched.error
    thresholds = algorithm.getThresholdPerStep()
    if watched.error is None and subset and len(thresholds) and thresholds[-1] == 0:
        reason = ""  # OpenTURNS 1.27 finds a negative variance where all of the last level failed
    reason = str(watched.error or reason or stuck(watched, thresholds[-1]))
    return (by_subsets if subset else by_weights)(watched, algorithm, reason)


def ran(algorithm: Any, seed: int) -> str:
    """Run it with random numbers of its own; what OpenTURNS says is wrong, or nothing."""
    ot = library()
    state, shown = ot.RandomGenerator.GetState(), ot.Log.Flags()
    ot.Log.Show(ot.Log.NONE)
    try:
        ot.RandomGenerator.SetSeed(seed % 2**32)
        algorithm.run()
    except (RuntimeError, TypeError, ValueError) as fault:
        return str(fault)
    finally:
        ot.RandomGenerator.SetState(state)
        ot.Log.Show(shown)
    return ""


def stuck(watched: Watched, threshold: float) -> str:
    """Why an algorithm that ended at `threshold` did not reach a failure; empty if it did.

    OpenTURNS also ends where a level has no variance: all of it failed, or all of it has the same margin.
    """
    late = watched.found[-watched.rare.runs_per_level:]
    if threshold <= 0 or ((late <= 0).any() and not ((late > 0) & (late <= threshold)).any()):
        return ""
    return "all runs of a level have one and the same margin, so that it does not lead to a failure"


def by_subsets(watched: Watched, algorithm: Any, reason: str) -> Estimate:
    """The estimate of subset simulation. The bound on its variation has a part of each level, larger by the correlation
    of a chain's points."""
    size, runs = watched.rare.runs_per_level, len(watched.found)
    below = np.minimum(np.array(algorithm.getProbabilityEstimatePerStep()), 1.0)
    levels = tuple(watched.level(i, float(t), float(p))
                   for i, (t, p) in enumerate(zip(algorithm.getThresholdPerStep(), below)))
    if reason:
        return Estimate(None, None, None, levels, runs, reason, watched.points, watched.found)
    shares = np.minimum(below / np.array([1.0, *below[:-1]]), 1.0)
    correlated = 1 + np.nan_to_num(np.maximum(np.array(algorithm.getGammaPerStep()), 0.0))
    parts = np.sqrt((1 - shares) / (shares * size) * correlated)
    return Estimate(float(below[-1]), by_families(watched.found, levels, block(watched.rare)), float(parts.sum()),
                    levels, runs, "", watched.points, watched.found)


def by_families(margins: np.ndarray, levels: tuple[Level, ...], chains: int) -> float:
    """The coefficient of variation of subset simulation, from the failures of each family: what stems from one run of
    the first level. Families are independent of each other, so that their sums tell the variance whatever levels and
    chains have in common (Chan and Lai, 2013).

    Chain k of a level begins at the k-th run below the last threshold. A step beyond the threshold stays where it was.
    """
    found, family = margins[:levels[0].last], np.arange(levels[0].last)
    for before, level in pairwise(levels):
        seeds = np.flatnonzero(found <= before.threshold)[:chains]
        steps = [found[seeds]]
        for tried in margins[level.first:level.last].reshape(-1, chains):
            steps.append(np.where(tried <= before.threshold, tried, steps[-1]))
        found, family = np.concatenate(steps[1:]), np.tile(family[seeds], len(steps) - 1)
    failures = np.bincount(family[found <= 0])
    return float(np.sqrt(max((failures**2).sum() / failures.sum()**2 - 1 / levels[0].last, 0.0)))


def by_weights(watched: Watched, algorithm: Any, reason: str) -> Estimate:
    """The estimate of cross-entropy: the mean of the last level's weights, where those of successes are 0."""
    size, runs = watched.rare.runs_per_level, len(watched.found)
    levels = tuple(watched.level(i, float(t), None) for i, t in enumerate(algorithm.getThresholdPerStep()))
    if reason:
        return Estimate(None, None, None, levels, runs, reason, watched.points, watched.found)
    points, failed = watched.points[-size:], watched.found[-size:] <= 0
    ot, fitted = library(), algorithm.getResult().getAuxiliaryDistribution()
    logs = np.array(ot.Normal(points.shape[1]).computeLogPDF(points)) - np.array(fitted.computeLogPDF(points))
    weights = np.exp(logs[:, 0])
    counted = np.where(failed, weights, 0.0)
    p = float(counted.mean())
    if p == 0:
        return Estimate(None, None, None, levels, runs, "all weights of the last level vanish", watched.points,
                        watched.found)
    variation = float(counted.std(ddof=1) / math.sqrt(size) / p)
    return Estimate(p, variation, variation, (*levels[:-1], replace(levels[-1], probability=p)), runs, "",
                    watched.points, watched.found, weights)
