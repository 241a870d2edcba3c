"""Experimental laws: the paper's law and its rival with the holdable angle of attack of `resilient` in front of them.

    .venv/bin/python benchmarks/protected_laws.py [FOLDER]      (builds them, else into results/laws)
    ahv run case1 --controller mine=results/laws/native/ProtectedNeural.fmu --preset tuned

The laws are those of `ahv_ctrl_fmu`, unchanged. The protection moves two limits that each of them has: the least
elevator and the largest fuel ratio. It has resilient's observers, with the gains of its preset `quiet`, and from them
the largest angle of attack A that can be held. The pitch acceleration that a law may ask for is at most

    protect_k_Q (gamma' at the elevator that holds alpha + protect_k_barrier (A - alpha) - Q)

The least elevator is the one that gives that. Where a law or this limit asks for more than the elevator's stop, the
fuel ratio is limited so that the thrust pitches instead. The laws' integrals and observers treat both as their own
limits. Preset `start` has the gains that tuning began with, `independent` those that `ahv tune` found for the law
alone, and `tuned` those that it found for law and protection together.
"""
import sys
from collections import namedtuple
from pathlib import Path
from types import ModuleType, SimpleNamespace

from ahv_ctrl_fmu import backstepping_model, neural_model
from ahv_ctrl_fmu import resilient as r
from ahv_ctrl_fmu.resilient_model import QUIET
from cosim.vehicle.registry import LAWS
from fmus.builder import build

OUT = Path("results") / "laws"
PROTECTION = {"protect_k_Q": QUIET["k_Q"], "protect_k_barrier": QUIET["k_barrier"],
              "protect_margin": QUIET["barrier_margin"]}
Limits = namedtuple("Limits", "elevator_least fuel_ratio_most alpha_limit")
ROWS = [
    ("elevator_least", "output", "rad", None, None, None, 0.1, "least elevator that the protection allows"),
    ("fuel_ratio_most", "output", "1", None, None, None, 1.0, "largest fuel ratio that the protection allows"),
    ("alpha_limit", "output", "rad", None, None, None, 0.01, "largest angle of attack that the elevator can hold"),
    ("protecting", "output", "1 discrete", None, 0.0, 1.0, 1.0, "1 while the elevator is at the protection's limit"),
    *((name, "parameter", unit, PROTECTION[name], 0.0, high, None, text) for name, unit, high, text in (
        ("protect_k_Q", "1/s", None, "pitch rate gain of the protection"),
        ("protect_k_barrier", "1/s", None, "rate at which the angle of attack may approach its limit"),
        ("protect_margin", "rad", 1.5, "elevator kept back from the stop"))),
]
OBSERVERS = 4 + r.FILTER + len(r.State._fields) - 3                     # numbers of its state
NUMBERS = 4 + len(r.SECTIONS) * r.COEFFICIENTS + 6 + len(r.Numbers._fields) - 5       # that depend on the step only

BEYOND = 1.5  # rad: an elevator without a stop

# `ahv tune NAME=FILE.fmu --preset start --evaluations 120`, with FILE.fmu as this script builds it.
TUNED = {
    "ProtectedNeural": {"tuned": {
        "kV1": 14.78, "kV2": 42.08, "k_gamma": 0.2011, "kh": 0.1145, "kh1": 14.05, "mu": 2.425, "c_theta": 0.001963,
        "c_Q": 0.002983, "pitch_rate_gain": 0.4052, "R": 74.07, "R_d": 3.73, "a2": 18.65, "a3": 5.865, "a4": 5.504,
        "lambda_1": 25.19, "lambda_2": 542.2, "protect_k_Q": 12.48, "protect_k_barrier": 0.9037,
        "protect_margin": 0.002249,
    }},
    "ProtectedBackstepping": {"tuned": {
        "kV1": 0.8174, "kV2": 7.718, "observer_V": 0.6361, "k_gamma": 2.311, "k_path": 0.618, "k_theta": 0.3835,
        "k_Q": 10.05, "observer_gamma": 0.3428, "observer_Q": 0.7766, "R_gamma": 0.2196, "R_theta": 10.21,
        "R_Q": 135.1, "protect_k_Q": 6.407, "protect_k_barrier": 1.031, "protect_margin": 0.005159,
    }},
}


def observing(p):
    """Parameters of resilient's functions: its preset `quiet` without a model of the servo, and the law's limits."""
    return SimpleNamespace(**{**vars(p), **QUIET, "servo_rate": 0.0})


