"""Draws the pictures of docs/evidence.md into docs/pictures/ and prints its figures as JSON.

    .venv/bin/python benchmarks/draw_evidence.py [NAME...]     (all of PICTURES, some minutes)

What is drawn is computed by the functions that the tests run (tests/claims.py, tests/studies.py), on more points.
"""
import json
import sys
from itertools import takewhile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import LogLocator

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
from studies import NOISE, SENSORS, ablation, envelope, flown_beside, limits  # noqa: E402

from ahv_ctrl_fmu import backstepping_model, neural_model  # noqa: E402
from ahv_ctrl_fmu.neural_model import PRESETS  # noqa: E402
from ahv_plant_fmu import model as plant  # noqa: E402
from cosim import pictures  # noqa: E402
from cosim.analysis.margins import frequencies, margins_at, response  # noqa: E402
from cosim.pictures import BLACK, BLUE, MARKS, ORANGE, RED, Curve, Panel, number, styled  # noqa: E402

PICTURES = HERE.parent / "docs" / "pictures"
LAWS = {"neural, calibrated": ("neural", neural_model, "calibrated"),
        "neural, robust": ("neural", neural_model, "robust"),
        "backstepping (a reconstruction)": ("backstepping", backstepping_model, "calibrated")}
STRUCTURES = {"decoupled": {}, "printed sign": {"psi_1": -363.5, "psi_2": 328.8},
              "mode 1 turned": {"psi_1": 363.5, "psi_2": 328.8},
              "energy-consistent": {"psi_1": -363.5, "psi_2": 328.8, "coupling_sign": -1.0}}


ERRORS = (("V error", "ft/s", lambda f: f["plant.V"] - f["controller.V_reference"]),
          ("h error", "ft", lambda f: f["plant.h"] - f["controller.h_reference"]))
WIDTH = pictures.WIDTHS[2]
STARTS = 21  # flights of each delay and each noise, which start a last bit of V apart


def save(figure, name):
    """Write a figure with as much room between its axes as its texts need."""
    if figure.get_layout_engine() is None:
        figure.tight_layout()
    pictures.save(figure, PICTURES / f"evidence_{name}")
    plt.close(figure)


def errors_over_time(flights, panels, title, name):
    """Panels (quantity, unit, function of a flight), a curve for each of `flights` (by label) and, below, its
    difference from the first; and where they differ most."""
    found = []
    first = next(iter(flights))
    for quantity, unit, value in panels:
        curves = [Curve(law, flight.time, value(flight)) for law, flight in flights.items()]
        less = [curve._replace(values=curve.values - curves[0].values) for curve in curves]
        found += [Panel(f"{quantity} ({unit})", curves), Panel(f"{quantity} less that of {first} ({unit})", less, 0.8)]
    zoom = pictures.where_they_differ(found, 0.04)
    pictures.save(pictures.over_time(found, title, zoom=zoom), PICTURES / f"evidence_{name}")


def over_envelope(axis, values, title, unit):
    shown = axis.contourf(SPEEDS, ALTITUDES / 1000, np.array(values).reshape(len(SPEEDS), -1).T, 12, cmap="viridis")
    axis.grid(False)
    axis.set_title(title, fontsize=7)
    axis.set(xlabel="V (ft/s)", ylabel="h (1000 ft)")
    axis.figure.colorbar(shown, ax=axis, label=unit)


def assumptions():
    found = [effects(V, h) for V, h in ENVELOPE]
    figure, axes = plt.subplots(1, 3, figsize=(WIDTH, 2.2))
    for axis, (name, title, unit) in zip(axes, (
            ("V' by fuel ratio", "$\\partial\\dot V/\\partial\\Phi$ > 0: Assumption 1 holds", "ft/s²"),
            ("gamma' by theta", "$\\partial\\dot\\gamma/\\partial\\theta$ > 0: Assumption 2, first part", "1/s"),
            ("Q' by elevator", "$\\partial\\dot Q/\\partial\\delta_e$ < 0: Assumption 2 fails", "1/s²"))):
        over_envelope(axis, [e[name] for e in found], title, unit)
    save(figure, "assumptions")
    return {name: [min(e[name] for e in found), max(e[name] for e in found)] for name in found[0]}


def zeros():
    found = np.array([gamma_zeros(V, h) for V, h in ENVELOPE])
    figure, axes = plt.subplots(1, 2, figsize=(WIDTH, 2.6))
    over_envelope(axes[0], found[:, 1], "zero of elevator → γ in the right half-plane", "1/s")
    over_envelope(axes[1], found[:, 0], "unstable pole of the vehicle", "1/s")
    save(figure, "zeros")
    return {"zero": [found[:, 1].min(), found[:, 1].max()], "pole": [found[:, 0].min(), found[:, 0].max()]}


