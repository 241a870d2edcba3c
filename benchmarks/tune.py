"""Tunes a control law: the same flights, the same cost, the same budget for either law.

    .venv/bin/python benchmarks/tune.py neural       --start steady
    .venv/bin/python benchmarks/tune.py backstepping --start stable
    .venv/bin/python benchmarks/tune.py neural       --start FILE.json --sigma 0.15 --seed 2   # what it printed

Flies the native FMU files through `cosim` and prints the best gains found, as JSON. CMA-ES (Hansen) on
the logarithms of the gains; a gain that may have either sign is taken as it is, in units of SIGNED.

The cost adds, over all flights of FLIGHTS, weight times the sum of TARGETS' ratios: altitude error (largest, rms),
velocity error (largest), elevator travel, each over its target; a ratio counts as it is up to 4 and by its
logarithm from there on. A flight that departs costs 100, and up to 100 more the earlier it does.
"""
import argparse
import json
import sys
import time
from dataclasses import dataclass, field
from math import exp, log, pi
from pathlib import Path
from typing import Any

import numpy as np

from cosim.errors import RunError
from cosim.master.algorithms import method
from cosim.master.flight import fly_loaded, tick_count
from cosim.master.fmu import FmuFile
from cosim.master.loaded import Master, open_files
from cosim.master.system import Component
from cosim.vehicle.closed_loop import fmu_path, wired
from cosim.vehicle.metrics import metrics
from cosim.vehicle.registry import LAWS

FREE = {
    "neural": ["kV1", "kV2", "k_gamma", "kh", "kh1", "mu", "c_theta", "c_Q", "pitch_rate_gain", "R", "R_d",
               "a2", "a3", "a4", "lambda_1", "lambda_2"],
    "backstepping": ["kV1", "kV2", "observer_V", "k_gamma", "k_path", "k_theta", "k_Q", "observer_gamma",
                     "observer_Q", "R_gamma", "R_theta", "R_Q"],
}
SIGNED = {"c_theta": 1e-3}
# The rival's start: the gains of largest decay rate (0.47 1/s, slowest of the linearised loop at 0.6, 1 and 1.4
# times every coefficient), by CMA-ES on `fmus.linearize`. The neural law starts from its preset `steady`.
STABLE = {
    "kV1": 1.6153, "kV2": 0.7929, "observer_V": 2.3962, "k_gamma": 1.265, "k_path": 0.7032, "k_theta": 0.6205,
    "k_Q": 1.768, "observer_gamma": 0.6733, "observer_Q": 47.5476, "R_gamma": 2.9948, "R_theta": 10.604, "R_Q": 29.4957,
}
GROUPS = ("thrust", "lift", "drag", "moment", "forces")
LIMITS = {**dict.fromkeys(("R", "R_d", "R_gamma", "R_theta", "R_Q"), 900.0),
          **dict.fromkeys(("observer_V", "observer_gamma", "observer_Q"), 900.0),
          **dict.fromkeys(("a2", "a3", "a4"), 100.0)}
FAST = {"plant": {"internal_step": 0.01}, "controller": {"internal_step": 0.01}}  # 1e-6 of the figures, half the time
ENOUGH = 4.0


@dataclass(frozen=True)
class Flown:
    """One flight of the cost: scenario preset and values over it, communication step and stop (s), weight,
    and what the figures are divided by (ft, ft, ft/s, deg)."""
    preset: str
    step: float
    stop: float
    weight: float
    targets: tuple[float, float, float, float]
    values: dict[str, float] = field(default_factory=dict)
    plant: dict[str, float] = field(default_factory=dict)


def independent(seed: int, amplitude: float) -> dict[str, float]:
    """Case 1 with every group scaled by a sinusoid of its own: sign, angular frequency 0.1-0.5 rad/s, phase."""
    rng = np.random.default_rng(seed)
    return {f"scale_{group}_{key}": float(value) for group in GROUPS for key, value in (
        ("sine", amplitude * rng.choice((-1, 1))), ("sine_omega", rng.uniform(0.1, 0.5)),
        ("sine_phase", rng.uniform(-pi, pi)))}


def constant(scale: float) -> dict[str, float]:
    """Every group scaled by the same constant."""
    return {f"scale_{group}_{key}": value for group in GROUPS for key, value in (("base", scale), ("sine", 0.0))}


FLIGHTS = [
    Flown("case1", 0.01, 100.0, 1.0, (2.5, 0.5, 0.6, 80.0)),
    Flown("case2", 0.01, 300.0, 2.0, (2.5, 0.5, 0.6, 170.0)),
    Flown("case2", 0.05, 300.0, 0.5, (2.5, 0.5, 0.6, 170.0)),
    *(Flown("case1", 0.02, 100.0, 0.25, (5.0, 1.0, 1.2, 100.0), independent(seed, 0.3)) for seed in range(4)),
    *(Flown("case1", 0.02, 100.0, 0.5, (5.0, 1.0, 1.2, 100.0), constant(scale)) for scale in (0.85, 1.3)),
]

