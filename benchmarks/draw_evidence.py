"""Draws the pictures of docs/evidence.md into docs/pictures/ and prints its figures as JSON.

    .venv/bin/python benchmarks/draw_evidence.py [NAME...]     (all of PICTURES, some minutes)

What is drawn is computed by the functions that the tests run (tests/claims.py, tests/studies.py), on more points.
"""
import json
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "tests"))

from claims import (  # noqa: E402
    ALTITUDES,
    ENVELOPE,
    LAW_MODELS,
    SPEEDS,
    bounds,
    differentiator_poles,
    effects,
    gamma_zeros,
    growth,
    operations,
)
from evidence import Loaded, fly, summary  # noqa: E402
from exact_linear import GROUPS, linear_loop  # noqa: E402
from studies import NOISE, SENSORS, ablation, envelope, limits  # noqa: E402

from ahv_ctrl_fmu import backstepping_model, neural_model  # noqa: E402
from ahv_ctrl_fmu.neural_model import PRESETS  # noqa: E402
from ahv_plant_fmu import model as plant  # noqa: E402
from cosim.analysis.margins import frequencies, margins_at, response  # noqa: E402

PICTURES = HERE.parent / "docs" / "pictures"
LAWS = {"neural, calibrated": ("neural", neural_model, "calibrated"),
        "neural, robust": ("neural", neural_model, "robust"),
        "backstepping (a reconstruction)": ("backstepping", backstepping_model, "calibrated")}
STRUCTURES = {"decoupled": {}, "printed sign": {"psi_1": -363.5, "psi_2": 328.8},
              "mode 1 turned": {"psi_1": 363.5, "psi_2": 328.8},
              "energy-consistent": {"psi_1": -363.5, "psi_2": 328.8, "coupling_sign": -1.0}}


def save(figure, name):
    figure.tight_layout()
    figure.savefig(PICTURES / f"evidence_{name}.png", dpi=100)
    plt.close(figure)


def over_envelope(axis, values, title, unit):
    shown = axis.contourf(SPEEDS, ALTITUDES / 1000, np.array(values).reshape(len(SPEEDS), -1).T, 12, cmap="viridis")
    axis.set(title=title, xlabel="V (ft/s)", ylabel="h (1000 ft)")
    axis.figure.colorbar(shown, ax=axis, label=unit)


def assumptions():
    found = [effects(V, h) for V, h in ENVELOPE]
    figure, axes = plt.subplots(1, 3, figsize=(14, 3.8))
    for axis, (name, title, unit) in zip(axes, (
            ("V' by fuel ratio", "$\\partial\\dot V/\\partial\\Phi$ > 0: Assumption 1 holds", "ft/s²"),
            ("gamma' by theta", "$\\partial\\dot\\gamma/\\partial\\theta$ > 0: Assumption 2, first part", "1/s"),
            ("Q' by elevator", "$\\partial\\dot Q/\\partial\\delta_e$ < 0: Assumption 2 fails", "1/s²"))):
        over_envelope(axis, [e[name] for e in found], title, unit)
    save(figure, "assumptions")
    return {name: [min(e[name] for e in found), max(e[name] for e in found)] for name in found[0]}


def zeros():
    found = np.array([gamma_zeros(V, h) for V, h in ENVELOPE])
    figure, axes = plt.subplots(1, 2, figsize=(10, 3.8))
    over_envelope(axes[0], found[:, 1], "zero of elevator → γ in the right half-plane", "1/s")
    over_envelope(axes[1], found[:, 0], "unstable pole of the vehicle", "1/s")
    save(figure, "zeros")
    return {"zero": [found[:, 1].min(), found[:, 1].max()], "pole": [found[:, 0].min(), found[:, 0].max()]}


def differentiator():
    figure, axis = plt.subplots(figsize=(5.5, 4.5))
    shapes = {"printed": "rx", "steady": "bs", "calibrated": "g^"}
    for name, style in shapes.items():
        poles = differentiator_poles(PRESETS[name])
        axis.plot(poles.real, poles.imag, style, label=name, fillstyle="none", markersize=9)
    axis.axvline(0, color="k", linewidth=0.8)
    axis.set(xlabel="real part / R", ylabel="imaginary part / R", title="Poles of the differentiator (13)")
    axis.legend()
    axis.grid(alpha=0.3)
    save(figure, "differentiator")
    return {name: differentiator_poles(PRESETS[name]).real.max() for name in shapes}


