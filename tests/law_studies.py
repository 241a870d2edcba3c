"""Studies of the resilient law: flights with independent groups, and what each of its parts is there for."""
from types import SimpleNamespace

import numpy as np
from evidence import GROUPS, Loaded, Values, fly, summary
from studies import NOISE

from ahv_plant_fmu.vehicle import COEFFICIENTS
from cosim.master.flight import Flight

LAG = {"elevator_bandwidth": 30.0, "elevator_rate_limit": np.radians(60)}
DEG = np.pi / 180
PLANT = {name: value for name, _, value, _ in COEFFICIENTS}

# The four flexible structures of preset `coupled`: parameters of the plant.
STRUCTURES: dict[str, dict[str, float]] = {
    "decoupled": {},
    "printed sign": {"psi_1": -363.5, "psi_2": 328.8},
    "mode 1 turned": {"psi_1": 363.5, "psi_2": 328.8},
    "energy-consistent": {"psi_1": -363.5, "psi_2": 328.8, "coupling_sign": -1.0},
}

# What is left out -> the gains that leave it out of preset `quiet`, and a flight that is lost without it: a draw of
# `independent(18, ...)`, on which plant, lost or missed (by more than 20 ft). None: noise or `together` shows it.
PARTS: dict[str, tuple[dict[str, float | bool], tuple[int, str, str] | None]] = {
    "nothing": ({}, None),
    "lift scale": ({"filter_lift": 1e-9}, (0, "plain", "missed")),
    "pitch disturbance and moment scale": ({"filter_moment": 1e-9, "moment_gain": 0.0}, (2, "plain", "missed")),
    "moment scale": ({"moment_gain": 0.0}, (46, "lagged", "lost")),
    "slow bias of the holding elevator": ({"hold_rate": 50.0}, (25, "plain", "lost")),
    "limited approach to the stop": ({"k_barrier": 1000.0}, (9, "plain", "lost")),
    "thrust's share of the pitching": ({"elevator_band": 90 * DEG}, (9, "lagged", "lost")),
    "limited recovery of velocity": ({"V_recovery": 1000.0}, (25, "plain", "missed")),
    "model of the servo": ({"servo_rate": 0.0, "servo_speed": 1000.0}, (23, "lagged", "missed")),
    "prediction of the lift scale": ({"lift_lead": 0.0}, None),
    "filter of the altitude": ({"filter_h": 0.0}, None),
    "filter of the path angle": ({"filter_gamma": 2 * 23.0}, None),
    "filter of the lift scale": ({"filter_lift": 0.0}, None),
    "filter of the pitch disturbance": ({"filter_moment": 0.0}, None),
    "V and Q as observed": ({"measured_rates": True}, None),
}


def independent(seed: int, count: int) -> list[Values]:
    """Case 1's or 2's coefficients, every group with a phase of its own: values for `count` flights."""
    phases = np.random.default_rng(seed).uniform(-np.pi, np.pi, (count, len(GROUPS)))
    return [{"scenario": {f"scale_{group}_sine_phase": float(phase) for group, phase in zip(GROUPS, row)}}
            for row in phases]


def flights(count: int, form: str | None = "quiet", case: str = "case1", plant: Values | None = None, seed: int = 18,
            stop: float | None = None, gains: Values | None = None, law: str = "resilient") -> list[Flight]:
    """Flights with independent groups; `plant` has parameters of the instrumented plant, `gains` of the law."""
    with Loaded(law, form, "instrumented" if plant else "ideal") as loaded:
        return [loaded.fly(case, {**values, "plant": plant or {}, "controller": gains or {}}, stop=stop)
                for values in independent(seed, count)]


def modes(factor: float) -> dict[str, float]:
    """The plant's parameters with the frequencies of both modes times `factor`."""
    return {name: factor * PLANT[name] for name in ("omega_1", "omega_2")}


def apart(first: float, second: float) -> dict[str, float]:
    """The plant's parameters with the generalised force N1 times `first` and N2 times `second`."""
    return {name: (first if name.startswith("N1") else second) * PLANT[name]
            for name in PLANT if name.startswith(("N1_", "N2_"))}


def without(part: str, count: int) -> SimpleNamespace:
    """`count` flights of Case 1 without a part: summaries as they are and lagged; travel in full noise (deg); altitude
    errors with all groups together (ft, Case 1 and 2)."""
    gains = PARTS[part][0]
    plain, lagged = ([summary(f) for f in flights(count, plant=plant, gains=gains)] for plant in (None, LAG))
    noisy = summary(fly("case1", "resilient", values={"controller": gains, "plant": NOISE}, plant="instrumented"))
    together = [summary(fly(case, "resilient", values={"controller": gains})) for case in ("case1", "case2")]
    return SimpleNamespace(plain=plain, lagged=lagged, travel=noisy.travel, together=[one.h for one in together])