PSI = {"psi_1": -363.5, "psi_2": 328.8}
STRUCTURES: tuple[dict[str, float], ...] = (PSI, {**PSI, "coupling_sign": -1.0}, {**PSI, "psi_1": 363.5}, {})
COUPLED = [Flown(case, 0.01, stop, weight, (5.0, 1.5, 1.2, travel), {}, structure)
           for case, stop, weight, travel in (("case1", 100.0, 1.0, 80.0), ("case2", 300.0, 2.0, 170.0))
           for structure in STRUCTURES]
SETS = {"decoupled": FLIGHTS, "coupled": COUPLED}


class Bench:
    """The closed loop, loaded once and reset for every flight."""

    def __init__(self, law: str, preset: str, flights: str = "decoupled"):
        self.flights = SETS[flights]
        fmus = {"scenario": "AhvScenario", "controller": LAWS[law].fmu, "plant": "AhvPlant"}
        self.paths = {name: fmu_path("native", model) for name, model in fmus.items()}
        self.presets = {flight.preset: preset_of(self.paths["scenario"], flight.preset) for flight in self.flights}
        self.base = preset_of(self.paths["controller"], preset)
        self.files = open_files(self.system(self.flights[0], {}))
        self.master = Master(self.system(self.flights[0], {}), self.files.__enter__())
        self.method = method("gauss-seidel")

    def system(self, flight: Flown, gains: dict[str, float]) -> Any:
        values = {"scenario": {**self.presets[flight.preset], **flight.values},
                  "controller": {**self.base, **FAST["controller"], **gains},
                  "plant": {**FAST["plant"], **flight.plant}}
        return wired(*(Component(name, self.paths[name], values[name])
                             for name in ("scenario", "controller", "plant")))

    def fly(self, flight: Flown, gains: dict[str, float]) -> Any:
        self.master.reset(self.system(flight, gains))
        return fly_loaded(self.master, self.method, flight.step, tick_count(flight.step, flight.stop))

    def cost(self, gains: dict[str, float]) -> float:
        total = 0.0
        for flight in self.flights:
            try:
                flown = self.fly(flight, gains)
            except RunError:
                return 1e4
            if not flown.finished:
                total += flight.weight * (200.0 - 100.0 * float(flown.time[-1]) / flight.stop)
                continue
            m = metrics(flown)
            figures = (m["altitude_error_ft"]["max_abs"], m["altitude_error_ft"]["rms"],
                       m["velocity_error_fps"]["max_abs"], m["elevator_deg"]["travel"])
            total += flight.weight * sum(ratio(f / t) for f, t in zip(figures, flight.targets))
        return total


def ratio(r: float) -> float:
    return r if r < ENOUGH else ENOUGH + log(r / ENOUGH)


def preset_of(path: Any, name: str) -> dict[str, Any]:
    file = FmuFile.open(path)
    try:
        return file.preset(name)
    finally:
        file.close()


def encoded(gains: dict[str, float], names: list[str]) -> list[float]:
    return [gains[n] / SIGNED[n] if n in SIGNED else log(max(gains[n], 1e-6)) for n in names]


def decoded(x: Any, names: list[str]) -> dict[str, float]:
    return {n: float(v) * SIGNED[n] if n in SIGNED else min(exp(float(v)), LIMITS.get(n, 1e9))
            for n, v in zip(names, x)}


def tune(law: str, start: str, flights: str, evaluations: int, sigma: float, seed: int) -> dict[str, Any]:
    """The best gains found within the budget, their cost, and the start's."""
    import cma

    names = FREE[law] if flights == "decoupled" else [*FREE[law], "kV", "elevator_bandwidth"]
    given = {"stable": STABLE} if start == "stable" else {}
    if start.endswith(".json"):
        given = {start: json.loads(Path(start).read_text())["gains"]}
    bench = Bench(law, "calibrated" if given else start, flights)
    gains = {**bench.base, **given.get(start, {})}
    search = cma.CMAEvolutionStrategy(encoded(gains, names), sigma,
                                      {"seed": seed, "verbose": -9, "maxfevals": evaluations})
    began, first = time.perf_counter(), bench.cost({n: gains[n] for n in names})
    try:
        while not search.stop():
            candidates = search.ask()
            search.tell(candidates, [bench.cost(decoded(x, names)) for x in candidates])
            print(f"{search.countevals} flown, best cost {search.best.f:.3f}, {time.perf_counter() - began:.0f} s",
                  file=sys.stderr, flush=True)
    except KeyboardInterrupt:
        pass  # the best until then
    best = {n: float(f"{v:.4g}") for n, v in decoded(search.best.x, names).items()}
    return {"law": law, "start": start, "flights": flights, "evaluations": search.countevals, "seed": seed,
            "sigma": sigma, "cost_of_start": first, "cost": bench.cost(best), "gains": best}


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("law", choices=list(FREE))
    parser.add_argument("--start", default="calibrated",
                        help="a preset of the law, stable (backstepping), or a file with what this script printed")
    parser.add_argument("--flights", choices=list(SETS), default="decoupled", help="coupled: neural only")
    parser.add_argument("--evaluations", type=int, default=1000)
    parser.add_argument("--sigma", type=float, default=0.3)
    parser.add_argument("--seed", type=int, default=1)
    print(json.dumps(tune(**vars(parser.parse_args())), indent=2))
