"""Linear systems as matrices with names, and their poles and zeros."""
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import pi
from typing import Any

import numpy as np
import scipy.linalg

Array = np.ndarray
NOTHING = 1e-8     # of other answers
SHORT, TICKS = 0.01, 200  # s and ticks, to see which output of a system answers which input
GONE = 1e-4  # what is left of a mode after one step when it is no pole any more that samples can tell


@dataclass(frozen=True)
class StateSpace:
    """x(k+1) = A x(k) + B u(k), y(k) = C x(k) + D u(k), a sample every `step` seconds; continuous where that is 0.

    y(k) is what is shown at the end of the step through which u(k) is held.
    """
    A: Array
    B: Array
    C: Array
    D: Array
    states: list[str]
    inputs: list[str]
    outputs: list[str]
    step: float

    def as_dict(self) -> dict[str, Any]:
        """Names and matrices as lists."""
        return {"states": self.states, "inputs": self.inputs, "outputs": self.outputs, "step_s": self.step,
                **{name: getattr(self, name).tolist() for name in "ABCD"}}


def poles(system: StateSpace) -> Array:
    """1/s, slowest first; of a sampled system those of the continuous one with the same samples."""
    return rates(np.linalg.eigvals(system.A), system.step)


def zeros(system: StateSpace, source: str, target: str) -> Array:
    """Transmission zeros from one input to one output, 1/s, smallest first."""
    i, o = system.inputs.index(source), system.outputs.index(target)
    pencil = np.block([[system.A, system.B[:, [i]]], [system.C[[o]], system.D[[o]][:, [i]]]])
    values = scipy.linalg.eigvals(pencil, np.diag([1.0] * len(system.A) + [0.0]))
    return rates(values[np.isfinite(values)], system.step)


def zeros_of_all(system: StateSpace, outputs: Sequence[str], fastest: float = np.inf) -> dict[str, Any]:
    """The zeros up to `fastest` from each input to each of `outputs`, by "input to output". A pair is left out whose
    answer is rounding: next to nothing beside those of the input's other outputs and of the output's other inputs."""
    answers = pulsed(system if system.step else sampled(system, SHORT), TICKS)
    peaks = np.nan_to_num(np.abs(answers), posinf=np.finfo(float).max).max(axis=0)
    row, column = peaks.max(axis=1, initial=0.0), peaks.max(axis=0, initial=0.0)
    return {f"{i} to {o}": roots(zeros(system, i, o), fastest)
            for k, i in enumerate(system.inputs) for j, o in enumerate(system.outputs)
            if o in outputs and (peaks[j, k] > NOTHING * row[j] or peaks[j, k] > NOTHING * column[k])}


def rates(values: Array, step: float) -> Array:
    """Eigenvalues of a system as rates, 1/s, smallest first: those of a sampled one without what is gone in a step."""
    values = values.astype(complex)
    if step:
        values = np.log(values[np.abs(values) > GONE]) / step
    return values[np.argsort(np.abs(values))]


def sampled(system: StateSpace, step: float) -> StateSpace:
    """What a continuous system does in steps of `step` seconds through which its inputs are held: its exact samples."""
    n, m = system.B.shape
    both = scipy.linalg.expm(step * np.block([[system.A, system.B], [np.zeros((m, n + m))]]))
    A, B = both[:n, :n], both[:n, n:]
    return replace(system, A=A, B=B, C=system.C @ A, D=system.C @ B + system.D, step=step)


def pulsed(system: StateSpace, ticks: int) -> Array:
    """What a sampled system shows of a pulse on each input, one tick long and of size 1: shape (ticks, outputs,
    inputs)."""
    x, found = system.B, [system.D]
    for _ in range(ticks - 1):
        found.append(system.C @ x)
        x = system.A @ x
    return np.array(found)


def continuous(system: StateSpace) -> StateSpace | None:
    """The continuous system that, with its input held over each step, has these samples; None if there is none.

    Outputs are the states' at the end of a step and depend on the input held through it: y(k) = C' x(k+1) + D' u(k).
    """
    n, m = system.B.shape
    if n == 0 or np.abs(np.linalg.eigvals(system.A)).min() < GONE:
        return None
    both = scipy.linalg.logm(np.block([[system.A, system.B], [np.zeros((m, n)), np.eye(m)]]))
    if np.abs(np.imag(both)).max() > 1e-6 * np.abs(both).max():
        return None
    both = np.real(both) / system.step
    later = np.linalg.solve(system.A.T, system.C.T).T
    return StateSpace(both[:n, :n], both[:n, n:], later, system.D - later @ system.B, system.states, system.inputs,
                      system.outputs, 0.0)


def roots(values: Array, fastest: float = np.inf) -> list[dict[str, float]]:
    """Poles or zeros (1/s) up to `fastest`: real and imaginary part, natural frequency (rad/s), damping ratio."""
    return [{"real": float(v.real), "imag": float(v.imag), "omega": float(abs(v)),
             "damping": 1.0 if v == 0 else float(-v.real / abs(v))} for v in values if abs(v) <= fastest]


def nyquist(step: float) -> float:
    """Half the sampling frequency, rad/s."""
    return pi / step