def differentiator():
    figure, axis = plt.subplots(figsize=(3.5, 2.8))
    shapes = {"printed": (RED, "x"), "steady": (BLUE, "s"), "calibrated": (BLACK, "^")}
    for name, (colour, mark) in shapes.items():
        poles = differentiator_poles(PRESETS[name])
        label = f"{name} (all four at −1)" if np.ptp(poles.real) < 0.01 else name
        axis.plot(poles.real, poles.imag, mark, color=colour, label=label, fillstyle="none", markersize=7)
    axis.axvline(0, color="k", linewidth=0.8)
    axis.set(xlabel="real part / R (1)", ylabel="imaginary part / R (1)", title="Poles of the differentiator (13)")
    axis.legend()
    axis.grid(alpha=0.3)
    save(figure, "differentiator")
    return {name: differentiator_poles(PRESETS[name]).real.max() for name in shapes}


def stability():
    scales = np.linspace(0.6, 1.4, 17)
    figure, axes = plt.subplots(3, 3, figsize=(WIDTH, 7.2), sharey="row", layout="constrained")
    share = {}
    for column, (law, (_, model, preset)) in enumerate(LAWS.items()):
        gains = model.PRESETS[preset]
        maps = (
            (SPEEDS, ALTITUDES / 1000, "V (ft/s)", "h (1000 ft)",
             lambda a, b, g=gains, m=model: growth(m, g, a, 1000 * b)),
            (scales, ALTITUDES / 1000, "scale of all coefficients (1)", "h (1000 ft) at V = 7700 ft/s",
             lambda a, b, g=gains, m=model: growth(m, g, h=1000 * b, scale=dict.fromkeys(GROUPS, a))),
            (scales, scales, "scale of lift (1)", "scale of the moment (1)",
             lambda a, b, g=gains, m=model: growth(m, g, scale={"lift": a, "moment": b})))
        for row, (xs, ys, xlabel, ylabel, value) in enumerate(maps):
            found = np.array([[value(float(x), float(y)) for x in xs] for y in ys])
            axis = axes[row, column]
            axis.set_facecolor("0.75")
            axis.grid(False)
            shown = axis.pcolormesh(xs, ys, found, cmap="PuOr_r", vmin=-1, vmax=1, shading="nearest")
            # The colours of both sides are equal in grey: marks say which cells are unstable, a cross where there is
            # no equilibrium.
            y, x = np.nonzero(found >= 0)
            axis.plot(np.asarray(xs)[x], np.asarray(ys)[y], ".", color="k", markersize=1.5)
            y, x = np.nonzero(np.isnan(found))
            axis.plot(np.asarray(xs)[x], np.asarray(ys)[y], "x", color="0.35", markersize=2.5, markeredgewidth=0.5)
            axis.contour(xs, ys, np.nan_to_num(found, nan=9), [0.0], colors="k", linewidths=1.2)
            axis.set_xlabel(xlabel)
            if column == 0:
                axis.set_ylabel(ylabel)
            if row == 0:
                axis.set_title(law)
            share.setdefault(law, []).append(f"{np.sum(found < 0)}/{found.size}")
    figure.colorbar(shown, ax=axes, orientation="horizontal", shrink=0.6, aspect=40, pad=0.02, extend="both",
                    label="largest real part of the closed loop's poles (1/s)")
    figure.suptitle("Stable without a mark, • unstable, × no equilibrium within the limits")
    save(figure, "stability")
    return share


