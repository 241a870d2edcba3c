"""A loop flown to its equilibrium, and what its components answer there, each alone, to a small pulse on an input.

Nothing is asked of an FMU but fmi2DoStep; one that can save its state is restored, any other flown again from the start.
"""
from contextlib import closing
from dataclasses import dataclass

import numpy as np

from ..errors import RunError
from ..master import program as P
from ..master.algorithms.base import chosen_order, turn
from ..master.fmu import DISCARD, FmuFile
from ..master.loaded import Master
from ..master.system import System

Array = np.ndarray
LOOKS = 20             # at whether the loop is at rest, on the way to `settle`
AT_REST = 1e-6         # of a signal's scale: what it may move between two looks
SIZES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)  # of a pulse, in the input's scale; the largest that is small enough counts
SMALL_ENOUGH = 1e-4    # by how much an answer may differ from twice that to half the pulse
NOISE = 1e-9           # of an output's scale: a difference that does not matter
SHORTEST = 20          # ticks of an answer that are needed
ZERO = 1e-9            # a value at rest that says nothing of how large a variable is


@dataclass(frozen=True)
class Rest:
    """A system that is at rest after `ticks` steps of `step` (s); `values` has its signals by name then."""
    system: System
    files: dict[str, FmuFile]
    step: float
    ticks: int
    stop: float
    values: dict[str, float]


@dataclass(frozen=True)
class Answers:
    """What a component's outputs answer to a pulse of one tick, of size 1, on each input: `values` and how far they may
    be off, both of shape (ticks, outputs, inputs), the first row at the end of the pulse."""
    inputs: list[str]
    outputs: list[str]
    values: Array
    errors: Array


def in_turn(master: Master) -> Array:
    """The program of a tick: Gauss-Seidel."""
    return P.program(r for part in chosen_order(master, None) for r in turn(master, part, False))


def scale(file: FmuFile, name: str, value: float) -> float:
    """What is large for a variable: its nominal value, or else its value at rest, or else 1."""
    nominal = file.variable(name).nominal
    return abs(float(nominal)) if nominal else abs(value) if abs(value) > ZERO else 1.0


def at_rest(system: System, files: dict[str, FmuFile], watched: list[str], step: float, settle: float,
            horizon: int) -> Rest:
    """Fly `system` until the signals `watched` are at rest, at most `settle` seconds.

    Raises RunError if they are not by then, or if an FMU refuses a step on the way.
    """
    ticks = max(2, round(settle / LOOKS / step))
    stop = (LOOKS * ticks + horizon + 1) * step
    with closing(Master(system, files)) as master:
        master.initialise(0.0, stop)
        program, names = in_turn(master), [c.name for c in master.columns]
        columns = [names.index(name) for name in watched]
        rows, times = np.empty((ticks, len(names))), np.empty(ticks)
        for look in range(LOOKS):
            master.cursor[:3] = 0
            status = master.attempt(program, look * ticks, ticks, 0.0, step, rows, times, 1)
            try:
                master.check(status, program, 0.0, step)
            except RunError as error:
                raise RunError(f"The loop departs before it is at rest: {error}") from None
            moved, values = np.ptp(rows[:, columns], axis=0), rows[-1, columns]
            large = np.array([max(abs(value), scale(files[component], variable, value)) for name, value in
                              zip(watched, values) for component, _, variable in [name.partition(".")]])
            if (moved <= AT_REST * large).all():
                return Rest(system, files, step, (look + 1) * ticks, stop, dict(zip(names, rows[-1].tolist())))
    worst = int(np.argmax(np.nan_to_num(moved / large, nan=np.inf)))
    raise RunError(f"The loop does not settle within {settle:g} s: {watched[worst]} = {values[worst]:.6g} still moves by "
                   f"{moved[worst]:.3g} in {ticks * step:g} s.")


