"""How well fitted parameters are known: confidence intervals and correlations, and why they cannot be trusted."""
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import t as student

from .parameters import Parameter
from .search import Found, Rows

CONFIDENCE = 0.95
UNKNOWN = 0.5       # of a derivative that differences do not agree on any better
ROUGH = 0.05        # the same, worth a remark
LEAST = 1e-7        # singular value of normalised derivatives, beside the largest
INVOLVED = 0.1      # share of a parameter in a direction that the signals do not show
CORRELATED = 0.99
LARGE = 2.0         # of the residuals, in noise levels that were given
REMEMBERED = 0.3    # correlation of errors in neighbouring rows
Array = np.ndarray


@dataclass(frozen=True)
class Certainty:
    """Standard errors and half-widths of the intervals (shape (parameters,), NaN where there is none), correlations
    (shape (parameters, parameters)), `freedom` rows more than parameters, the residuals' variance in squares of noise
    levels, and sentences about what cannot be trusted, by parameter and in general."""
    errors: Array
    half_widths: Array
    correlation: Array
    freedom: int
    variance: float
    doubts: list[str]
    remarks: list[str]


def certainty(parameters: Sequence[Parameter], found: Found, rows: Rows, signals: Sequence[str], given: Sequence[bool]
              ) -> Certainty:
    """From the problem, linearised at the best fit: the covariance is s^2 (J^T J)^-1, with the residuals' variance s^2
    and Student's t. `given` tells which signals' noise levels were given."""
    apart = found.apart
    count, names = len(parameters), [p.name for p in parameters]
    doubts = [at_bound(p, x) for p, x in zip(parameters, found.point)]
    norms = np.linalg.norm(found.jacobian, axis=0)
    for k in range(count):
        if norms[k] == 0.0:
            doubts[k] = "cannot be identified: no signal depends on it"
        elif apart[k] > UNKNOWN:
            doubts[k] = "cannot be identified: no step of a difference shows how the signals depend on it"
    free = [k for k in range(count) if not doubts[k]]
    freedom = max(len(rows.values) - len(free), 1)
    variance = float(found.residuals @ found.residuals / freedom)
    covariance = np.full((count, count), np.nan)
    if free:
        normal = found.jacobian[:, free] / norms[free]
        _, sizes, directions = np.linalg.svd(normal, full_matrices=False)
        shown = sizes > max(LEAST, 3 * float(apart[free].max())) * sizes[0]
        for direction in directions[~shown]:
            blurred = [free[i] for i in np.flatnonzero(np.abs(direction) > INVOLVED)]
            for k in blurred:
                others = ", ".join(names[j] for j in blurred if j != k)
                what = f"tell it from {others}" if others else "show it"
                doubts[k] = f"cannot be identified: the signals do not {what}"
        inverse = (directions[shown].T / sizes[shown]**2) @ directions[shown]
        covariance[np.ix_(free, free)] = variance * inverse / np.outer(norms[free], norms[free])
    lost = [k for k in range(count) if doubts[k]]
    covariance[lost, :] = covariance[:, lost] = np.nan
    errors = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(errors, errors)
    remarks = general(found, rows, signals, given, variance, freedom)
    remarks += [f"{names[k]}: its derivative is known to {100 * apart[k]:.0f} % only; its interval is no better."
                for k in free if ROUGH < apart[k] <= UNKNOWN]
    remarks += [f"{names[i]} and {names[k]} are hard to tell apart: their correlation is {correlation[i, k]:.4f}."
                for i in range(count) for k in range(i) if abs(correlation[i, k]) > CORRELATED]
    return Certainty(errors, errors * student.ppf(0.5 + CONFIDENCE / 2, freedom), correlation, freedom, variance,
                     doubts, remarks)


def at_bound(parameter: Parameter, value: float) -> str:
    """A doubt about a value on a bound, else an empty text."""
    for bound, word in ((parameter.low, "lower"), (parameter.high, "upper")):
        if value == bound:
            return f"is at its {word} bound {bound:g}: an interval would mean nothing"
    return ""


def general(found: Found, rows: Rows, signals: Sequence[str], given: Sequence[bool], variance: float, freedom: int
            ) -> list[str]:
    """Sentences about what makes all intervals too narrow."""
    remarks = [] if found.settled else ["The search has not settled: --starts, other starts or bounds may help."]
    if all(given) and variance > LARGE**2:
        remarks.append(f"The errors are {variance**0.5:.3g} times as large as the noise that you gave: the system does "
                       f"not show what was measured, with any values of these parameters.")
    for s, name in enumerate(signals):
        related = neighbours(found.residuals, rows, s)
        if related > REMEMBERED:
            remarks.append(f"The errors of {name} are not noise: in neighbouring rows they are alike (correlation "
                           f"{related:.2f}). All intervals are too narrow.")
    return remarks


def neighbours(residuals: Array, rows: Rows, signal: int) -> float:
    """The correlation of a signal's errors in neighbouring rows of a flight; 0 where it may be chance."""
    pairs, square, count = 0.0, 0.0, 0
    for flight in np.unique(rows.flight):
        mine = residuals[(rows.signal == signal) & (rows.flight == flight)]
        pairs, square, count = pairs + float(mine[1:] @ mine[:-1]), square + float(mine @ mine), count + len(mine)
    return pairs / square if square > 0 and count > 10 and pairs / square > 4 / count**0.5 else 0.0
