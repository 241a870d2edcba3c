"""A loop is flown to its equilibrium; there each component is flown alone and its answers to pulses are recorded.

The FMUs need no optional capability. One that can save its state is restored for each pulse; any other is loaded and
flown to the equilibrium again.
"""
from contextlib import closing
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.ndimage import maximum_filter1d

from ..errors import RunError
from ..master import program as P
from ..master.algorithms.base import chosen_order, turn
from ..master.fmu import FmuFile
from ..master.loaded import Master
from ..master.system import System
from .equations import state_variables

Array = np.ndarray
Tried = tuple[Array, Array, Array]  # values and errors of answers, and which outputs answer linearly
LOOKS = 20           # checks for rest until `settle`
EARLY = 20, 40       # ticks of two more checks before those
AT_REST = 1e-6       # largest change between two checks, relative to the signal's scale
STILL, SLOWER = 1e-11, 0.5  # a change that ends the flight at once; the part of the last change that ends it, too
SIZES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)  # of a pulse, relative to the input's scale, tried in this order
ENOUGH = 0.2         # a pulse is small enough if this share of the horizon is linear
LINEAR = 1e-4        # largest relative difference between an answer and twice that to half the pulse
NOISE = 1e-9         # differences below this, relative to the output's scale, are ignored
SHORTEST = 20        # ticks of a linear answer that are needed
AROUND = 51          # ticks whose largest error counts at each tick
SAFE = 3.0           # errors of an extrapolation are estimated by its last step
ROUNDED = 1e-15      # of a value: what the rounding of several flights adds up to
ZERO = 1e-9          # a signal that stays below this does not tell its scale


@dataclass(frozen=True)
class Rest:
    """A system that is at rest after `ticks` steps of `step` (s), with a stop time of `stop` (s).

    By component.variable: `values` of the outputs at rest, and `large`, the magnitude to which changes are compared.
    """
    system: System
    files: dict[str, FmuFile]
    step: float
    ticks: int
    stop: float
    values: dict[str, float]
    large: dict[str, float]


@dataclass(frozen=True)
class Answers:
    """A component's answers to a pulse on each input, one tick long and of size 1.

    `values` and `errors` (how far the values may be off) have the shape (ticks, outputs, inputs), in the units of
    output per input; the first row is at the end of the pulse. `states` are the continuous states of its equations at
    rest, by name; None if it has no model-exchange interface.
    """
    inputs: list[str]
    outputs: list[str]
    values: Array
    errors: Array
    states: dict[str, float] | None = None


def in_turn(master: Master) -> Array:
    """The program of a tick: Gauss-Seidel."""
    return P.program(r for part in chosen_order(master, None) for r in turn(master, part, False))


def scale(file: FmuFile, name: str, seen: float) -> float:
    """The magnitude of a variable: its nominal value, or else the largest value `seen`, or else 1."""
    nominal = file.variable(name).nominal
    return abs(nominal) if nominal else seen if seen > ZERO else 1.0


def at_rest(system: System, files: dict[str, FmuFile], watched: list[str], step: float, settle: float,
            horizon: int) -> Rest:
    """Fly `system` until the signals `watched` are at rest, at most `settle` seconds.

    Raises RunError if they are not by then, or if an FMU refuses a step on the way.
    """
    ticks = max(2, round(settle / LOOKS / step))
    early = [n for n in EARLY if n < ticks]  # an unstable loop that starts at rest does not stay there
    stop = (sum(early) + LOOKS * ticks + horizon + 1) * step
    with closing(Master(system, files)) as master:
        master.initialise(0.0, stop)
        program, names = in_turn(master), [c.name for c in master.columns]
        seen, flown, worst = np.zeros(len(names)), 0, np.inf
        columns = [names.index(name) for name in watched]
        for count in (*early, *[ticks] * LOOKS):
            rows, times = np.empty((count, len(names))), np.empty(count)
            master.cursor[:3] = 0
            status = master.attempt(program, flown, count, 0.0, step, rows, times, 1)
            flown += count
            try:
                master.check(status, program, 0.0, step)
            except RunError as error:
                raise RunError(f"The loop departs before it is at rest: {error}") from None
            seen = np.maximum(seen, np.abs(rows).max(axis=0))
            large = [scale(files[component], variable, most) for name, most in zip(names, seen)
                     for component, _, variable in [name.partition(".")]]
            moved = np.ptp(rows[:, columns], axis=0)
            share = np.nan_to_num(moved / np.maximum(np.abs(rows[-1]), large)[columns], nan=np.inf)
            before, worst = worst, share.max(initial=0.0)
            if worst <= STILL or (worst <= AT_REST and count == ticks and worst > SLOWER * before):
                break
    if worst <= AT_REST:
        return Rest(system, files, step, flown, stop, dict(zip(names, rows[-1].tolist())), dict(zip(names, large)))
    name = int(np.argmax(share))
    raise RunError(f"The loop does not settle within {settle:g} s: {watched[name]} = {rows[-1, columns[name]]:.6g} "
                   f"still moves by {moved[name]:.3g} in {ticks * step:g} s.")


