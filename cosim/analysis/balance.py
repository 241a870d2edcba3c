"""The equilibrium of a closed loop that no flight finds, such as an unstable one: Newton's method on its equations.

All components need model exchange. Inside it a loop's signals follow from all states: each input is its source's value.
"""
from collections.abc import Mapping, Sequence
from contextlib import ExitStack, closing
from dataclasses import replace

import numpy as np
import scipy.linalg

from ..errors import RunError
from ..master.fmu import FmuFile
from ..master.loaded import Master
from ..master.system import Connection, System
from .equations import Equations, Point, given
from .pulses import Rest, in_turn, scale
from .statespace import StateSpace

Array = np.ndarray
STAGES, STEPS = 8, 40  # on the way from the start, where rates are not 0; of Newton's method in each
ARRIVED = 1e-9         # a step of all states, relative to their scales, that changes nothing


def balanced(system: System, files: Mapping[str, FmuFile], links: Sequence[Connection], order: Sequence[str],
             step: float) -> tuple[Rest, dict[str, StateSpace]]:
    """The loop of `links` where all its states rest, beginning with those it starts with, and each of its components
    there (continuous), in `order`. Other signals stay as at the start.

    Raises RunError where Newton's method does not arrive.
    """
    start = signals_at_start(system, dict(files), step)
    moved = list(dict.fromkeys(link.target.partition(".")[0] for link in links))
    with ExitStack() as stack:
        parts = {name: stack.enter_context(closing(Equations(files[name].for_exchange(),
                                                             Point(given(system, files[name], name, start), {}))))
                 for name in order if name in moved}
        loop = Loop(parts, links, start)
        x = loop.start
        first = loop.rates(x)
        for part in np.linspace(0, 1, STAGES + 1)[1:]:
            x = loop.solve(x, (1 - part) * first)
        loop.rates(x)
        found = {name: replace(part, states=[f"{name}.{state}" for state in part.states])
                 for name in parts for part in [loop.linear(name)]}
    large = {name: scale(files[component], variable, abs(value)) for name, value in loop.values.items()
             for component, _, variable in [name.partition(".")]}
    return Rest(system, dict(files), step, 0, step, dict(loop.values), large), found


def signals_at_start(system: System, files: dict[str, FmuFile], step: float) -> dict[str, float]:
    """All outputs when the system is initialised, by component.variable."""
    with closing(Master(system, files)) as master:
        master.initialise(0.0, step)
        master.run(in_turn(master), 0, 0, 0.0, step)
        return dict(zip((c.name for c in master.columns), master.row().tolist()))


class Loop:
    """Components' equations, connected."""

    def __init__(self, parts: Mapping[str, Equations], links: Sequence[Connection], values: Mapping[str, float]):
        self.parts, self.values = parts, dict(values)
        self.inputs = {name: {link.target.partition(".")[2]: link for link in links
                              if link.target.startswith(f"{name}.")} for name in parts}
        self.outputs = {name: sorted({link.source.partition(".")[2] for link in links
                                      if link.source.startswith(f"{name}.")}) for name in parts}
        self.start = np.concatenate([part.get("GetContinuousStates") for part in parts.values()])
        self.ends = np.cumsum([0, *(len(part.states) for part in parts.values())])
        self.large = np.array([scale(part.file, v.name, 0.0) for part in parts.values() for v in part.states])

    def rates(self, x: Array) -> Array:
        """The derivatives of all states `x`; `values` has the signals then."""
        for _ in range(len(self.parts) + 1):  # a signal passes through at most all components
            for i, (name, part) in enumerate(self.parts.items()):
                part.put(np.array(x[self.ends[i]:self.ends[i + 1]]))
                part.instance.set({target: link.factor * self.values[link.source] + link.offset
                                   for target, link in self.inputs[name].items()})
                shown = part.instance.get(self.outputs[name])
                self.values.update((f"{name}.{output}", value) for output, value in zip(self.outputs[name], shown))
        return np.concatenate([part.rates() for part in self.parts.values()])

    def linear(self, name: str) -> StateSpace:
        """One component where it is, from its connected inputs to its connected outputs."""
        return self.parts[name].linear(list(self.inputs[name]), self.outputs[name])

    def jacobian(self) -> Array:
        """The Jacobian of the rates by all states, where the loop is."""
        linear = [self.linear(name) for name in self.parts]
        A, B, C, D = (scipy.linalg.block_diag(*(getattr(part, word) for part in linear)) for word in "ABCD")
        shown = [f"{name}.{output}" for name in self.parts for output in self.outputs[name]]
        K = np.zeros((B.shape[1], C.shape[0]))
        for i, link in enumerate(link for name in self.parts for link in self.inputs[name].values()):
            if link.source in shown:
                K[i, shown.index(link.source)] = link.factor
        return A + B @ K @ np.linalg.solve(np.eye(len(D)) - D @ K, C)

    def solve(self, x: Array, wanted: Array) -> Array:
        """The states near `x` whose rates are `wanted`. Raises RunError if they are not found."""
        for _ in range(STEPS):
            off = wanted - self.rates(x)
            change = self.large * np.linalg.lstsq(self.jacobian() * self.large, off, rcond=1e-12)[0]
            if not np.isfinite(change).all():
                break
            x = x + change
            if (np.abs(change) <= ARRIVED * np.maximum(np.abs(x), self.large)).all():
                return x
        raise RunError("no equilibrium of its equations was found, either")
