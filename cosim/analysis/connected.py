"""Components' linear systems connected as they fly: one after the other in a tick, Gauss-Seidel.

An input sees its source as that is at the time: at the end of this tick if the source has stepped, else of the last.
"""
from collections.abc import Mapping, Sequence

import numpy as np

from ..master.system import Connection
from .statespace import StateSpace

Array = np.ndarray


def connected(parts: Mapping[str, StateSpace], links: Sequence[Connection], given: Sequence[str],
              shown: Sequence[str]) -> StateSpace:
    """The system of `parts`, in the order in which they step, from the signals `given` to those `shown`.

    Signals are called component.variable. Whatever reads a given signal sees it in place of what its component shows
    (which is shown nevertheless): given a signal of the loop, the loop is cut there. Of other sources nothing moves.
    """
    sources = {link.target: link for link in links}
    own = {f"{name}.{output}" for name, part in parts.items() for output in part.outputs}
    order = list(parts)

    def place(signal: str) -> int:
        name = signal.partition(".")[0]
        return order.index(name) if name in order else -1

    held = sorted({link.source for link in links if link.source in own | set(given)
                   and link.target.partition(".")[0] in order and place(link.source) >= place(link.target)})
    states = [*(state for part in parts.values() for state in part.states), *(f"{signal} held" for signal in held)]
    width = len(states) + len(given)

    def unit(column: int) -> Array:
        return np.eye(1, width, column)[0]

    last = {signal: unit(len(states) - len(held) + i) for i, signal in enumerate(held)}
    seen = {signal: unit(len(states) + i) for i, signal in enumerate(given)}  # as others see it; rows by states, inputs
    own_values: dict[str, Array] = {}
    later, first = np.zeros((len(states), width)), 0
    for name, part in parts.items():
        u = np.zeros((len(part.inputs), width))
        for i, variable in enumerate(part.inputs):
            link = sources[f"{name}.{variable}"]
            ready = -1 < place(link.source) < place(link.target) or place(link.source) < 0
            value = (seen if ready else last).get(link.source)
            if value is not None:
                u[i] = link.factor * value
        n = len(part.states)
        x = np.eye(n, width, first)
        later[first:first + n] = part.A @ x + part.B @ u
        for output, value in zip(part.outputs, part.C @ x + part.D @ u):
            own_values[f"{name}.{output}"] = value
            seen.setdefault(f"{name}.{output}", value)
        first += n
    for i, signal in enumerate(held):
        later[first + i] = seen[signal]
    n = len(states)
    rows = np.array([own_values[signal] for signal in shown]).reshape(-1, width)
    return StateSpace(later[:, :n], later[:, n:], rows[:, :n], rows[:, n:], states, list(given), list(shown),
                      next(iter(parts.values())).step)
