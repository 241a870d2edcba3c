"""Flights of the native FMU files for the evidence: the loop wired as the command line does, by one function."""
from dataclasses import replace

from cosim import scenarios
from cosim.cli import planned
from cosim.flight import Flight
from cosim.flight import fly as fly_system


def fly(case: str, law: str = "neural", preset: str = "calibrated", values: dict | None = None,
        plant: str = "ideal", step: float = 0.01, stop: float | None = None) -> Flight:
    """A scenario flown by `law` with its preset; `values` has parameters per component, set last."""
    plan = scenarios.load(case)
    system = planned(plan, law, {**plan.presets, "controller": preset}, "native", [], plant)
    components = tuple(c.with_values((values or {}).get(c.name, {})) for c in system.components)
    return fly_system(replace(system, components=components), step, plan.stop if stop is None else stop)