def stability():
    scales = np.linspace(0.6, 1.4, 17)
    figure, axes = plt.subplots(3, 3, figsize=(13, 11))
    share = {}
    for column, (law, (_, model, preset)) in enumerate(LAWS.items()):
        gains = model.PRESETS[preset]
        maps = (
            (SPEEDS, ALTITUDES / 1000, "V (ft/s)", "h (1000 ft)",
             lambda a, b, g=gains, m=model: growth(m, g, a, 1000 * b)),
            (scales, ALTITUDES / 1000, "scale of all coefficients", "h (1000 ft) at V = 7700 ft/s",
             lambda a, b, g=gains, m=model: growth(m, g, h=1000 * b, scale=dict.fromkeys(GROUPS, a))),
            (scales, scales, "scale of lift", "scale of the moment",
             lambda a, b, g=gains, m=model: growth(m, g, scale={"lift": a, "moment": b})))
        for row, (xs, ys, xlabel, ylabel, value) in enumerate(maps):
            found = np.array([[value(float(x), float(y)) for x in xs] for y in ys])
            axis = axes[row, column]
            axis.set_facecolor("0.75")
            shown = axis.pcolormesh(xs, ys, found, cmap="RdBu_r", vmin=-1, vmax=1, shading="nearest")
            axis.contour(xs, ys, np.nan_to_num(found, nan=9), [0.0], colors="k", linewidths=1.2)
            axis.set(xlabel=xlabel, ylabel=ylabel)
            if row == 0:
                axis.set_title(law)
            figure.colorbar(shown, ax=axis, label="growth (1/s)")
            share.setdefault(law, []).append(f"{np.sum(found < 0)}/{found.size}")
    figure.suptitle("Largest real part of the closed loop's poles: blue stable, red unstable, grey no equilibrium "
                    "within the limits")
    save(figure, "stability")
    return share


def margins():
    figure, axes = plt.subplots(2, 2, figsize=(11, 7), sharex=True)
    result = {}
    omega = frequencies(0.01)
    for law, (_, model, preset) in LAWS.items():
        loop = linear_loop(plant, model, model.PRESETS[preset], 7700, 85000)
        result[law] = {name: margins_at(cut).as_dict() for name, cut in loop.cuts().items()}
        for column, place in enumerate(({"actuator": 1}, {"sensor": 2})):
            cut = loop.cut(**place)
            curve = -response(cut.A, cut.B, cut.C, cut.D, omega, 0.01)[:, 0, 0]
            axes[0, column].loglog(omega, np.abs(curve), label=law, linewidth=1.2)
            axes[1, column].semilogx(omega, np.degrees(np.angle(curve)), linewidth=1.0)
    for column, title in enumerate(("cut at the elevator", "cut at the sensor of γ")):
        axes[0, column].set(title=f"Open loop, {title}", ylabel="gain", ylim=(1e-3, 1e2))
        axes[0, column].axhline(1, color="k", linewidth=0.8)
        axes[1, column].set(xlabel="frequency (rad/s)", ylabel="phase (deg)", xlim=(0.05, 314))
        axes[0, column].grid(alpha=0.3)
        axes[1, column].grid(alpha=0.3)
    axes[0, 0].legend(fontsize="small")
    save(figure, "margins")
    return result


def boundedness():
    flight = fly("case2")
    found = bounds("case2", "calibrated")
    figure, axes = plt.subplots(3, 1, figsize=(8, 7), sharex=True)
    t = flight.time
    axes[0].plot(t, flight["plant.V"] - flight["controller.V_reference"])
    axes[0].axhspan(-found.velocity.smallest, found.velocity.smallest, alpha=0.15, color="g",
                    label="(35) with ι = 0, φ = 0; with the ι measured there is no such set")
    axes[0].set_ylabel("V error (ft/s)")
    axes[1].plot(t, flight["controller.error_function"])
    axes[1].axhspan(-found.altitude.radius, found.altitude.radius, alpha=0.15, color="g", label="(64) with ι measured")
    axes[1].set_ylabel("Ê (rad/s²)")
    axes[2].plot(t, flight["controller.phi_hat_1"], label="$\\hat\\varphi_1$")
    axes[2].plot(t, flight["controller.phi_hat_2"], label="$\\hat\\varphi_2$")
    axes[2].axhline(found.velocity.phi_radius, color="C0", linestyle=":", label="bound of (35) for φ = 0")
    axes[2].set(ylabel="adapted parameters (1/s)", xlabel="time (s)")
    for axis in axes:
        axis.legend(loc="best", fontsize="small")
        axis.grid(alpha=0.3)
    figure.suptitle("Case 2, calibrated: what the theorems bound")
    save(figure, "boundedness")
    return {case: {name: vars(channel) for name, channel in vars(bounds(case, "calibrated")).items()}
            for case in ("case1", "case2")}


