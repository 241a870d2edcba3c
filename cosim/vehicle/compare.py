"""Control laws on the same run: a table, and figures with a curve for each."""
import re
import time
import zipfile
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from ..master.flight import Flight, fly
from ..master.fmu import FmuFile
from ..master.system import System
from .figures import Panel, values
from .metrics import metrics, truth

# Column -> law and preset. The rival and `robust` were tuned by the same script, with the same cost and budget.
COMPARED = {"neural": ("neural", "calibrated"), "neural, robust": ("neural", "robust"),
            "backstepping": ("backstepping", "calibrated")}
SHOWN = {"backstepping": "backstepping (a reconstruction)"}  # what the paper compares with could not be had
SETTLED = 0.02  # of a command's step
COST_STEPS = 5000

# figure's name, title, panels; a curve's style is taken from the flight. References are drawn once, dashed.
PICTURES: list[tuple[str, str, tuple[Panel, ...]]] = [
    ("velocity", "Velocity tracking", (
        Panel("V (ft/s)", (("reference", "controller.V_reference", "k--"), ("", "plant.V", ""))),
        Panel("V error (ft/s)", (("", "plant.V - controller.V_reference", ""),)))),
    ("altitude", "Altitude tracking", (
        Panel("h (ft)", (("reference", "controller.h_reference", "k--"), ("", "plant.h", ""))),
        Panel("h error (ft)", (("", "plant.h - controller.h_reference", ""),)))),
    ("attitude", "Attitude angles", (
        Panel("γ (deg)", (("", "plant.gamma", ""),), True),
        Panel("θ (deg)", (("", "plant.theta", ""),), True),
        Panel("Q (deg/s)", (("", "plant.Q", ""),), True))),
    ("inputs", "Control inputs", (
        Panel("fuel ratio Φ", (("", "controller.fuel_ratio", ""),)),
        Panel("elevator $δ_e$ (deg)", (("", "controller.elevator", ""),), True))),
    ("flexible", "Flexible states", (
        Panel("$η_1$ (ft slug$^{1/2}$/ft$^{1/2}$)", (("", "plant.eta1", ""),)),
        Panel("$η_2$ (ft slug$^{1/2}$/ft$^{1/2}$)", (("", "plant.eta2", ""),)))),
]


def settling(time: np.ndarray, command: np.ndarray, found: np.ndarray) -> float | None:
    """Longest time (s) from a step of the command until `found` stays within SETTLED of that step, up to the
    next; None without a step, or where it does not settle."""
    edges = [0, *(np.flatnonzero(np.diff(command)) + 1), len(command)]
    worst: float | None = None
    for begin, end in pairwise(edges):
        height = abs(command[begin] - (found[0] if begin == 0 else command[begin - 1]))
        if height < 1e-6 or end - begin < 2:
            continue
        outside = np.flatnonzero(np.abs(found[begin:end] - command[begin]) > SETTLED * height)
        last = begin + outside[-1] + 1 if len(outside) else begin
        if last == end:
            return None
        worst = max(worst or 0.0, float(time[last] - time[begin]))
    return worst


def figures_of(flight: Flight) -> dict[str, Any]:
    """What a flight is compared by."""
    result = metrics(flight)
    del result["phi_hat"]
    step = float(flight.time[1] - flight.time[0]) if len(flight.time) > 1 else 0.0
    for name, key in (("h", "altitude_settling_s"), ("V", "velocity_settling_s")):
        result[key] = settling(flight.time, flight[f"scenario.{name}_command"], truth(flight, name))
    result["elevator_saturated_s"] = step * float(flight["controller.elevator_saturated"].sum())
    result["fuel_saturated_s"] = step * float(flight["controller.fuel_ratio_saturated"].sum())
    return {"finished": flight.finished, "departed_at_s": None if flight.finished else float(flight.time[-1]), **result}


def size_of(path: Path, preset: str) -> dict[str, int | None]:
    """States (as a native FMU's sources tell), parameters, and parameters that the preset sets."""
    file = FmuFile.open(path)
    try:
        parameters, tuned = len(file.names("parameter")), len(file.preset(preset))
    finally:
        file.close()
    with zipfile.ZipFile(path) as archive:
        header = archive.read("sources/model.h").decode() if "sources/model.h" in archive.namelist() else ""
    states = re.search(r"\bNX = (\d+)", header)
    return {"states": int(states[1]) if states else None, "parameters": parameters, "preset_parameters": tuned}


