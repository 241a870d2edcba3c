"""Draws the pictures of docs/laws/resilient.md and of the README into docs/pictures/, and prints their figures as JSON.

    .venv/bin/python benchmarks/draw_law.py [NAME...]     (all of DRAWN, some minutes)

`worst` needs the campaign that `benchmarks/law_table.py case1` flies.
"""
import json
import sys
from pathlib import Path
from types import SimpleNamespace

import matplotlib.pyplot as plt
import numpy as np
import pyarrow.parquet as pq

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "tests"))

from evidence import DEPARTED, GROUPS, Loaded, fly, summary  # noqa: E402
from exact_linear import linear_loop, linear_vehicle  # noqa: E402
from law_studies import PARTS, STRUCTURES, flights, independent, modes, without  # noqa: E402

import ahv_plant_fmu.model as vehicle  # noqa: E402
from ahv_ctrl_fmu import resilient_model  # noqa: E402
from ahv_ctrl_fmu.resilient import SECTIONS, section_gains  # noqa: E402
from ahv_ctrl_fmu.sections import section  # noqa: E402
from cosim import pictures  # noqa: E402
from cosim.analysis.margins import margins, response  # noqa: E402
from cosim.pictures import BLUE, ORANGE, RED  # noqa: E402
from fmus import floats  # noqa: E402

PICTURES = HERE.parent / "docs" / "pictures"
UNCERTAIN = str(HERE.parent / "docs" / "scenarios" / "uncertain.yaml")
CASE_1 = Path("results") / "law_table" / "case1" / "runs.parquet"
LAWS = {"neural, calibrated": ("neural", "calibrated"), "neural, retuned": ("neural", "independent"),
        "resilient, quiet": ("resilient", "quiet"), "backstepping, calibrated": ("backstepping", "calibrated"),
        "backstepping, retuned": ("backstepping", "independent")}
WIDTH = pictures.WIDTHS[2]
SWING = 0.05 * np.pi  # rad/s, of Case 1's coefficients


def save(figure, name):
    if figure.get_layout_engine() is None:
        figure.tight_layout()
    pictures.save(figure, PICTURES / f"law_{name}")
    plt.close(figure)


def error(flight):
    return flight["plant.h"] - flight["controller.h_reference"]


def degrees(flight, name):
    return np.degrees(flight[name])


def uncertain():
    """One vehicle, lost by the neural law and kept by this one."""
    lost, kept = fly(UNCERTAIN), fly(UNCERTAIN, "resilient")
    figure, axes = plt.subplots(1, 3, figsize=(WIDTH, 2.5), layout="constrained")
    end = int(np.argmax(np.abs(error(lost)) > DEPARTED)) + 1
    for flight, rows, line, label in ((lost, slice(end), "-.", "the paper's law (neural, calibrated)"),
                                       (kept, slice(None), "-", "resilient")):
        for axis, values in zip(axes, (error(flight), degrees(flight, "controller.elevator"),
                                       degrees(flight, "plant.alpha"))):
            axis.plot(flight.time[rows], values[rows], line, color=RED if flight is lost else BLUE,
                      label=label if axis is axes[0] else None)
            if flight is lost and axis is not axes[2]:
                axis.plot(flight.time[end - 1], values[end - 1], "x", color=RED, markersize=7, markeredgewidth=1.6,
                          label="lost" if axis is axes[0] else None, clip_on=False)
    axes[2].plot(kept.time, degrees(kept, "controller.alpha_limit"), "k--", linewidth=1.0,
                 label="limit that resilient keeps to")
    axes[1].axhline(20, color="k", linestyle=":", linewidth=1.0, label="the elevator's stop")
    axes[0].set(ylabel="altitude error (ft)", ylim=(-110, 60))
    axes[1].set(ylabel="elevator (deg)", ylim=(-22, 22))
    axes[2].set(ylabel="angle of attack (deg)", ylim=(0, 9))
    for axis in axes:
        axis.set(xlim=(0, 15), xlabel="time (s)")
    figure.legend(loc="outside lower center", ncols=3)
    save(figure, "uncertain")
    return {"departed at s": float(lost.time[-1]), "100 ft at s": float(lost.time[end - 1]),
            "kept": vars(summary(kept))}


