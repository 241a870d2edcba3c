"""Least squares: parameters with which the flights show what was measured."""
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from scipy.optimize import least_squares

from .flown import Shown, Trial
from .parameters import Parameter

PASSES = 10                               # of the noise levels, at most
SETTLED = 1e-3                            # relative change of a noise level between two passes
STEPS = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5)    # tried for differences, as shares of a parameter's size
PENALTY = 10.0                            # of a row that was not reached, times the largest error that is sensible
EVALUATIONS = 200                         # of one least-squares problem, at most
KEPT = 1000                               # flights that are remembered
EXACT = 1e-9                              # least noise level, as a share of what the signal does
Array = np.ndarray
Fly = Callable[[Sequence[Trial]], list[Shown]]


@dataclass(frozen=True)
class Rows:
    """All that was measured: values, with the places of signal and flight of each, shape (rows,)."""
    values: Array
    signal: Array
    flight: Array


@dataclass
class Problem:
    """What is fitted to what. `levels` are the signals' noise levels, NaN where they are to be found; `flown` counts
    flights, `lost` has what those said that did not show all rows."""
    parameters: Sequence[Parameter]
    rows: Rows
    levels: Array
    fly: Fly
    tell: Callable[[str], None] = lambda line: None
    flown: int = 0
    lost: list[str] = field(default_factory=list)
    kept: dict[tuple[int, tuple[float, ...]], Shown] = field(default_factory=dict)

    @property
    def scale(self) -> Array:
        """How much each parameter is expected to change, shape (parameters,)."""
        return np.array([p.scale for p in self.parameters])

    @property
    def bounds(self) -> tuple[Array, Array]:
        """The parameters' lower and upper bounds, shape (parameters,)."""
        return np.array([p.low for p in self.parameters]), np.array([p.high for p in self.parameters])

    def flights(self, points: Sequence[Array]) -> list[list[Shown]]:
        """What each flight shows at each point, shape (parameters,)."""
        count = int(self.rows.flight.max()) + 1
        keys = [[(k, tuple(float(x) for p, x in zip(self.parameters, point) if p.flight in (None, k)))
                 for k in range(count)] for point in points]
        if len(self.kept) > KEPT:
            self.kept.clear()
        new = [key for key in dict.fromkeys(key for row in keys for key in row) if key not in self.kept]
        for key, one in zip(new, self.fly([self.trial(*key) for key in new])):
            self.kept[key] = one
            if np.isnan(one.values).any():
                self.lost.append(one.message or "Some values were not finite.")
        self.flown += len(new)
        return [[self.kept[key] for key in row] for row in keys]

    def trial(self, place: int, values: tuple[float, ...]) -> Trial:
        """The flight at `place` with the values of the parameters that concern it."""
        names = [p.target for p in self.parameters if p.flight in (None, place)]
        return place, dict(zip(names, values))

    def shown(self, points: Sequence[Array]) -> Array:
        """What all flights show, shape (points, rows); NaN in rows that they do not come to."""
        return np.array([np.concatenate([one.values for one in row]) for row in self.flights(points)])

    def errors(self, point: Array) -> Array:
        """What is shown less what was measured, shape (rows,); NaN in rows that the flights do not come to."""
        return self.shown([point])[0] - self.rows.values

    def spread(self) -> Array:
        """What the signals do, shape (signals,): from the least to the greatest measured value, or the size of a value
        that stays."""
        found = [self.rows.values[self.rows.signal == s] for s in range(len(self.levels))]
        return np.array([np.ptp(v) or np.abs(v).max() or 1.0 for v in found])

    def noise(self, point: Array) -> Array:
        """The signals' noise levels, shape (signals,): those that are given, else the rms of the errors at `point`,
        with as many rows less as there are parameters, shared among the signals."""
        errors, found = self.errors(point), self.levels.copy()
        reached = np.isfinite(errors)
        left = max(reached.sum() - len(self.parameters), 1) / max(reached.sum(), 1)
        for s in np.flatnonzero(np.isnan(self.levels)):
            mine = errors[reached & (self.rows.signal == s)]
            found[s] = np.sqrt(np.mean(mine**2) / left) if len(mine) else 0.0
        return np.where(np.isnan(self.levels), np.maximum(found, EXACT * self.spread()), self.levels)

    def derivatives(self, point: Array, steps: Array) -> Array:
        """Derivatives of all that is shown, shape (rows, parameters), by differences of two flights, `steps` to both
        sides within the bounds. Rows that only one of them comes to have the difference from `point`; 0 without any."""
        low, high = self.bounds
        ends = np.array([[np.clip(point + sign * row, low, high) for sign in (1, -1)] for row in np.diag(steps)])
        found = self.shown([*ends.reshape(-1, len(point)), point])
        here, pairs = found[-1], found[:-1].reshape(len(point), 2, -1)
        columns = []
        for k, (above, below) in enumerate(pairs):
            (up, down), x = ends[k, :, k], point[k]
            slopes = [(above - below) / (up - down)]
            slopes += [(one - here) / (end - x) for one, end in ((above, up), (below, down)) if end != x]
            column = slopes[0]
            for other in slopes[1:]:
                column = np.where(np.isfinite(column), column, other)
            columns.append(np.where(np.isfinite(column), column, 0.0))
        return np.array(columns).T

    def residuals(self, errors: Array, noise: Array, sensible: Array) -> Array:
        """Errors in noise levels, shape (rows,); a row that was not reached counts as a multiple of its signal's
        largest `sensible` error."""
        return np.where(np.isfinite(errors), errors, PENALTY * sensible[self.rows.signal]) / noise[self.rows.signal]