class Alone:
    """One component of a system at rest, flown alone, the inputs held as they are. Use as a context manager."""

    def __init__(self, rest: Rest, component: str, outputs: list[str], horizon: int):
        self.rest, self.component, self.outputs, self.horizon = rest, component, outputs, horizon
        self.kept: Master | None = None  # at rest, the component's state saved

    def __enter__(self) -> "Alone":
        return self

    def __exit__(self, *_: object) -> None:
        if self.kept:
            self.kept.close()

    def load(self) -> Master:
        """The system at rest, by flying it there."""
        master = Master(self.rest.system, self.rest.files)
        try:
            master.initialise(0.0, self.rest.stop)
            master.run(in_turn(master), 0, self.rest.ticks, 0.0, self.rest.step)
        except BaseException:
            master.close()
            raise
        return master

    def fly(self, name: str, size: float) -> Array:
        """The outputs after each tick, shape (ticks, outputs); on the first, `size` is added to the input `name`. Fewer
        ticks than asked for where the FMU refuses one."""
        rest, master = self.rest, self.kept
        if master:
            part = master.number[self.component]
            master.run(P.program([P.row(P.RESTORE, part)]), 0, 1, 0.0, 0.0)
            master.put_back(self.at_rest)
        else:
            master = self.load()
            part = master.number[self.component]
            if master.instances[part].cosimulation.canGetAndSetFMUstate:
                master.run(P.program([P.row(P.SAVE, part)]), 0, 1, 0.0, 0.0)
                self.at_rest = master.snapshot()
        names = [c.name for c in master.columns]
        rows, times = np.empty((self.horizon, len(names))), np.empty(self.horizon)
        program = P.program(turn(master, part, False))
        places = [int(master.wiring.groups[g.number, P.FIRST]) + g.names.index(name)
                  for g in master.wiring.inputs[part] if name in g.names]
        master.cursor[:3] = 0
        offset, master.wiring.offset[places] = master.wiring.offset[places], master.wiring.offset[places] + size
        status = master.attempt(program, rest.ticks, 1, 0.0, rest.step, rows, times, 1)
        master.wiring.offset[places] = offset
        if status == 0:
            status = master.attempt(program, rest.ticks + 1, self.horizon - 1, 0.0, rest.step, rows, times, 1)
        self.kept = master if status <= DISCARD and master.wiring.states[part] else None
        flown = int(master.cursor[2])
        if self.kept is None:
            master.close()
        return rows[:flown, [names.index(f"{self.component}.{output}") for output in self.outputs]]


def answers(rest: Rest, component: str, inputs: list[str], needed: list[str], horizon: int) -> Answers:
    """Fly `component` of a system at rest alone for `horizon` ticks, its inputs held as they are but for a pulse on one
    of them. The outputs are those `needed`, and of all others that are continuous those that answer in proportion.

    The pulse goes either way, and once more with half the size: what then differs by more than a factor of 2 (of 4,
    where it does not follow the pulse's sign) is not linear. Answers end where that gets too large, as those of
    something unstable must. Raises RunError where a needed output does not answer even the smallest pulse in
    proportion.
    """
    file, links = rest.files[component], {link.target: link for link in rest.system.connections}
    outputs = needed + [n for n in file.names("output") if n not in needed and continuous_real(file, n)]
    found, good = [], np.ones(len(outputs), bool)
    with Alone(rest, component, outputs, horizon) as alone:
        still = alone.fly("", 0.0)
        large = np.array([scale(file, name, value) for name, value in zip(outputs, still[0])])
        for name in inputs:
            link = links[f"{component}.{name}"]
            unit = scale(file, name, link.factor * rest.values[link.source] + link.offset)
            tried = []
            for size in SIZES:
                values, errors = answer(alone, name, size * unit, still)
                fits = proportional(values, errors, NOISE * large / (size * unit))
                in_all = np.flatnonzero(fits[:, :len(needed)].all(axis=1))
                kept = int(in_all[-1]) + 1 if len(in_all) else 0
                tried.append((values[:kept], errors[:kept], fits[kept - 1]))
                if kept > horizon // 5:
                    break
            values, errors, fit = max(tried, key=lambda one: len(one[0]))
            if len(values) < min(SHORTEST, horizon):
                raise RunError(f"{component} ({file.path.name}) cannot be linearised: it does not answer a change of "
                               f"{name} by {SIZES[-1] * unit:.3g} in proportion, as at a limit or a switch.")
            found.append((values, errors))
            good &= fit
    kept = min(len(values) for values, _ in found)
    return Answers(inputs, [n for n, fits in zip(outputs, good) if fits],
                   *(np.stack([part[:kept, good] for part in parts], axis=2) for parts in zip(*found)))


def continuous_real(file: FmuFile, name: str) -> bool:
    """Whether a variable is a Real that may change at any time."""
    variable = file.variable(name)
    return variable.type == "Real" and variable.variability in (None, "continuous")


def answer(alone: Alone, name: str, size: float, still: Array) -> tuple[Array, Array]:
    """The outputs' answer to a pulse of `size`, for a size of 1, and how far it may be off; shape (ticks, outputs)."""
    flights = [alone.fly(name, part * size) for part in (1.0, -1.0, 0.5, -0.5)]
    length = min(len(flight) for flight in (*flights, still))
    up, down, half_up, half_down = (flight[:length] - still[:length] for flight in flights)
    odd, half_odd = (up - down) / 2, half_up - half_down
    values = half_odd + (half_odd - odd) / 3  # without the part of third order
    return values / size, (np.abs(odd - half_odd) + np.abs((up + down) / 2 - 2 * (half_up + half_down))) / size


def proportional(values: Array, errors: Array, negligible: Array) -> Array:
    """Whether each output answers in proportion until each tick, shape (ticks, outputs)."""
    reached = np.maximum.accumulate(np.abs(values), axis=0)
    return np.maximum.accumulate(errors, axis=0) <= np.maximum(SMALL_ENOUGH * reached, negligible)