def maps(count=800):
    """Success over the phases of lift and moment for each law."""
    phases = np.degrees([[values["scenario"][f"scale_{group}_sine_phase"] for group in GROUPS]
                         for values in independent(18, count)])
    figure, axes = plt.subplots(2, 3, figsize=(WIDTH, 6.0), sharex=True, sharey=True, layout="constrained")
    axes[1, 2].set_axis_off()
    result = {}
    for axis, (name, (law, preset)) in zip(axes.flat, LAWS.items()):
        found = [summary(flight) for flight in flights(count, preset, law=law)]
        kept = np.array([f.survived for f in found])
        within = kept & (np.array([f.h for f in found]) < 20)
        for which, hue, mark, size, label in ((~kept, RED, "x", 2.5, "lost"), (within, BLUE, ".", 2.5, "within 20 ft"),
                                              (kept & ~within, ORANGE, "^", 4, "kept, more than 20 ft")):
            edge = "k" if mark == "^" else hue
            axis.plot(*phases[which][:, [1, 3]].T, mark, color=hue, markersize=size, markeredgewidth=0.6,
                      markeredgecolor=edge, label=label)
        counts = f"lost {(~kept).sum()}, kept {(kept & ~within).sum()}, within {within.sum()}"
        axis.set(title=f"{name}\n{counts}", xlabel="phase of lift at t = 0 (deg)", xlim=(-180, 180), ylim=(-180, 180),
                 xticks=range(-180, 181, 90), yticks=range(-180, 181, 90))
        axis.tick_params(labelbottom=True)
        result[name] = {"within": int(within.sum()), "kept": int(kept.sum()), "of": count}
    for axis in axes[:, 0]:
        axis.set_ylabel("phase of the moment at t = 0 (deg)")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=3, markerscale=2)
    save(figure, "maps")
    return result


def worst():
    """The three largest altitude errors of the campaign."""
    rows = pq.read_table(CASE_1).sort_by([("altitude_error_ft.max_abs", "descending")]).slice(0, 3).to_pylist()
    figure, axes = plt.subplots(4, 3, figsize=(WIDTH, 6.2), sharex="col", sharey="row", layout="constrained")
    result = {}
    with Loaded("resilient", "quiet") as loaded:
        for column, row in zip(axes.T, rows):
            phases = {group: row[f"scenario.scale_{group}_sine_phase"] for group in GROUPS}
            flight = loaded.fly("case1", {"scenario": {f"scale_{g}_sine_phase": p for g, p in phases.items()}})
            t = flight.time
            at = t[np.abs(error(flight)).argmax()]
            true = {group: 1 + 0.4 * np.sin(SWING * t + phases[group]) for group in ("lift", "moment")}
            column[0].plot(t, error(flight), "-", color=BLUE)
            column[0].axhspan(-20, 20, color="0.92")
            column[0].set_title(f"run {row['run']}: {np.abs(error(flight)).max():.1f} ft at {at:.1f} s")
            column[1].plot(t, degrees(flight, "controller.elevator"), "-", color=BLUE, label="elevator")
            column[1].plot(t, degrees(flight, "controller.elevator_hold"), "--", color=ORANGE, linewidth=1.0,
                           label="that holds the\nangle of attack")
            column[1].axhline(20, color="k", linestyle=":", linewidth=1.0, label="stop")
            column[2].plot(t, degrees(flight, "plant.alpha"), "-", color=BLUE, label="angle of attack")
            column[2].plot(t, degrees(flight, "controller.alpha_command"), "--", color=ORANGE, linewidth=1.0,
                           label="commanded")
            column[2].plot(t, degrees(flight, "controller.alpha_limit"), "k:", linewidth=1.0, label="limit")
            for group, hue, line in (("lift", BLUE, "-"), ("moment", RED, "--")):
                column[3].plot(t, true[group], line, color="0.6", linewidth=2.6, label=f"{group}, true")
                column[3].plot(t, flight[f"controller.scale_{group}"], line, color=hue, label=f"{group}, found")
            column[3].set(xlabel="time (s)", xlim=(0, 12))
            result[f"run {row['run']}"] = {
                "error_ft": float(np.abs(error(flight)).max()), "at_s": float(at),
                **{f"{group} at 0": float(values[0]) for group, values in true.items()},
                "protected_s": row["protected_s"], "alpha_margin_deg": row["alpha_margin_deg.min"],
                "phases": {group: round(p, 4) for group, p in phases.items()}}
    for axis, label, low, high in zip(axes[:, 0], ("altitude error (ft)", "elevator (deg)", "angle of attack (deg)",
                                                   "scale (1)"), (-40, -22, -1, 0.5), (40, 22, 7, 1.5)):
        axis.set(ylabel=label, ylim=(low, high))
    for axis in axes.flat:
        axis.grid(alpha=0.3)
    for axis in axes[1:, 2]:
        axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    save(figure, "worst")
    return result