def margins():
    figure, axes = plt.subplots(2, 2, figsize=(WIDTH, 5.4), sharex=True, sharey="row")
    result = {}
    omega = frequencies(0.01)
    # Where marks coincide, the larger are seen around the smaller.
    for (law, (_, model, preset)), line, size in zip(LAWS.items(), styled(len(LAWS)), (8.5, 6.0, 3.5)):
        loop = linear_loop(plant, model, model.PRESETS[preset], 7700, 85000)
        result[law] = {name: margins_at(cut).as_dict() for name, cut in loop.cuts().items()}
        for column, place in enumerate(({"actuator": 1}, {"sensor": 2})):
            cut = loop.cut(**place)
            curve = -response(cut.A, cut.B, cut.C, cut.D, omega, 0.01)[:, 0, 0]
            found = margins_at(cut)
            low, high = (f"{value:.2f}" if value else "–" for value in (found.gain_down, found.gain_up))
            said = f"gain {low} to {high}, phase {found.phase_deg:.0f}°"
            axes[0, column].loglog(omega, np.abs(curve), label=f"{law.partition(' (')[0]}: {said}", **line)
            # Unwrapped, and 0 to -360 where the gain is near one, so that -180 is met and not jumped over.
            phase = np.degrees(np.unwrap(np.angle(curve)))
            crossing = crossings(omega, np.abs(curve))
            phase -= 360 * np.round((phase[crossing[-1]] + 180) / 360) if len(crossing) else 0
            axes[1, column].semilogx(omega, phase, **line)
            mark_margins(axes[:, column], omega, np.abs(curve), phase, line["color"], size)
    for column, title in enumerate(("cut at the elevator", "cut at the sensor of γ")):
        axes[0, column].set(title=f"Open loop, {title}", ylim=(1e-2, 1e2))
        axes[0, column].axhline(1, color="k", linewidth=0.8)
        axes[1, column].axhline(-180, color="k", linewidth=0.8)
        axes[1, column].set(xlabel="frequency (rad/s)", xlim=(0.05, 314), ylim=(-630, 0), yticks=range(-540, 1, 180))
        axes[0, column].legend(loc="upper center", bbox_to_anchor=(0.5, -0.08), handlelength=2)
    axes[0, 0].set_ylabel("gain (1)")
    axes[1, 0].set_ylabel("phase (deg)")
    figure.suptitle("Margins of the loop: ● of phase, at a gain of 1; ▲ of gain, at a phase of −180°")
    save(figure, "margins")
    return result


def crossings(omega, size):
    """Rows after which the gain passes one."""
    return np.flatnonzero(np.diff(np.sign(np.log(size))))


def mark_margins(axes, omega, size, phase, colour, points):
    """Marks of `points` for the smallest phase margin, at a gain of one, and the smallest gain margin each way, at -180
    degrees or whole turns from there; `axes` are those of the gain and of the phase (deg)."""
    def crossed(rows, values, level):
        share = (level - values[rows]) / (values[rows + 1] - values[rows])
        return lambda curve: curve[rows] + share * (curve[rows + 1] - curve[rows])

    def mark(kind, x, gain, angle):
        for axis, y in zip(axes, (gain, angle)):
            axis.plot(x, y, kind, color=colour, markersize=points, markeredgecolor="w", markeredgewidth=0.6, zorder=3)

    def nearest(at, amounts, chosen, kind):
        if chosen.any():
            k = np.flatnonzero(chosen)[np.abs(amounts[chosen]).argmin()]
            mark(kind, np.exp(at(np.log(omega))[k]), np.exp(at(np.log(size))[k]), at(phase)[k])

    at = crossed(crossings(omega, size), np.log(size), 0.0)
    away = (at(phase) + 360) % 360 - 180
    nearest(at, away, np.isfinite(away), "o")
    turns = (phase + 180) / 360
    rows = np.flatnonzero(np.diff(np.floor(turns)))
    at = crossed(rows, turns, np.maximum(np.floor(turns[rows]), np.floor(turns[rows + 1])))
    gains = at(np.log(size))
    for side in (gains < 0, gains > 0):
        nearest(at, gains, side, "^")


def boundedness():
    flight = fly("case2")
    found = bounds("case2", "calibrated")
    figure, axes = plt.subplots(3, 1, figsize=(WIDTH, 4.6), sharex=True)
    t = flight.time
    axes[0].plot(t, flight["plant.V"] - flight["controller.V_reference"])
    axes[0].axhspan(-found.velocity.smallest, found.velocity.smallest, color="0.88", zorder=0,
                    label="(35) with ι = 0, φ = 0; with the ι measured there is no such set")
    axes[0].set_ylabel("V error (ft/s)")
    axes[1].plot(t, flight["controller.error_function"])
    axes[1].axhspan(-found.altitude.radius, found.altitude.radius, color="0.88", zorder=0, label="(64) with ι measured")
    axes[1].set_ylabel("Ê (rad/s²)")
    for i, line in enumerate(styled(2), 1):
        axes[2].plot(t, flight[f"controller.phi_hat_{i}"], label=f"$\\hat\\varphi_{i}$", **line)
    axes[2].axhline(found.velocity.phi_radius, color=RED, linestyle=":", label="bound of (35) for φ = 0")
    axes[2].set(ylabel="$\\hat\\varphi$ (1/s)", xlabel="time (s)")
    for axis in axes:
        axis.legend(loc="center right" if axis is axes[2] else "upper right", frameon=True, edgecolor="0.6")
        axis.set_xlim(t[0], t[-1])
    figure.suptitle("Case 2, calibrated: what the theorems bound")
    save(figure, "boundedness")
    return {case: {name: vars(channel) for name, channel in vars(bounds(case, "calibrated")).items()}
            for case in ("case1", "case2")}


