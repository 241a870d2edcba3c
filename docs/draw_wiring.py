"""Draws docs/pictures/wiring.png from the connections of the closed loop and the units of the FMUs.

    .venv/bin/python docs/draw_wiring.py
"""
from pathlib import Path

import fmpy
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.patches import FancyBboxPatch

from cosim.vehicle.closed_loop import CLOSED_LOOP

ROOT = Path(__file__).parent.parent
MODELS = {"scenario": "AhvScenario", "controller": "AhvController", "plant": "AhvPlant"}
BOXES = {"scenario": (0.0, 0.9), "controller": (4.6, 0.9), "plant": (9.2, 0.9)}   # lower left corners
WIDTH, HEIGHT = 1.9, 2.2
# Corners of each line, and where its text stands.
LINES = {
    ("scenario", "controller"): ([(1.9, 2.2), (4.6, 2.2)], (3.25, 2.28)),
    ("controller", "plant"): ([(6.5, 2.2), (9.2, 2.2)], (7.85, 2.28)),
    ("scenario", "plant"): ([(0.95, 3.1), (0.95, 3.75), (10.15, 3.75), (10.15, 3.1)], (5.55, 3.83)),
    ("plant", "controller"): ([(10.15, 0.9), (10.15, 0.25), (5.55, 0.25), (5.55, 0.9)], (7.85, -0.15)),
}


def units() -> dict[str, str]:
    """Unit of each variable, by model.variable."""
    found = {}
    for name, model in MODELS.items():
        description = fmpy.read_model_description(str(ROOT / "fmus" / "dist" / "native" / f"{model}.fmu"))
        found.update({f"{name}.{v.name}": v.unit for v in description.modelVariables})
    return found


def text(names: tuple[str, ...], target: str, unit: dict[str, str], per_line: int) -> str:
    words = [f"{n} [{unit[f'{target}.{n}']}]" for n in names]
    return "\n".join(",  ".join(words[i:i + per_line]) for i in range(0, len(words), per_line))


def main() -> None:
    figure, axes = plt.subplots(figsize=(11.5, 4.4))
    for name, (x, y) in BOXES.items():
        colour = "#dbe9f6" if name == "controller" else "#f2f2f2"
        axes.add_patch(FancyBboxPatch((x, y), WIDTH, HEIGHT, boxstyle="round,pad=0,rounding_size=0.12",
                                      facecolor=colour, edgecolor="black"))
        axes.text(x + WIDTH / 2, y + HEIGHT - 0.3, name, ha="center", va="center", fontsize=13, weight="bold")
        axes.text(x + WIDTH / 2, y + 0.3, f"{MODELS[name]}.fmu", ha="center", va="center", fontsize=9,
                  family="monospace")
    unit = units()
    for source, target, names in CLOSED_LOOP:
        corners, place = LINES[source, target]
        axes.plot(*zip(*corners[:-1]), color="black", linewidth=1.3)
        axes.annotate("", corners[-1], corners[-2],
                      arrowprops={"arrowstyle": "-|>", "color": "black", "linewidth": 1.3, "shrinkA": 0, "shrinkB": 0})
        axes.text(*place, text(names, target, unit, 5 if len(names) > 2 else 1), ha="center", va="bottom", fontsize=10)
    axes.set(xlim=(-0.2, 11.3), ylim=(-0.2, 4.2))
    axes.set_aspect("equal")
    axes.axis("off")
    figure.savefig(ROOT / "docs" / "pictures" / "wiring.png", dpi=130, bbox_inches="tight")


if __name__ == "__main__":
    main()
