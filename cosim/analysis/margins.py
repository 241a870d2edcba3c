"""Gain, phase and delay margins of a sampled linear loop, from its frequency response.

    x(k+1) = A x(k) + B u(k),   y(k) = C x(k) + D u(k),   a sample every `step` seconds
"""
from dataclasses import asdict, dataclass
from math import pi
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]
FREQUENCIES = 3000
LOWEST = 1e-3  # rad/s
REAL = 1e-6  # rad


@dataclass(frozen=True)
class Margins:
    """How much a loop bears before it is no longer stable; None where no such change is found.

    gain_up, gain_down: factors on the loop gain; phase_deg: degrees of phase, either way;
    delay_s: seconds of added delay; crossover: rad/s of the crossing that limits the delay.
    """
    gain_up: float | None
    gain_down: float | None
    phase_deg: float | None
    delay_s: float | None
    crossover: float | None

    def as_dict(self) -> dict[str, float | None]:
        """The margins by name."""
        return asdict(self)


def response(A: Array, B: Array, C: Array, D: Array, omega: Array, step: float) -> Array:
    """C (zI - A)^-1 B + D at z = exp(j omega step), shape (frequencies, outputs, inputs)."""
    z = np.exp(1j * omega * step)[:, None, None]
    return C @ np.linalg.solve(z * np.eye(len(A)) - A, np.broadcast_to(B.astype(complex), (len(z), *B.shape))) + D


def crossings(values: Array) -> list[tuple[int, float]]:
    """Where a sampled curve changes sign: (index before, fraction of the interval)."""
    before = np.flatnonzero(values[:-1] * values[1:] < 0)
    return [(int(i), float(values[i] / (values[i] - values[i + 1]))) for i in before]


def margins(omega: Array, loop: Array) -> Margins:
    """Margins of a stable closed loop 1/(1 + loop) from its open-loop response `loop`, shape (frequencies,).

    Every crossing counts: the nearest gain either way at a phase of 180 degrees, the nearest phase and the
    smallest delay at a gain of one.
    """
    size, phase = np.log(np.abs(loop)), np.angle(-loop)  # phase is measured from -180 degrees

    def between(curve: Array, at: tuple[int, float]) -> float:
        i, part = at
        return float(curve[i] + part * (curve[i + 1] - curve[i]))

    gains = [np.exp(-between(size, at)) for at in crossings(phase) if abs(phase[at[0]] - phase[at[0] + 1]) < pi]
    if abs(phase[-1]) < REAL:  # at half the sampling frequency every response is real
        gains.append(np.exp(-size[-1]))
    up, down = [float(g) for g in gains if g > 1], [float(g) for g in gains if g < 1]
    phases, delays = [], []
    for at in crossings(size):
        frequency = between(omega, at)
        angle = between(np.unwrap(phase[at[0]:at[0] + 2]), (0, at[1]))
        phases.append(abs((angle + pi) % (2 * pi) - pi))
        delays.append((float(angle % (2 * pi) / frequency), frequency))
    delay, crossover = min(delays, default=(None, None))
    return Margins(min(up, default=None), max(down, default=None),
                   float(np.degrees(min(phases))) if phases else None, delay, crossover)


def frequencies(step: float) -> Array:
    """rad/s, shape (FREQUENCIES,), up to half the sampling frequency."""
    return np.geomspace(LOWEST, pi / step, FREQUENCIES)


def margins_at(cut: Any) -> Margins:
    """Margins of a loop that is cut at one place: `cut` has the sampled A, B, C, D from what is put in after the cut to
    what arrives before it, and the `step` in s."""
    omega = frequencies(cut.step)
    return margins(omega, -response(cut.A, cut.B, cut.C, cut.D, omega, cut.step)[:, 0, 0])