def limits(m, s, now, p, wish):
    """What the protection allows, from the corrected state of the observers. `wish` is the elevator that the law asks
    for, as a function of parameters."""
    q = observing(p)
    per_elevator, aerodynamic = s.s_M * r.e * now.mu, s.s_M * now.mu * (now.c + r.v.CM_0)
    hold = (aerodynamic + s.n_bar) / per_elevator
    A = r.holdable_alpha(m, s, now, q, hold, p.protect_margin)
    Q_most = r.gamma_rate(now, now.T, hold, r.lift_scale(m, s, q)) + p.protect_k_barrier * (A - now.alpha)
    demand = p.protect_k_Q * (Q_most - s.Q) - aerodynamic - s.d_M
    least = (r.REST * now.T - demand) / per_elevator
    beyond = m.fmax(m.fmax(least, wish(moved(p, elevator_max=BEYOND))) - p.elevator_max, 0.0)
    most = s.fuel_ratio - beyond * per_elevator / (r.REST * now.slope)
    return Limits(m.clip(least, p.elevator_min, p.elevator_max),
                  m.where(beyond > 0, m.clip(most, p.fuel_ratio_min, p.fuel_ratio_max), p.fuel_ratio_max), A)


def moved(p, **others):
    """The parameters `p` with `others` in their place."""
    return SimpleNamespace(**{**vars(p), **others})


def within(p, found):
    """The law's parameters with its limits moved."""
    return moved(p, elevator_min=found.elevator_least, fuel_ratio_max=found.fuel_ratio_most)


def split(x):
    """The law's own state, the observers', and the limits of the last evaluation."""
    end = len(x) - len(Limits._fields)
    return x[:end - OBSERVERS], r.unpack(x[end - OBSERVERS:end]), Limits(*x[end:])


def module(name, law, **contents):
    """A model, see `fmus.interface`, that is `law` with other `contents`."""
    made = ModuleType(name)
    vars(made).update({"__file__": __file__, "__doc__": __doc__, "NAME": name, **contents})
    made.DESCRIPTION = f"{law.DESCRIPTION}; {made.DESCRIPTION}"
    return made


def protected(name, law, gains, retuned):
    """The model of `law` behind the protection. Its presets have the gains that `ahv tune` may change."""
    def wished(m, t, x, u):
        return lambda p: law.outputs(m, t, x, u, p)["elevator"]

    def prepare(m, p, h):
        return [*law.prepare(m, p, h), *r.prepare(m, observing(p), h)]

    def start(m, u, p):
        own, state = law.start(m, u, p), r.start(m, u, observing(p))
        s = r.unpack(state)
        return [*own, *state, *limits(m, s, r.measurements(m, s, u), p, wished(m, 0.0, own, u))]

    def advance(m, t, h, x, u, p, c):
        own, s, _ = split(x)
        q, k = observing(p), r.numbers_of(c[len(c) - NUMBERS:])
        now = r.measurements(m, s, u)
        s = r.slow_filters(r.moment_scale(m, r.observers(m, s, now, k), now, q, h, k), now, k)
        found = limits(m, s, now, p, wished(m, t, own, u))
        own = law.advance(m, t, h, own, u, within(p, found), c[:len(c) - NUMBERS])
        sent = law.outputs(m, t, own, u, within(p, found))
        s = s._replace(fuel_ratio=sent["fuel_ratio"], elevator=sent["elevator"], servo=sent["elevator"])
        return [*own, *r.pack(r.predicted(m, s, now, q, h, k)), *found]

    def outputs(m, t, x, u, p):
        own, _, found = split(x)
        shown = law.outputs(m, t, own, u, within(p, found))
        return {**shown, **found._asdict(), "protecting": m.both(found.elevator_least > p.elevator_min,
                                                                 shown["elevator"] <= found.elevator_least)}

    # Without `internal_step`: one evaluation a communication step, as the observers need it.
    table = [(*row[:3], gains.get(row[0], row[3]), *row[4:]) for row in law.VARIABLES if row[0] != "internal_step"]
    return module(name, law, DESCRIPTION="behind the holdable angle of attack", VARIABLES=[*table, *ROWS],
                  PRESETS={"start": {**gains, **PROTECTION}, "independent": {**retuned, **PROTECTION}, **TUNED[name]},
                  prepare=prepare, start=start, advance=advance, outputs=outputs)


def free(law, preset):
    """The gains of a preset that `ahv tune` may change."""
    model = {"neural": neural_model, "backstepping": backstepping_model}[law]
    return {name: model.PRESETS[preset][name] for name in LAWS[law].gains}


MODELS = {
    "neural": protected("ProtectedNeural", neural_model, free("neural", "robust"), free("neural", "independent")),
    "backstepping": protected("ProtectedBackstepping", backstepping_model, free("backstepping", "calibrated"),
                              free("backstepping", "independent")),
}

if __name__ == "__main__":
    for model in MODELS.values():
        print(build(model, "native", Path(sys.argv[1]) if sys.argv[1:] else OUT))
