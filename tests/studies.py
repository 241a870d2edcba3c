"""Studies by flight that the tests run small and benchmarks/draw_evidence.py runs whole."""
from types import SimpleNamespace

import numpy as np
from evidence import Loaded, constant, fly, summary, varying

from ahv_ctrl_fmu.neural_model import PRESETS

PRINTED_NETWORKS = {n: v for n, v in PRESETS["printed"].items() if n.startswith(("net", "lambda"))}


# --- what the adaptation buys ---------------------------------------------------------------------------------

def average_gains(case, preset="calibrated"):
    """Time averages of phi_hat h^T h / 2 on a flight: what the networks add to kV1 and to kh1."""
    flight = fly(case, preset=preset)

    def mean(network, error):
        big = np.abs(error) > 1e-3 * np.abs(error).max()
        return float(np.mean(network[big] / error[big]))

    return (mean(flight["controller.network_1"], flight["controller.V_error"]),
            mean(flight["controller.network_2"], flight["controller.error_function"]))


def variants(case, preset="calibrated"):
    """Name -> gains to set: networks as laid out, off, replaced by a gain of equal average, laid out as printed."""
    gains = PRESETS[preset]
    first, second = average_gains(case, preset)
    off = {"lambda_1": 0.0, "lambda_2": 0.0}
    return {"on": {}, "network 1 only": {"lambda_2": 0.0}, "network 2 only": {"lambda_1": 0.0}, "off": off,
            "plain gain": {**off, "kV1": gains["kV1"] + first, "kh1": gains["kh1"] + second},
            "as printed": PRINTED_NETWORKS}


def random_flights(loaded, gains, seeds, amplitude, step=0.02):
    """Case 1's commands under random coefficients, even seeds constant, odd ones time-varying."""
    return [summary(loaded.fly("case1", {"scenario": (varying if seed % 2 else constant)(seed, amplitude),
                                         "controller": gains}, step)) for seed in seeds]


def ablation(seeds=range(100), amplitude=0.1, preset="calibrated"):
    """Variant -> {"case1", "case2"} and the random flights, with medians over those that all variants survive."""
    result = {}
    with Loaded("neural", preset) as loaded:
        for name, gains in variants("case2", preset).items():
            result[name] = {case: summary(loaded.fly(case, {"controller": gains})) for case in ("case1", "case2")}
            result[name]["random"] = random_flights(loaded, gains, seeds, amplitude)
    common = [all(row["random"][i].survived for row in result.values()) for i in range(len(seeds))]
    for row in result.values():
        kept = [f for f, every in zip(row["random"], common) if every]
        row["survived"] = sum(f.survived for f in row["random"])
        row["median"] = SimpleNamespace(**{k: float(np.median([getattr(f, k) for f in kept]))
                                           for k in ("h", "h_rms", "V", "travel")})
    return result


# --- where it can be held ---------------------------------------------------------------------------------------

def held(loaded, V, h, step_ft=0.0):
    """60 s of hold at V (ft/s), h (ft), from trim, with a step of the altitude command or none."""
    flight = loaded.fly("hold", {"scenario": {"V_command_base": V, "h_command_base": h, "h_command_step": step_ft},
                                 "plant": {"V_start": V, "h_start": h}})
    found = summary(flight)
    late = flight.time > 50
    swing = float(np.ptp(np.degrees(flight["controller.elevator"][late]))) if flight.finished else float("inf")
    found.good = found.survived and found.h < 20 and (step_ft > 0 or swing < 0.1)
    return found


def envelope(law, preset, points, step_ft=0.0):
    """(V, h) -> what `held` found."""
    with Loaded(law, preset) as loaded:
        return {point: held(loaded, *map(float, point), step_ft) for point in points}


# --- how much noise and delay -----------------------------------------------------------------------------------

NOISE = {"V_noise": 0.1, "h_noise": 0.3, "gamma_noise": 2e-5, "theta_noise": 2e-5, "Q_noise": 2e-4}  # ft/s, ft, rad
SENSORS = ("V", "h", "gamma", "theta", "Q")


def bears(loaded, plant):
    """Whether Case 1 is flown within 20 ft and with less than 5 s of elevator saturation."""
    found = summary(loaded.fly("case1", {"plant": plant}))
    return found.survived and found.h < 20 and found.saturated < 5


def beside(count, V=7700.0):
    """`count` values of V (ft/s), `V` the middle one; each differs from the next in the last bit only."""
    return [V + k * float(np.spacing(V)) for k in range(-(count // 2), count - count // 2)]


def flown_beside(loaded, plant, count):
    """Case 1 from `count` starts that differ in the last bit of V: a flight at the edge of stability, chaotic and with
    the elevator between its stops, is kept from some and lost from others."""
    return [summary(loaded.fly("case1", {"plant": {**plant, "V_start": V}})) for V in beside(count)]


def limits(law, preset, delays=range(5, 245, 5), factors=(0.01, 0.03, 0.1, 0.3, 1, 3, 10, 30)):
    """The largest delay of all sensors (ms) and the largest factor on NOISE that Case 1 is flown with, each alone."""
    delay, noise = 0, 0.0
    with Loaded(law, preset, "instrumented") as loaded:
        for ms in delays:
            if not bears(loaded, {f"{name}_delay": ms / 1000 for name in SENSORS}):
                break
            delay = ms
        for factor in factors:
            if not bears(loaded, {name: factor * size for name, size in NOISE.items()}):
                break
            noise = factor
        travel = summary(loaded.fly("case1", {"plant": {n: 0.1 * s for n, s in NOISE.items()}})).travel
    return {"delay_ms": delay, "noise_factor": noise, "travel_at_tenth_deg": travel}