def cost_per_step(system: System, step: float) -> float:
    """Microseconds of wall time per step of the controller alone, inputs held, the quickest of five flights."""
    alone = System(tuple(replace(c) for c in system.components if c.name == "controller"), ())
    walls = [fly(alone, step, step * COST_STEPS, record=["controller.elevator"]).wall_s for _ in range(5)]
    return 1e6 * min(walls) / COST_STEPS


def compare(systems: dict[str, System], presets: dict[str, str], step: float, stop: float
            ) -> tuple[dict[str, Flight], dict[str, dict[str, Any]]]:
    """Fly every law's system; the flights and what they are compared by."""
    flights, table = {}, {}
    for law, system in systems.items():
        began = time.perf_counter()
        flights[law] = fly(system, step, stop)
        controller = next(c for c in system.components if c.name == "controller")
        table[law] = {"preset": presets[law], **figures_of(flights[law]), **size_of(controller.fmu, presets[law]),
                      "cost_per_step_us": cost_per_step(system, step), "wall_s": time.perf_counter() - began}
    return flights, table


BETTER = (("maximum altitude error", ("altitude_error_ft", "max_abs"), "ft"),
          ("rms altitude error", ("altitude_error_ft", "rms"), "ft"),
          ("maximum velocity error", ("velocity_error_fps", "max_abs"), "ft/s"),
          ("elevator travel", ("elevator_deg", "travel"), "deg"),
          ("cost per step", ("cost_per_step_us",), "us"))


def verdict(table: dict[str, dict[str, Any]]) -> str:
    """One sentence: which law has the smallest figure in what."""
    departed = [law for law, row in table.items() if not row["finished"]]
    if departed:
        return f"{' and '.join(SHOWN.get(law, law) for law in departed)} departed."
    won: dict[str, list[str]] = {law: [] for law in table}
    for name, keys, unit in BETTER:
        found = {}
        for law, row in table.items():
            value: Any = row
            for key in keys:
                value = value[key]
            found[law] = value
        best = min(found, key=found.__getitem__)
        others = " and ".join(f"{v:.3g}" for law, v in found.items() if law != best)
        won[best].append(f"{name} ({found[best]:.3g} against {others} {unit})")
    sentences = [f"{SHOWN.get(law, law)} has the smallest {', '.join(what)}" for law, what in won.items() if what]
    return "; ".join(sentences) + "."


def draw(flights: dict[str, Flight], title: str, panels: tuple[Panel, ...]) -> Any:
    figure, axes = plt.subplots(len(panels), 1, sharex=True, figsize=(8, 2.2 * len(panels) + 1), squeeze=False)
    for axis, panel in zip(axes[:, 0], panels):
        for name, expression, style in panel.curves:
            for i, (law, flight) in enumerate(flights.items()):
                y = values(flight, expression)
                y = np.degrees(y) if panel.degrees else y
                if style and i == 0:
                    axis.plot(flight.time, y, style, label=name, linewidth=1.0, zorder=3)
                elif not style:
                    axis.plot(flight.time, y, f"C{i}", label=SHOWN.get(law, law), linewidth=1.1, alpha=0.9)
        axis.set_ylabel(panel.ylabel)
        axis.grid(True, alpha=0.3)
        axis.ticklabel_format(axis="y", useOffset=False)
    axes[0, 0].legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncol=4, fontsize="small", frameon=False)
    axes[-1, 0].set_xlabel("time (s)")
    axes[-1, 0].set_xlim(0, max(max(f.time[-1] for f in flights.values()), 1e-9))
    figure.suptitle(title)
    figure.align_ylabels()
    figure.tight_layout()
    return figure


def write(folder: Path, flights: dict[str, Flight], name: str) -> list[Path]:
    """Every picture into `folder`, a file for each."""
    written = []
    for key, title, panels in PICTURES:
        figure = draw(flights, f"{name}: {title}", panels)
        written.append(folder / f"compare_{key}.png")
        figure.savefig(written[-1], dpi=110)
        plt.close(figure)
    return written
