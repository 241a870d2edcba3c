"""The draws of run k: they depend on the seed and k, and on nothing else.

`random` and `sobol` are the same for run k however many runs there are; a Latin hypercube divides each range into as
many strata as there are runs, so there a run also depends on their number.
"""
import math
import warnings
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import repeat
from pathlib import Path
from typing import Any

import numpy as np

from ..master.system import Value
from .distributions import Distribution, Given
from .samples import Samples
from .spec import Correlation

EDGE = 2.0**-53     # a uniform draw stays off 0 and 1 by this
DRAWS, SHARE = 0, 1  # streams of random numbers


@dataclass(frozen=True)
class Draw:
    """One uncertain number: which variables get it, and from what."""
    name: str                    # component.variable; the column of the results
    targets: tuple[str, ...]     # what is set
    distribution: Distribution
    factor: float | None = None  # the nominal value that the draw multiplies
    period: bool = False         # drawn as a period, set as an angular frequency

    def value(self, u: float) -> Value:
        """The value at the probability `u`."""
        return self.changed(self.distribution.quantile(u))

    def changed(self, found: Value) -> Value:
        """What is set where the distribution has the value `found`."""
        if self.factor is not None:
            found = self.factor * float(found)
        return 2 * math.pi / float(found) if self.period else found

    def extremes(self) -> list[Value]:
        """Values that must be allowed: the ends of a bounded distribution, the middle of another."""
        return [self.changed(x) for x in self.distribution.extremes()]

    @cached_property
    def levels(self) -> list[Value]:
        """The values in a grid. Raises ValueError where the distribution has none."""
        return [self.changed(x) for x in self.distribution.levels()]


def stream(seed: int, k: int, which: int) -> np.random.Generator:
    """Random numbers of run k alone: a counter-based generator, each run in a block of its own."""
    return np.random.Generator(np.random.Philox(key=np.array([seed, which], np.uint64),
                                                counter=np.array([0, 0, 0, k], np.uint64)))


@dataclass(frozen=True)
class Mixing:
    """A correlated group: normal scores of the draws `members` are multiplied by a root of its matrix."""
    members: tuple[int, ...]
    root: np.ndarray


def mixing(group: Correlation, names: list[str]) -> Mixing:
    """Raises ValueError for a name that is no draw, or a matrix that cannot be a correlation."""
    for name in group.draws:
        if name not in names:
            raise ValueError(f"{name} is not drawn; there are {', '.join(names)}")
    n = len(group.draws)
    if group.matrix is None:
        matrix = np.full((n, n), group.coefficient)
        np.fill_diagonal(matrix, 1.0)
    elif [len(row) for row in group.matrix] != [n] * n:
        raise ValueError(f"matrix must have {n} rows of {n} numbers")
    else:
        matrix = np.array(group.matrix)
    if not (np.isfinite(matrix).all() and np.allclose(matrix, matrix.T, atol=1e-12) and (np.diag(matrix) == 1.0).all()):
        raise ValueError("a correlation matrix is symmetric, with 1 on its diagonal")
    size, axes = np.linalg.eigh(matrix)
    if size[0] < -1e-9:
        raise ValueError(f"nothing can be correlated like that: the matrix has the negative eigenvalue {size[0]:.3g}")
    return Mixing(tuple(names.index(name) for name in group.draws), (axes * np.sqrt(np.maximum(size, 0.0))) @ axes.T)