def steps_of(problem: Problem, point: Array) -> tuple[Array, Array]:
    """For each parameter the step of its differences, and how well they know the derivative there (relatively), both
    shape (parameters,).

    Too large a step sees the flights bend, too small a one their rounding, or what an FMU's own solver leaves. Which is
    which differs by orders of magnitude between FMUs, so it is measured: of steps of several sizes, those two next to
    each other are looked for whose derivatives agree best, and the larger of them is taken.
    """
    low, high = problem.bounds
    size = np.array([min(abs(x), p.scale) if x else p.scale for p, x in zip(problem.parameters, point)])
    size = np.minimum(size, high - low)
    noise = problem.noise(point)[problem.rows.signal]
    found = [problem.derivatives(point, share * size) / noise[:, None] for share in STEPS]
    apart = np.array([np.linalg.norm(a - b, axis=0) / np.maximum(np.linalg.norm(a, axis=0), 1e-300)
                      for a, b in pairwise(found)])
    best = apart.argmin(axis=0)
    return np.array(STEPS)[best] * size, apart.min(axis=0)


@dataclass(frozen=True)
class Found:
    """Where a search that began at `begun` ended: values of the parameters, noise levels of the signals. `cost` is -2
    times the logarithm of the likelihood, but for a constant. `jacobian`, shape (rows, parameters), and `residuals` are
    in noise levels."""
    begun: Array
    point: Array
    noise: Array
    cost: float
    jacobian: Array
    residuals: Array
    settled: bool
    apart: Array     # how well the derivatives are known, see `steps_of`


def search(problem: Problem, start: Array) -> Found:
    """The nearest best fit from `start`, shape (parameters,).

    Noise levels that nobody gives are found on the way: the fit is repeated with the rms that its errors had, until
    these stay. That is the most likely fit of signals whose noise is independent and normal.
    """
    scale, (low, high), (steps, apart) = problem.scale, problem.bounds, steps_of(problem, start)
    point, noise, settled = start, problem.noise(start), False
    errors = np.nan_to_num(np.abs(problem.errors(start)))
    largest = np.array([errors[problem.rows.signal == s].max() for s in range(len(noise))])
    sensible = np.maximum(largest, problem.spread())
    for _ in range(PASSES):
        done = least_squares(
            lambda z, noise=noise: problem.residuals(problem.errors(z * scale), noise, sensible),
            np.clip(point / scale, low / scale, high / scale),
            lambda z, noise=noise: slopes(problem, z * scale, steps, noise) * scale, (low / scale, high / scale),
            max_nfev=EVALUATIONS)
        point, before, noise = np.clip(done.x * scale, low, high), noise, problem.noise(done.x * scale)
        settled = done.status > 0 and bool(np.all(np.abs(noise - before) <= SETTLED * before))
        problem.tell(f"{problem.flown} flights: " + ", ".join(
            f"{p.name} {x:.6g}" for p, x in zip(problem.parameters, point)))
        if settled or (done.status > 0 and not np.isnan(problem.levels).any()):
            settled = True
            break
    point = at_bounds(point, problem)
    residuals = problem.residuals(problem.errors(point), noise, sensible)
    cost = float(residuals @ residuals + 2 * np.log(noise[problem.rows.signal]).sum())
    return Found(start, point, noise, cost, slopes(problem, point, steps, noise), residuals, settled,
                 apart)


def slopes(problem: Problem, point: Array, steps: Array, noise: Array) -> Array:
    """Derivatives in noise levels."""
    return problem.derivatives(point, steps) / noise[problem.rows.signal][:, None]


def at_bounds(point: Array, problem: Problem) -> Array:
    """`point` with what is next to a bound on the bound: the search comes close to one, never onto it."""
    low, high = problem.bounds
    near = 1e-6 * problem.scale
    return np.where(point - low < near, low, np.where(high - point < near, high, point))


def starts(parameters: Sequence[Parameter], count: int, seed: int) -> list[Array]:
    """`count` points to begin at: the parameters' starts, then a Latin hypercube of their ranges."""
    low, high = np.array([p.range() for p in parameters]).T
    drawing, shape = np.random.default_rng(seed), (count - 1, len(parameters))
    layers = drawing.permuted(np.tile(np.arange(count - 1)[:, None], shape[1]), axis=0)
    drawn = (layers + drawing.random(shape)) / max(count - 1, 1)
    return [np.array([p.start for p in parameters]), *(low + drawn * (high - low))]