def adaptation():
    rows = {amplitude: ablation(range(100), amplitude) for amplitude in (0.1, 0.2)}
    figure, axes = plt.subplots(2, 1, figsize=(8, 5), sharex=True)
    for i, (label, gains) in enumerate((("networks on", {}), ("off", {"lambda_1": 0.0, "lambda_2": 0.0}))):
        flight = fly("case2", values={"controller": gains})
        axes[0].plot(flight.time, flight["plant.V"] - flight["controller.V_reference"], f"C{1 - i}", label=label,
                     linewidth=1.0)
        axes[1].plot(flight.time, flight["plant.h"] - flight["controller.h_reference"], f"C{1 - i}", label=label,
                     linewidth=1.0)
    axes[0].set(ylabel="V error (ft/s)", title="Case 2, calibrated")
    axes[1].set(ylabel="h error (ft)", xlabel="time (s)")
    for axis in axes:
        axis.grid(alpha=0.3)
        axis.legend(fontsize="small")
    save(figure, "adaptation")
    return {amplitude: {name: {"case1": vars(r["case1"]), "case2": vars(r["case2"]), "survived": r["survived"],
                               "median": vars(r["median"])} for name, r in found.items()}
            for amplitude, found in rows.items()}


def coupled():
    figure, axes = plt.subplots(2, 1, figsize=(8, 5.5), sharex=True)
    result = {}
    for name, structure in STRUCTURES.items():
        for case in ("case1", "case2"):
            flight = fly(case, preset="coupled", values={"plant": structure})
            result[f"{case}, {name}"] = vars(summary(flight))
        axes[0].plot(flight.time, flight["plant.h"] - flight["controller.h_reference"], label=name, linewidth=0.9)
        axes[1].plot(flight.time, np.degrees(flight["controller.elevator"]), linewidth=0.9)
    axes[0].set(ylabel="h error (ft)", title="Case 2, preset coupled, on four structures")
    axes[1].set(ylabel="elevator (deg)", xlabel="time (s)")
    axes[0].legend(fontsize="small", ncol=2)
    for axis in axes:
        axis.grid(alpha=0.3)
    save(figure, "coupled")
    return result


def hold():
    figure, axes = plt.subplots(1, 3, figsize=(13, 4), sharey=True)
    result = {}
    for axis, (name, (law, _, preset)) in zip(axes, LAWS.items()):
        still, stepped = envelope(law, preset, ENVELOPE), envelope(law, preset, ENVELOPE, 100.0)
        for (V, h), found in still.items():
            style = "go" if found.good and stepped[V, h].good else "y^" if found.good else "rx"
            axis.plot(V, h / 1000, style, markersize=7)
        axis.set(title=name, xlabel="V (ft/s)")
        result[name] = {"held": sum(f.good for f in still.values()), "of": len(still),
                        "step of 100 ft flown": sum(f.good for f in stepped.values()),
                        "elevator_deg": [min(f.low for f in still.values()), max(f.high for f in still.values())]}
    axes[0].set_ylabel("h (1000 ft)")
    figure.suptitle("hold for 60 s: ● also through a step of 100 ft, ▲ only undisturbed, × not (oscillates)")
    save(figure, "hold")
    return result


def instruments():
    delays, factors = np.arange(0, 100, 5), np.geomspace(0.01, 30, 15)
    figure, axes = plt.subplots(1, 2, figsize=(11, 4))
    result = {}
    for name, (law, _, preset) in LAWS.items():
        result[name] = limits(law, preset)
        with Loaded(law, preset, "instrumented") as loaded:
            late = [summary(loaded.fly("case1", {"plant": {f"{s}_delay": float(d) / 1000 for s in SENSORS}}))
                    for d in delays]
            loud = [summary(loaded.fly("case1", {"plant": {n: float(f) * v for n, v in NOISE.items()}}))
                    for f in factors]
        axes[0].semilogy(delays, [f.h if f.survived else np.nan for f in late], "o-", markersize=3, label=name)
        axes[1].loglog(factors, [f.travel if f.survived else np.nan for f in loud], "o-", markersize=3, label=name)
    axes[0].set(xlabel="delay of all sensors (ms)", ylabel="max altitude error in Case 1 (ft)")
    axes[1].set(xlabel="factor on the noise (1: 0.1 ft/s, 0.3 ft, 2e-5 rad, 2e-4 rad/s rms)",
                ylabel="elevator travel in Case 1 (deg in 100 s)")
    for axis in axes:
        axis.grid(alpha=0.3)
        axis.legend(fontsize="small")
    figure.suptitle("A curve ends where the flight is lost")
    save(figure, "instruments")
    return result


def counts():
    return {name: operations(model) for name, model in LAW_MODELS.items()}


DRAWN = (assumptions, zeros, differentiator, stability, margins, boundedness, adaptation, coupled, hold, instruments,
         counts)

if __name__ == "__main__":
    wanted = sys.argv[1:] or [f.__name__ for f in DRAWN]
    print(json.dumps({f.__name__: f() for f in DRAWN if f.__name__ in wanted}, indent=1, default=float))