@dataclass(frozen=True)
class Sampler:
    """Points of the unit cube, one for each run, and rows of samples beside them."""
    sampling: str
    seed: int
    runs: int
    dimensions: int
    mixings: tuple[Mixing, ...] = ()
    samples: Samples | None = None

    def placed(self, folder: Path) -> "Sampler":
        """The same where the samples are below `folder`."""
        return self if self.samples is None else replace(self, samples=self.samples.at(folder))

    @cached_property
    def hypercube(self) -> np.ndarray:
        """All runs' points of a Latin hypercube, which comes as a whole only; shape (runs, dimensions)."""
        from scipy.stats import qmc

        return qmc.LatinHypercube(self.dimensions, rng=np.random.default_rng(self.seed)).random(self.runs)

    def sobol(self, first: int, last: int) -> np.ndarray:
        """A part of the scrambled sequence; shape (last - first, dimensions)."""
        from scipy.stats import qmc

        sequence = qmc.Sobol(self.dimensions, rng=np.random.default_rng(self.seed))
        if first:
            sequence.fast_forward(first)
        with warnings.catch_warnings():  # any number of points is allowed here; powers of 2 are best
            warnings.simplefilter("ignore", UserWarning)
            return sequence.random(last - first)

    def points(self, first: int, last: int) -> np.ndarray:
        """The points of runs first ... last - 1, correlated; shape (last - first, dimensions)."""
        if self.sampling == "random":
            found = np.array([stream(self.seed, k, DRAWS).random(self.dimensions) for k in range(first, last)])
        else:
            found = self.sobol(first, last) if self.sampling == "sobol" else self.hypercube[first:last]
        return self.correlated(found)

    def at(self, normal: np.ndarray) -> np.ndarray:
        """The points of the unit cube at points of the standard normal space, correlated; shape (runs, dimensions)."""
        from scipy.special import ndtr

        return self.correlated(ndtr(normal))

    def correlated(self, points: np.ndarray) -> np.ndarray:
        """Independent points, off the edges and correlated."""
        points = np.clip(points, EDGE, 1 - EDGE)
        for u in points:
            self.correlate(u)
        return points

    def uniforms(self, k: int) -> np.ndarray:
        """Run k's point, shape (dimensions,)."""
        return self.points(k, k + 1)[0]

    def correlate(self, u: np.ndarray) -> None:
        """Correlate the numbers of one point."""
        from scipy.special import ndtr, ndtri

        for group in self.mixings:
            members = list(group.members)
            scores = ndtri(u[members])
            u[members] = np.clip(ndtr([float((row * scores).sum()) for row in group.root]), EDGE, 1 - EDGE)


def keeps_signals(seed: int, k: int, share: float) -> bool:
    """Whether run k is one of the share whose signals are kept."""
    return share > 0 and bool(stream(seed, k, SHARE).random() < share)


def draw(draws: Iterable[Draw], u: Any) -> dict[str, Value]:
    """The values of one run, by the draws' names."""
    return {d.name: d.value(float(x)) for d, x in zip(draws, u)}


def free(draws: Iterable[Draw]) -> tuple[Draw, ...]:
    """Those that samples do not give."""
    return tuple(d for d in draws if not isinstance(d.distribution, Given))


def on_grid(draws: Sequence[Draw], k: int) -> dict[str, Value]:
    """The values of run k in the full grid of all levels, by the draws' names; those of the last draw change first."""
    at = np.unravel_index(k, [len(d.levels) for d in draws])
    return {d.name: d.levels[i] for d, i in zip(draws, at)}


def drawn(sampler: Sampler, draws: tuple[Draw, ...], first: int, last: int, points: np.ndarray | None = None
          ) -> Iterator[dict[str, Value]]:
    """The values of runs first ... last - 1, by the draws' names: from rows of samples, a grid, or points of the unit
    cube, which are the sampler's unless `points` are given, shape (last - first, dimensions)."""
    ours = free(draws)
    rows = repeat({}) if sampler.samples is None else sampler.samples.read(first, last)
    if sampler.sampling == "grid":
        found: Iterable[dict[str, Value]] = (on_grid(ours, k) for k in range(first, last))
    elif ours:
        found = (draw(ours, u) for u in (sampler.points(first, last) if points is None else points))
    else:
        found = repeat({}, last - first)
    for values, row in zip(found, rows):
        yield {**row, **values}
