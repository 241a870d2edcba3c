"""Flights of the native FMU files for the evidence: the loop wired as the command line does."""
from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np

from cosim.master.algorithms import method
from cosim.master.flight import Flight
from cosim.master.fly import fly as fly_system
from cosim.master.fly import fly_loaded, tick_count
from cosim.master.loaded import Master, open_files
from cosim.master.system import System
from cosim.vehicle import scenarios
from cosim.vehicle.closed_loop import closed_loop
from cosim.vehicle.metrics import metrics

GROUPS = ("thrust", "lift", "drag", "moment", "forces")
DEPARTED = 100.0  # ft: with a larger altitude error, a flight counts as lost
Values = dict[str, dict]


@cache
def system(case: str, law: str, preset: str, plant: str) -> System:
    return closed_loop(scenarios.load(case), law, plant, presets={"controller": preset} if preset else {}).system


def with_values(base: System, values: Values) -> System:
    return replace(base, components=tuple(c.with_values(values.get(c.name, {})) for c in base.components))


def fly(case: str, law: str = "neural", preset: str | None = None, values: Values | None = None,
        plant: str = "ideal", step: float = 0.01, stop: float | None = None) -> Flight:
    """A scenario flown by `law` with its preset; `values` has parameters per component, set last."""
    stop = scenarios.load(case).stop if stop is None else stop
    return fly_system(with_values(system(case, law, preset, plant), values or {}), step, stop)


class Loaded:
    """The same for many flights: the FMUs are loaded once and reset for each."""

    def __init__(self, law: str = "neural", preset: str | None = None, plant: str = "ideal"):
        self.law, self.preset, self.plant = law, preset, plant
        first = system("hold", law, preset, plant)
        self.files = open_files(first)
        self.master = Master(first, self.files.__enter__())
        self.method = method("gauss-seidel")

    def fly(self, case: str, values: Values | None = None, step: float = 0.01, stop: float | None = None) -> Flight:
        stop = scenarios.load(case).stop if stop is None else stop
        self.master.reset(with_values(system(case, self.law, self.preset, self.plant), values or {}))
        return fly_loaded(self.master, self.method, step, tick_count(step, stop))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.master.close()
        self.files.__exit__(None, None, None)


def summary(flight: Flight) -> SimpleNamespace:
    """survived, then altitude error (largest, rms; ft), velocity error (largest; ft/s), travel (deg), saturated (s)."""
    m = metrics(flight)
    return SimpleNamespace(
        survived=flight.finished and m["altitude_error_ft"]["max_abs"] < DEPARTED,
        h=m["altitude_error_ft"]["max_abs"], h_rms=m["altitude_error_ft"]["rms"],
        V=m["velocity_error_fps"]["max_abs"], travel=m["elevator_deg"]["travel"],
        low=m["elevator_deg"]["min"], high=m["elevator_deg"]["max"],
        saturated=flight.course("controller.elevator_saturated").time_on())


def constant(seed: int, amplitude: float) -> dict[str, float]:
    """Every group at a constant factor of its own, 1 +- amplitude."""
    rng = np.random.default_rng(seed)
    return {f"scale_{group}_{key}": value for group in GROUPS
            for key, value in (("base", float(rng.uniform(1 - amplitude, 1 + amplitude))), ("sine", 0.0))}


def varying(seed: int, amplitude: float) -> dict[str, float]:
    """Every group at a sinusoid of its own: sign, angular frequency 0.1-0.5 rad/s, phase."""
    rng = np.random.default_rng(seed)
    return {f"scale_{group}_{key}": float(value) for group in GROUPS for key, value in (
        ("sine", amplitude * rng.choice((-1, 1))), ("sine_omega", rng.uniform(0.1, 0.5)),
        ("sine_phase", rng.uniform(-np.pi, np.pi)))}