def adaptation():
    rows = {amplitude: ablation(range(100), amplitude) for amplitude in (0.1, 0.2)}
    flights = {label: fly("case2", values={"controller": gains})
               for label, gains in (("networks on", {}), ("off", {"lambda_1": 0.0, "lambda_2": 0.0}))}
    errors_over_time(flights, ERRORS, "Case 2, calibrated", "adaptation")
    return {amplitude: {name: {"case1": vars(r["case1"]), "case2": vars(r["case2"]), "survived": r["survived"],
                               "median": vars(r["median"])} for name, r in found.items()}
            for amplitude, found in rows.items()}


def coupled():
    result, flights = {}, {}
    for name, structure in STRUCTURES.items():
        for case in ("case1", "case2"):
            flights[name] = fly(case, preset="coupled", values={"plant": structure})
            result[f"{case}, {name}"] = vars(summary(flights[name]))
    errors_over_time(flights, (ERRORS[1], ("elevator", "deg", lambda f: np.degrees(f["controller.elevator"]))),
                     "Case 2, preset coupled, on four structures", "coupled")
    return result


def hold():
    figure, axes = plt.subplots(1, 3, figsize=(WIDTH, 2.6), sharey=True)
    result = {}
    for axis, (name, (law, _, preset)) in zip(axes, LAWS.items()):
        still, stepped = envelope(law, preset, ENVELOPE), envelope(law, preset, ENVELOPE, 100.0)
        for (V, h), found in still.items():
            colour, mark = ((BLUE, "o") if found.good and stepped[V, h].good else
                            (ORANGE, "^") if found.good else (RED, "x"))
            axis.plot(V, h / 1000, mark, color=colour, markersize=4.5)
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
    figure, axes = plt.subplots(1, 2, figsize=(WIDTH, 3.4), layout="constrained")
    result = {}
    for (name, (law, _, preset)), line, mark in zip(LAWS.items(), styled(len(LAWS)), MARKS):
        result[name] = {**limits(law, preset), "kept": {}}
        with Loaded(law, preset, "instrumented") as loaded:
            for axis, what, xs, plant in (
                    (axes[0], "h", delays, lambda ms: {f"{s}_delay": float(ms) / 1000 for s in SENSORS}),
                    (axes[1], "travel", factors, lambda f: {n: float(f) * size for n, size in NOISE.items()})):
                flown = (flown_beside(loaded, plant(x), STARTS) for x in xs)
                kept = list(takewhile(bool, ([f for f in starts if f.survived] for starts in flown)))
                middle = [np.median([getattr(f, what) for f in flights]) for flights in kept]
                axis.plot(xs[:len(kept)], middle, label=name, marker=mark, markevery=[len(f) == STARTS for f in kept],
                          **line)
                for x, y, flights in zip(xs, middle, kept):
                    if len(flights) < STARTS:
                        axis.plot(x, y, mark, color=line["color"], markerfacecolor="w", markersize=6)
                        axis.annotate(f"{len(flights)}", (x, y), (6, -2), textcoords="offset points", fontsize=7)
                result[name]["kept"][what] = {f"{x:.3g}": len(flights) for x, flights in zip(xs, kept)}
    axes[0].set(xlabel="delay of all sensors (ms)", ylabel="max altitude error in Case 1 (ft)", yscale="log",
                xlim=(-3, 83))
    axes[1].set(xlabel="factor on the noise (1)", ylabel="elevator travel in Case 1 (deg in 100 s)", xscale="log",
                yscale="log")
    axes[0].yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    for axis in (axes[0].yaxis, axes[1].xaxis, axes[1].yaxis):
        axis.set_major_formatter(number)
        axis.set_minor_formatter("")
    axes[1].set_title("noise at factor 1: 0.1 ft/s, 0.3 ft, 2e-5 rad, 2e-4 rad/s rms", fontsize=7)
    axes[0].set_title(f"hollow, with a number: so many of {STARTS} flights are kept\n"
                      "a curve ends before the first delay or noise that none survives", fontsize=7)
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    save(figure, "instruments")
    return result


def counts():
    return {name: operations(model) for name, model in LAW_MODELS.items()}


DRAWN = (assumptions, zeros, differentiator, stability, margins, boundedness, adaptation, coupled, hold, instruments,
         counts)

if __name__ == "__main__":
    wanted = sys.argv[1:] or [f.__name__ for f in DRAWN]
    with pictures.style():
        found = {f.__name__: f() for f in DRAWN if f.__name__ in wanted}
    print(json.dumps(found, indent=1, default=float))
