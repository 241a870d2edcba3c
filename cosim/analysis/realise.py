"""A state space from answers to pulses: the eigensystem realisation algorithm.

Juang and Pappa (J. Guidance 8, 1985), after Ho and Kalman: the matrix of the answers at ticks i + j has as many
singular values as there are states that an input moves and an output shows. Two choices are ours. The ticks i and j are
spaced geometrically, so that a small matrix covers fast and slow modes. Each output and input is scaled by its errors;
then the states are counted by the singular values above the norm of the same matrix of errors.
"""
import numpy as np

from .pulses import Answers
from .statespace import StateSpace

Array = np.ndarray
OFFSETS = 40      # i and j, each
ROUNDING = 1e-16  # of an answer's largest value: no error is smaller
PASSES = 5        # of scaling rows, then columns
GROWING = 1.0     # an unstable pole counts as growing if it grows by e to this within the answers


def realise(name: str, answers: Answers, step: float) -> StateSpace:
    """The smallest sampled system whose answers are these within their errors; states are called name[0], name[1], ...

    If the answers grow, the system is found once more from answers that are weighted not to: late errors are large.
    """
    found = realised(name, answers, step, 1.0)
    growth = max(1.0, *np.abs(np.linalg.eigvals(found.A)), 1.0)
    return realised(name, answers, step, growth) if growth > 1 + GROWING / len(answers.values) else found


def realised(name: str, answers: Answers, step: float, growth: float) -> StateSpace:
    """The same, from answers that are divided by growth**tick."""
    ticks, outputs, inputs = answers.values.shape
    weights = growth ** -np.arange(ticks)[:, None, None]
    values = answers.values * weights
    errors = np.maximum(answers.errors * weights, ROUNDING * np.abs(values).max(axis=0))
    rows, columns = np.ones(outputs), np.ones(inputs)  # how large errors are
    for _ in range(PASSES):
        columns = size(errors / rows[:, None], (0, 1))
        rows = size(errors / columns, (0, 2))
    scales = 1 / (rows[:, None] * columns)
    offsets = np.unique(np.append(0, np.rint(np.geomspace(1, (ticks - 3) // 2, OFFSETS)))).astype(int)
    U, S, V = np.linalg.svd(hankel(values * scales, offsets, 0), full_matrices=False)
    n = int((np.linalg.norm(hankel(errors * scales, offsets, 0), 2) < S).sum())
    root = np.sqrt(S[:n])
    A = growth * (U[:, :n] / root).T @ hankel(values * scales, offsets, 1) @ (V[:n].T / root)
    B, C = root[:, None] * V[:n, :inputs] * columns, growth * U[:outputs, :n] * root * rows[:, None]
    return StateSpace(A, B, C, answers.values[0], [f"{name}[{i}]" for i in range(n)], answers.inputs, answers.outputs,
                      step)


def size(values: Array, axes: tuple[int, int]) -> Array:
    """Root mean square over some axes; 1 where that is 0."""
    found = np.sqrt((values**2).mean(axis=axes))
    return np.where(found > 0, found, 1.0)


def hankel(values: Array, offsets: Array, later: int) -> Array:
    """The block Hankel matrix of the answers at ticks 1 + `later` + i + j, i and j from `offsets`."""
    blocks = values[1 + later + offsets[:, None] + offsets]
    return blocks.transpose(0, 2, 1, 3).reshape(len(offsets) * values.shape[1], -1)
