"""What `ahv tune` flies, as data, and what a flight costs."""
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import log1p, pi
from typing import NamedTuple

import numpy as np

from ..errors import RunError
from ..master.algorithms import method
from ..master.flight import Flight
from ..master.fly import fly_loaded, tick_count
from ..master.fmu import FmuFile
from ..master.kept import Kept
from ..master.system import System, Value
from .closed_loop import Values, merged
from .metrics import ALTITUDE_ERROR, metrics
from .scenarios import GROUPS
from .signals import course

LOST_FT = 100.0                      # with a larger altitude error the vehicle counts as lost
EASE = 0.05                          # weight of elevator travel and speed error beside the altitude error
TRAVEL_DEG, SPEED_FPS = 100.0, 10.0  # what these two are measured by
QUICK = 0.01                         # s, internal step while tuning: 1e-6 of the figures, half the time
SHOWN = {"scenario": ("V_command", "h_command"), "plant": ("V", "h"),  # what the cost needs, where an FMU shows it
         "controller": ("elevator", "fuel_ratio", "V_reference", "h_reference")}


@dataclass(frozen=True)
class Flown:
    """One flight: a scenario to `stop` (s) in steps of `step` (s) with `values`; an altitude error of `scale` (ft) is
    neither good nor bad; `weight` counts where no draws are flown."""
    scenario: str
    stop: float
    scale: float
    step: float = 0.01
    weight: float = 1.0
    values: Values = field(default_factory=dict)


@dataclass(frozen=True)
class FlightSet:
    """`fixed` flights, and flights that uncertain vehicles are flown in: draw k in `drawn`[k modulo its length]."""
    fixed: tuple[Flown, ...]
    drawn: tuple[Flown, ...] = ()


PSI = {"psi_1": -363.5, "psi_2": 328.8}
STRUCTURES: tuple[dict[str, Value], ...] = ({}, {**PSI}, {**PSI, "psi_1": 363.5}, {**PSI, "coupling_sign": -1.0})
CASES = (("case1", 100.0), ("case2", 300.0))
SETS = {
    # Vehicles whose groups err each on its own. Case 1's coefficients have been everywhere after 40 s; in Case 2 they
    # jump at 50 and, while the altitude command falls, at 100 s.
    "independent": FlightSet(tuple(Flown(case, stop, 5.0, weight=0.1) for case, stop in CASES),
                             (Flown("case1", 40.0, 20.0), Flown("case1", 40.0, 20.0), Flown("case2", 120.0, 20.0))),
    # The paper's own reading: all groups together; Case 2 also at a long step.
    "together": FlightSet((*(Flown(case, stop, 2.5) for case, stop in CASES), Flown("case2", 300.0, 2.5, 0.05, 0.5))),
    # The same on each flexible structure.
    "structures": FlightSet(tuple(Flown(case, stop, 5.0, values={"plant": dict(structure)})
                                  for case, stop in CASES for structure in STRUCTURES)),
}


class Figures(NamedTuple):
    """A flight's cost, whether the vehicle was kept, altitude and speed error (largest; ft, ft/s), travel (deg)."""
    cost: float
    kept: bool
    h: float
    V: float
    travel: float


def vehicles(flights: FlightSet, count: int, seed: int) -> list[Flown]:
    """Flights of `count` vehicles whose groups swing each with a phase of its own, uniform over the circle."""
    if not flights.drawn:
        return []
    phases = np.random.default_rng(seed).uniform(-pi, pi, (count, len(GROUPS)))
    return [replace(base, values=merged(base.values, {"scenario": {
                f"scale_{group}_sine_phase": float(phase) for group, phase in zip(GROUPS, row)}}))
            for k, row in enumerate(phases) for base in [flights.drawn[k % len(flights.drawn)]]]


def figures(flight: Flight, flown: Flown) -> Figures:
    """The cost of a flight, and what it is made of.

    With the largest altitude error e it is log(1 + (e/scale)^2), and EASE times log(1 + travel/TRAVEL_DEG) +
    log(1 + speed error/SPEED_FPS). A vehicle that is lost costs what LOST_FT costs, and up to as much again the
    earlier it is lost.
    """
    error = course(flight, ALTITUDE_ERROR)
    beyond = np.flatnonzero(~(np.abs(error.values) < LOST_FT))
    found = metrics(flight)
    h, V, travel = (found["altitude_error_ft"]["max_abs"], found["velocity_error_fps"]["max_abs"],
                    found["elevator_deg"]["travel"])
    if len(beyond) or not flight.finished:
        at = float(error.time[beyond[0] if len(beyond) else -1])
        return Figures(log1p((LOST_FT / flown.scale)**2) * (2 - at / flown.stop), False, h, V, travel)
    ease = log1p(travel / TRAVEL_DEG) + log1p(V / SPEED_FPS)
    return Figures(log1p((h / flown.scale)**2) + EASE * ease, True, h, V, travel)


NOWHERE = Figures(2 * log1p(LOST_FT**2), False, float("inf"), float("inf"), float("inf"))  # a law that does not start


def seen(files: Mapping[str, FmuFile]) -> list[str]:
    """The signals that figures are computed from, as far as these FMUs have them."""
    return [f"{c}.{name}" for c, names in SHOWN.items() for name in names if name in files[c].variables]


class Bench:
    """The closed loops of a tuning, loaded once and reset for each flight; `systems` by their scenario."""

    def __init__(self, systems: Mapping[str, System]):
        self.systems = systems
        self.kept = Kept(record=seen)
        self.method = method("gauss-seidel")

    def fly(self, flown: Flown, gains: Mapping[str, float]) -> Figures:
        """One flight with `gains`."""
        values = merged(flown.values, {"controller": dict(gains)})
        base = self.systems[flown.scenario]
        system = replace(base, components=tuple(c.with_values(values.get(c.name, {})) for c in base.components))
        try:
            flight = fly_loaded(self.kept.ready(system), self.method, flown.step, tick_count(flown.step, flown.stop))
        except RunError:
            return NOWHERE
        return figures(flight, flown)

    def close(self) -> None:
        """Unload the FMUs."""
        self.kept.close()
