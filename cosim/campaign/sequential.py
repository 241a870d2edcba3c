"""A rule that ends a campaign when the interval of a probability is narrow enough, and that keeps its confidence.

An interval for a fixed number of runs does not keep it: who looks again and again, and stops at a moment that the runs
themselves decide, is wrong more often than its confidence says. A confidence sequence is right at all moments at once,
with the confidence that it states. So the campaign may look whenever it likes, may be stopped by hand, and may be
continued with more runs after its results were seen.

This is the beta-binomial mixture for a Bernoulli mean: H. Robbins, "Statistical methods related to the law of the
iterated logarithm", Annals of Mathematical Statistics 41 (1970) 1397-1409; in the two-sided form of S. R. Howard,
A. Ramdas, J. McAuliffe and J. Sekhon, "Time-uniform, nonparametric, nonasymptotic confidence sequences", Annals of
Statistics 49 (2021) 1055-1080. For each candidate p, the likelihood of the outcomes under other probabilities is
averaged over a beta distribution with mean p, and divided by their likelihood under p. If p is true, this ratio is a
martingale that starts at 1, and by Ville's inequality it ever reaches 1 / (1 - confidence) with a probability of at
most 1 - confidence. The interval holds the candidates for which the ratio is below that.

The beta distribution may be any that the outcomes do not decide. Its spread decides at which half-width the interval
needs the fewest runs. Here the standard deviation is 1.4 times the half-width that is asked for, and less where p is
near 0 or 1. Of 0.8, 1 and 1.4 times, this needs the fewest runs where failures or successes are rare; elsewhere the
three differ by less than 5 %.
"""
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

FIRST_LOOK, PART = 10, 50  # each look comes a 50th of the runs after the last
HALVINGS = 50


@dataclass(frozen=True)
class Sequence:
    """Intervals for a probability that all hold at once."""
    half_width: float  # for which the mixture is chosen

    def log_ratio(self, p: np.ndarray, successes: np.ndarray, runs: np.ndarray) -> np.ndarray:
        """Logarithm of the likelihood of the outcomes, mixed, over that under `p`; all of one shape, 0 < p < 1."""
        from scipy.special import betaln, xlog1py, xlogy

        q, failures = 1 - p, runs - successes
        size = p * q / (2 * self.half_width**2) + 1  # the beta distribution has the variance p * q / (size + 1)
        return np.asarray(betaln(size * p + successes, size * q + failures) - betaln(size * p, size * q)
                          - xlogy(successes, p) - xlog1py(failures, -p))

    def intervals(self, successes: np.ndarray, runs: np.ndarray, confidence: float) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper ends after `successes` in `runs`, both of one shape; 0 and 1 without runs."""
        successes, runs = np.asarray(successes, float), np.asarray(runs, float)
        share = np.where(runs > 0, successes / np.maximum(runs, 1), 0.5)
        ends = []
        for limit, nothing in ((0.0, successes == 0), (1.0, successes == runs)):
            outside, inside = np.full_like(share, limit), share  # the ratio is at most 1 at `share`
            for _ in range(HALVINGS):
                middle = (outside + inside) / 2
                with np.errstate(invalid="ignore", divide="ignore"):  # where `middle` is 0 or 1, `nothing` holds
                    out = self.log_ratio(middle, successes, runs) > -np.log1p(-confidence)
                outside, inside = np.where(out, middle, outside), np.where(out, inside, middle)
            ends.append(np.where(nothing, limit, outside))
        return ends[0], ends[1]

    def interval(self, successes: int, runs: int, confidence: float = 0.95) -> tuple[float, float]:
        """The interval after so many successes in so many runs."""
        low, high = self.intervals(np.array(successes), np.array(runs), confidence)
        return float(low), float(high)

    def narrow(self, successes: int, runs: int, confidence: float) -> bool:
        """Whether the interval is as narrow as was asked for."""
        around = successes / max(runs, 1) + 2 * self.half_width * np.array([-1.0, 1.0])
        around = around[(around > 0) & (around < 1)]
        if np.any(self.log_ratio(around, np.array(successes), np.array(runs)) <= -np.log1p(-confidence)):
            return False  # at little cost: one of these is in the interval
        low, high = self.interval(successes, runs, confidence)
        return (high - low) / 2 <= self.half_width


def looks(after: int, most: int) -> Iterator[int]:
    """The numbers of runs above `after`, up to `most`, at which the interval is looked at: always the same ones."""
    look = FIRST_LOOK
    while look <= most:
        if look > after:
            yield look
        look += max(1, look // PART)