class Alone:
    """One component of a system at rest, flown alone with its inputs held. Use as a context manager."""

    def __init__(self, rest: Rest, component: str, outputs: list[str], horizon: int):
        self.rest, self.component, self.outputs, self.horizon = rest, component, outputs, horizon
        self.kept: Master | None = None   # loaded, with the component's state at rest saved
        self.snapshot: list[Array] = []   # the signals at rest
        self.states: dict[str, float] | None = None

    def __enter__(self) -> "Alone":
        return self

    def __exit__(self, *_: object) -> None:
        if self.kept:
            self.kept.close()

    def load(self) -> Master:
        """The system, loaded and flown to its equilibrium. What a pulse has ended with Fatal is unpacked anew: of those
        files no function may be called any more."""
        for name, file in self.rest.files.items():
            if file.corrupted:
                self.rest.files[name] = FmuFile.open(file.path)
        master = Master(self.rest.system, self.rest.files)
        try:
            master.initialise(0.0, self.rest.stop)
            master.run(in_turn(master), 0, self.rest.ticks, 0.0, self.rest.step)
            file = self.rest.files[self.component]
            if file.description.model_exchange is not None and self.states is None:
                names = [v.name for v in state_variables(file)]
                self.states = dict(zip(names, master.instances[master.number[self.component]].get(names)))
        except BaseException:
            master.close()
            raise
        return master

    def fly(self, name: str, size: float) -> Array:
        """The outputs after each tick, shape (ticks, outputs), with `size` added to the input `name` in the first tick.

        There are fewer ticks than the horizon if the FMU refuses one.
        """
        rest, master = self.rest, self.kept
        if master:
            part = master.number[self.component]
            master.run(P.program([P.row(P.RESTORE, part)]), 0, 1, 0.0, 0.0)
            master.put_back(self.snapshot)
        else:
            master = self.load()
            part = master.number[self.component]
            if master.instances[part].claims("canGetAndSetFMUstate"):
                master.run(P.program([P.row(P.SAVE, part)]), 0, 1, 0.0, 0.0)
                self.snapshot = master.snapshot()
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
        self.kept = master if status in (P.OK, P.DISCARD) and master.wiring.states[part] else None
        flown = int(master.cursor[2])
        if self.kept is None:
            master.close()
        return rows[:flown, [names.index(f"{self.component}.{output}") for output in self.outputs]]