def ablation(count=200):
    """What is lost without each part."""
    found = {part: without(part, count) for part in PARTS}
    figure, axes = plt.subplots(1, 3, figsize=(WIDTH, 3.6), sharey=True, layout="constrained")
    at = np.arange(len(found))[::-1]
    result = {}
    for axis, kind, title in ((axes[0], "plain", "Case 1"), (axes[1], "lagged", "Case 1, elevator\n30 rad/s, 60°/s")):
        kept = [100 * np.mean([f.survived for f in getattr(one, kind)]) for one in found.values()]
        within = [100 * np.mean([f.survived and f.h < 20 for f in getattr(one, kind)]) for one in found.values()]
        axis.barh(at, kept, color=ORANGE, height=0.7, label="kept, more than 20 ft")
        axis.barh(at, within, color=BLUE, height=0.7, label="within 20 ft")
        axis.barh(at, 100 - np.array(kept), left=kept, color=RED, height=0.7, hatch="////", edgecolor="w", label="lost")
        axis.set(title=title, xlabel=f"flights of {count} (%)", xlim=(0, 100))
        for part, *shares in zip(found, within, kept):
            result.setdefault(part, {})[kind] = [round(share, 1) for share in shares]
    axes[2].barh(at, [one.travel for one in found.values()], color=BLUE, height=0.7)
    axes[2].set(title="full unit of noise", xlabel="elevator travel\nin 100 s (deg)")
    axes[0].set_yticks(at, ["as it is" if part == "nothing" else f"no {part}" for part in found])
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    for axis in axes:
        axis.grid(alpha=0.3, axis="x")
    save(figure, "ablation")
    for part, one in found.items():
        worst = [f.h for f in one.plain if f.survived]
        result[part] |= {"worst_ft": round(max(worst), 1) if worst else None, "travel_deg": round(one.travel),
                         "together_ft": [round(h, 2) for h in one.together]}
    return result


def filter_response(gains, omega, step=0.01):
    """The moment demand's filter of a preset at `omega` (rad/s): a complex vector."""
    z, F = np.exp(1j * omega * step), np.ones(len(omega), complex)
    for k in SECTIONS:
        b0, b1, b2, a1, a2 = section(floats, section_gains(SimpleNamespace(**gains), k), step)
        F *= (b0 * z**2 + b1 * z + b2) / (z**2 + a1 * z + a2)
    return F


def structures():
    """Preset `coupled` at the elevator: its filter, and the loop on each structure, as it is and with modes that are
    10 % lower or higher."""
    omega = np.geomspace(0.3, np.pi / 0.01, 1500)
    gains = resilient_model.PRESETS["coupled"]
    figure = plt.figure(figsize=(WIDTH, 4.6), layout="constrained")
    axes = figure.subplot_mosaic([["filter"] * 3 + ["loops"] * 3, *[[name for name in STRUCTURES for _ in range(2)
                                                                     if STRUCTURES[name]]]])
    size = np.abs(filter_response(gains, omega))
    axes["filter"].loglog(omega, size, "-", color="0.5")
    result = {"largest |F| above 35 rad/s": float(size[omega > 35].max())}
    shifts = {1.0: "modes as they are", 0.9: "10 % lower", 1.1: "10 % higher"}
    for (name, plant), line, mark in zip(STRUCTURES.items(), pictures.styled(len(STRUCTURES)), pictures.MARKS):
        for (factor, shift), look in zip(shifts.items(), pictures.styled(len(shifts))):
            if factor != 1 and not plant:
                continue
            cut = linear_loop(vehicle, resilient_model, gains, 7700.0, 85000.0,
                              parameters={**plant, **modes(factor)}).cut(actuator=1)
            loop = -response(cut.A, cut.B, cut.C, cut.D, omega, cut.step)[:, 0, 0]
            result[f"{name}, mode frequencies x {factor:g}"] = margins(omega, loop).as_dict()
            if factor == 1:
                axes["loops"].loglog(omega, np.abs(loop), label=name, **line)
            if plant:
                axes[name].loglog(omega, np.abs(loop), label=shift, **look)
            if factor == 1 and plant:
                poles = linear_vehicle(vehicle, 7700.0, 85000.0, **plant).poles
                found = [float(abs(p)) for p in poles if p.imag > 5]
                result[f"{name}, modes (rad/s)"] = [round(at, 2) for at in found]
                axes["filter"].plot(found, np.abs(filter_response(gains, np.array(found))), mark, color=line["color"],
                                    fillstyle="none", label=f"modes, {name}", markersize=6)
    axes["filter"].set(title="filter of the moment demand", ylabel="|F| (1)", ylim=(1e-2, 3))
    axes["loops"].set(title="loop cut at the elevator", ylabel="gain (1)", ylim=(1e-2, 10))
    for name in ("filter", "loops"):
        axes[name].legend(loc="lower left")
    for name, plant in STRUCTURES.items():
        if plant:
            axes[name].set(title=name, xlim=(8, 50), ylim=(1e-2, 5), xticks=(10, 20, 50))
            axes[name].xaxis.set_major_formatter(pictures.number)
            axes[name].xaxis.set_minor_formatter("")
    first = next(name for name, plant in STRUCTURES.items() if plant)
    axes[first].set_ylabel("gain (1)")
    figure.legend(*axes[first].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    for axis in axes.values():
        axis.axhline(1, color="0.5", linewidth=0.8)
        axis.set_xlabel("frequency (rad/s)")
    save(figure, "structures")
    return result


DRAWN = (uncertain, maps, worst, ablation, structures)

if __name__ == "__main__":
    wanted = sys.argv[1:] or [f.__name__ for f in DRAWN]
    with pictures.style():
        found = {f.__name__: f() for f in DRAWN if f.__name__ in wanted}
    print(json.dumps(found, indent=1, default=float))
