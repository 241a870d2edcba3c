"""The signals of a flight as the vehicle's metrics and figures read them, whoever's FMUs flew."""
from collections.abc import Container

import numpy as np

from ..master.course import Course, terms
from ..master.flight import Flight

OMEGA, ZETA = 0.1, 0.9  # of the reference filter (67), rad/s and 1
# What stands for a signal that a flight does not have. A plant without sensors shows its states as they are; a
# controller that shows no reference is measured against the filtered command, as the paper's laws are.
SENSED = {f"plant.{state}_true": f"plant.{state}" for state in ("V", "h", "gamma", "theta", "Q")}
COMMANDS = {f"controller.{state}_reference": f"scenario.{state}_command" for state in ("V", "h")}
STANDS_IN = {**SENSED, **COMMANDS}


def names(expression: str) -> list[str]:
    """The signals of `a - b + c`."""
    return [name for _, name in terms(expression)]


def source(signals: Container[str], name: str) -> str:
    """Which of `signals` gives `name`: itself, else what stands in for it."""
    return name if name in signals else STANDS_IN.get(name, name)


def known(signals: Container[str], expression: str) -> bool:
    """Whether `signals`, or a flight, have all that the expression needs."""
    return all(source(signals, name) in signals for name in names(expression))


def values(flight: Flight, name: str) -> np.ndarray:
    """A signal, or what stands in for it, shape (rows,). Raises UsageError if there is neither."""
    found = np.asarray(flight[source(flight, name)])
    if name in flight or name not in COMMANDS:
        return found
    state = name.removeprefix("controller.").removesuffix("_reference")
    return reference(flight.time, found, float(values(flight, f"plant.{state}_true")[0]))


def course(flight: Flight, expression: str) -> Course:
    """As `Flight.course`, with what stands in for missing signals. Raises UsageError as `values` does."""
    (sign, first), *others = terms(expression)
    total = sign * values(flight, first)
    for sign, name in others:
        total += sign * values(flight, name)
    rows = flight.together(source(flight, name) for name in names(expression))
    return Course(flight.time, total) if rows.all() else Course(flight.time[rows], total[rows])


def reference(time: np.ndarray, command: np.ndarray, start: float) -> np.ndarray:
    """The filter (67), at rest at `start` at first, driven by `command` held from row to row; shapes (rows,).

    From row to row the distance to the command and the speed are multiplied by the matrix [[a, b], [c, d]].
    """
    damping, frequency = ZETA * OMEGA, OMEGA * np.sqrt(1 - ZETA**2)
    steps = np.diff(time)
    decay, sine = np.exp(-damping * steps), np.sin(frequency * steps) / frequency
    a, d = (decay * (np.cos(frequency * steps) + sign * damping * sine) for sign in (1, -1))
    b, c = decay * sine, -OMEGA**2 * decay * sine
    found, speed = [start], 0.0
    for level, a_k, b_k, c_k, d_k in zip(command[:-1].tolist(), *(part.tolist() for part in (a, b, c, d))):
        away = found[-1] - level
        found.append(level + a_k * away + b_k * speed)
        speed = c_k * away + d_k * speed
    return np.array(found)