def answers(rest: Rest, component: str, inputs: list[str], needed: list[str], horizon: int) -> Answers:
    """The answers of one component of a system at rest, for `horizon` ticks. The outputs are those `needed`, then all
    other continuous outputs that answer linearly.

    Each pulse is flown with both signs, and again with half and a quarter of the size. From these the linear part is
    extrapolated; an answer with a kink does not bend as its size tells. Answers end where the deviation from that
    exceeds LINEAR, as an unstable component's must. The first size is taken that answers long enough; of those that
    answer to the end, the one before the errors grow again.

    Raises RunError if a needed output does not answer even the smallest pulse linearly.
    """
    file, links = rest.files[component], {link.target: link for link in rest.system.connections}
    outputs = needed + [n for n in file.names("output") if n not in needed and continuous_real(file, n)]
    found, good = [], np.ones(len(outputs), bool)
    with Alone(rest, component, outputs, horizon) as alone:
        still = alone.fly("", 0.0)
        large = np.array([rest.large[f"{component}.{name}"] for name in outputs])
        away = (np.abs(still - still[0]) / large)[:, :len(needed)].max(axis=1, initial=0.0)
        drift = np.maximum.accumulate(away)  # alone it leaves the rest that is none: its slopes change about as much
        for name in inputs:
            link = links[f"{component}.{name}"]
            unit = scale(file, name, abs(link.factor) * rest.large[link.source])
            best: Tried = np.empty((0, len(outputs))), np.empty((0, len(outputs))), good
            for size in SIZES:
                values, errors = answer(alone, name, size * unit, still)
                errors += drift[:len(values), None] * np.maximum.accumulate(np.abs(values), axis=0)
                fits = linear_until(values, errors, NOISE * large / (size * unit))
                in_all = np.flatnonzero(fits[:, :len(needed)].all(axis=1))
                kept = int(in_all[-1]) + 1 if len(in_all) else 0
                one = values[:kept], errors[:kept], fits[kept - 1] if kept else good
                if len(best[0]) == horizon and not (kept == horizon and better(one, best, len(needed))):
                    break
                best = one if kept >= len(best[0]) else best
                if ENOUGH * horizon <= len(best[0]) < horizon:
                    break
            values, errors, fit = best
            if len(values) < min(SHORTEST, horizon):
                raise RunError(f"{component} ({file.path.name}) cannot be linearised: its answer to a change of {name} "
                               f"by {SIZES[-1] * unit:.3g} is not linear, as at a limit or a switch.")
            found.append((values, errors))
            good &= fit
    kept = min(len(values) for values, _ in found)
    values, errors = (np.stack([part[:kept, good] for part in parts], axis=2) for parts in zip(*found))
    return Answers(inputs, [n for n, fits in zip(outputs, good) if fits], values, errors, alone.states)


def better(one: Tried, other: Tried, needed: int) -> bool:
    """Whether the first of two answers of the same length has smaller errors in the needed outputs."""
    first, second = (part[1][:, :needed].max(axis=0) for part in (one, other))
    reached = np.abs(other[0][:, :needed]).max(axis=0)
    told = reached > 0
    return bool((first[told] / reached[told]).max(initial=0) < (second[told] / reached[told]).max(initial=0))


def continuous_real(file: FmuFile, name: str) -> bool:
    """Whether a variable is a Real that may change at any time."""
    return file.variable(name).smooth


def answer(alone: Alone, name: str, size: float, still: Array) -> tuple[Array, Array]:
    """The outputs' answer to a pulse of `size`, divided by the size, and its errors; both (ticks, outputs)."""
    flights = [alone.fly(name, part * size) for share in (1.0, 0.5, 0.25) for part in (share, -share)]
    length = min(len(flight) for flight in (*flights, still))
    up, down = ([flight[:length] - still[:length] for flight in flights[first::2]] for first in (0, 1))
    odd = [(a - b) / 2 * 2**i for i, (a, b) in enumerate(zip(up, down))]
    even = [(a + b) / 2 * 4**i for i, (a, b) in enumerate(zip(up, down))]  # alike, but for their fourth-order part
    whole, half = (b + (b - a) / 3 for a, b in pairwise(odd))  # Richardson: no third-order part
    values = half + (half - whole) / 15                        # nor a fifth-order one
    bend = 16 * (even[1] - even[2]) - 4 * (even[0] - even[1])
    errors = maximum_filter1d(np.abs(values - half) + np.abs(bend) / 15, AROUND, axis=0)  # where it crosses 0, too
    return values / size, (SAFE * errors + ROUNDED * np.abs(still[:length])) / size


def linear_until(values: Array, errors: Array, negligible: Array) -> Array:
    """Whether each output's answer is linear up to each tick, shape (ticks, outputs)."""
    reached = np.maximum.accumulate(np.abs(values), axis=0)
    return np.maximum.accumulate(errors, axis=0) <= np.maximum(LINEAR * reached, negligible)
