"""A state space from answers to pulses: the eigensystem realisation algorithm.

Juang and Pappa (J. Guidance 8, 1985), after Ho and Kalman: a matrix of answers at times i + j is the product of what
can be observed i steps after a state with what the pulses made of the states j steps before. Its singular values say
how many states there are. Here i and j are spaced geometrically, which holds fast and slow modes in a small matrix; and
every row and column is scaled by how far its answers may be off, so that a singular value above the norm of the same
matrix of errors is a state, and one below is not.
"""
import numpy as np

from .pulses import Answers
from .statespace import StateSpace

Array = np.ndarray
OFFSETS = 40      # i and j, each
ROUNDING = 1e-16  # of an answer's largest value: no error is smaller
PASSES = 5        # of scaling rows, then columns


def realise(name: str, answers: Answers, step: float) -> StateSpace:
    """The smallest sampled system with these answers as far as they can be told from errors."""
    ticks, outputs, inputs = answers.values.shape
    errors = np.maximum(answers.errors, ROUNDING * np.abs(answers.values).max(axis=0) + np.finfo(float).tiny)
    rows, columns = np.ones(outputs), np.ones(inputs)
    for _ in range(PASSES):
        columns = 1 / size(errors * rows[:, None], (0, 1))
        rows = 1 / size(errors * columns, (0, 2))
    scaled = answers.values * rows[:, None] * columns
    offsets = np.unique(np.append(0, np.rint(np.geomspace(1, (ticks - 3) // 2, OFFSETS)))).astype(int)
    U, S, V = np.linalg.svd(hankel(scaled, offsets, 0), full_matrices=False)
    n = int((np.linalg.norm(hankel(errors * rows[:, None] * columns, offsets, 0), 2) < S).sum())
    root = np.sqrt(S[:n])
    A = (U[:, :n] / root).T @ hankel(scaled, offsets, 1) @ (V[:n].T / root)
    B, C = root[:, None] * V[:n, :inputs] / columns, U[:outputs, :n] * root / rows[:, None]
    return StateSpace(A, B, C, answers.values[0], [f"{name}[{i}]" for i in range(n)], answers.inputs, answers.outputs,
                      step)


def size(values: Array, axes: tuple[int, int]) -> Array:
    return np.sqrt((values**2).mean(axis=axes))


def hankel(values: Array, offsets: Array, later: int) -> Array:
    """The matrix of answers at `offsets` + `offsets` + `later` ticks after the first: blocks of outputs by inputs."""
    blocks = values[1 + later + offsets[:, None] + offsets]
    return blocks.transpose(0, 2, 1, 3).reshape(len(offsets) * values.shape[1], -1)
