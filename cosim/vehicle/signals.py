"""The signals of a flight as the vehicle's metrics and figures read them, whoever's FMUs flew."""
import numpy as np

from ..master.flight import Flight

OMEGA, ZETA = 0.1, 0.9  # of the reference filter (67), rad/s and 1
# A controller that shows no reference is measured against the filtered command, as the paper's laws are.
COMMANDS = {f"controller.{state}_reference": (f"scenario.{state}_command", state) for state in ("V", "h")}


def known(flight: Flight, name: str) -> bool:
    """Whether `signal` can give `name`."""
    return flight.has(name) or (name in COMMANDS and flight.has(COMMANDS[name][0]))


def signal(flight: Flight, expression: str) -> np.ndarray:
    """A column, shape (rows,), or the difference of two written `a - b`."""
    first, _, second = expression.partition(" - ")
    if second:
        return signal(flight, first) - signal(flight, second)
    if first in COMMANDS and not flight.has(first):
        command, state = COMMANDS[first]
        return reference(flight.time, flight[command], float(truth(flight, state)[0]))
    return flight[first]


def truth(flight: Flight, name: str) -> np.ndarray:
    """A state of the plant as it is, where the plant also has a sensor's view of it."""
    true = f"plant.{name}_true"
    return flight[true if flight.has(true) else f"plant.{name}"]


def reference(time: np.ndarray, command: np.ndarray, start: float) -> np.ndarray:
    """The filter (67), at rest at `start` at first, driven by `command` held from row to row; shapes (rows,)."""
    from scipy.linalg import expm

    found = np.full(len(time), start)
    x = np.array([start, 0.0])
    A = np.array([[0.0, 1.0], [-OMEGA**2, -2 * ZETA * OMEGA]])
    steps: dict[float, np.ndarray] = {}
    for k in range(1, len(time)):
        h = round(float(time[k] - time[k - 1]), 12)
        if h not in steps:
            steps[h] = expm(A * h)
        level = np.array([command[k - 1], 0.0])
        x = level + steps[h] @ (x - level)
        found[k] = x[0]
    return found
