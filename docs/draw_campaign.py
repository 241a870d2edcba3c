"""Draws docs/pictures/campaign_flow.svg: what a campaign reads, does and writes.

    .venv/bin/python docs/draw_campaign.py [FOLDER]
"""
import sys
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch

from cosim import pictures
from cosim.pictures import WIDTHS

FILE, WORK = "#f2f2f2", "#dbe9f6"
# name -> centre, width, colour, title, what it has or does; files are grey, what is done is blue with a thick frame.
BOXES: dict[str, tuple[float, float, float, str, str, str]] = {
    "file": (1.3, 5.0, 2.4, FILE, "campaign file", "what flies, draws,\nmetrics, success, seed"),
    "fmus": (1.3, 2.6, 2.4, FILE, "FMUs", "a scenario's,\nor any system's"),
    "plan": (4.7, 5.0, 2.6, WORK, "plan", "all is checked\nbefore the first run"),
    "draws": (4.7, 2.6, 2.6, WORK, "draws", "run number and seed\ngive the values"),
    "workers": (8.2, 2.6, 2.6, WORK, "workers", "fly each run, compute\nmetrics and success"),
    "parts": (11.7, 2.6, 2.6, FILE, "parts/", "rows of each finished\ntask, with a receipt"),
    "tables": (11.7, 0.2, 2.6, FILE, "tables", "runs.parquet,\nsignals.parquet"),
    "statistics": (8.2, 0.2, 2.6, WORK, "statistics", "probabilities,\nwhat failure goes with"),
    "report": (4.7, 0.2, 2.6, FILE, "report", "report.html,\nreport.json, figures/"),
    "said": (8.2, 5.0, 2.6, FILE, "campaign.json", "all that determines\nthe rows, with hashes"),
}
HEIGHT = 1.5
# Corners of each arrow, its label and where that stands, dashed or not.
ARROWS: list[tuple[list[tuple[float, float]], str, tuple[float, float], bool]] = [
    ([(2.5, 5.0), (3.4, 5.0)], "", (0, 0), False),
    ([(2.5, 2.9), (2.95, 2.9), (2.95, 4.6), (3.4, 4.6)], "", (0, 0), False),
    ([(6.0, 5.0), (6.9, 5.0)], "", (0, 0), False),
    ([(4.7, 4.25), (4.7, 3.35)], "", (0, 0), False),
    ([(6.0, 2.6), (6.9, 2.6)], "tasks", (6.45, 2.85), False),
    ([(9.5, 2.6), (10.4, 2.6)], "rows", (9.95, 2.85), False),
    ([(11.7, 1.85), (11.7, 0.95)], "", (0, 0), False),
    ([(10.4, 0.2), (9.5, 0.2)], "", (0, 0), False),
    ([(6.9, 0.2), (6.0, 0.2)], "", (0, 0), False),
    ([(11.7, 3.35), (11.7, 5.0), (9.5, 5.0)], "--resume checks both and\nflies what is missing", (11.55, 5.45), True),
    ([(3.4, 0.2), (1.3, 0.2), (1.3, 1.85)], "the command that\nrepeats a run", (1.3, -0.3), True),
]


def arrow(axes: Axes, corners: list[tuple[float, float]], dashed: bool) -> None:
    line = (0, (3, 1.5)) if dashed else "-"
    axes.plot(*zip(*corners[:-1]), linestyle=line, color="black", linewidth=1.0, zorder=1)
    axes.annotate("", corners[-1], corners[-2],
                  arrowprops={"arrowstyle": "-|>", "color": "black", "linewidth": 1.0, "linestyle": line, "shrinkA": 0,
                              "shrinkB": 0, "mutation_scale": 9})


def draw() -> Figure:
    figure = Figure(figsize=(WIDTHS[2], 3.9))
    axes = figure.add_axes((0, 0, 1, 1))
    for x, y, width, colour, title, text in BOXES.values():
        axes.add_patch(FancyBboxPatch((x - width / 2, y - HEIGHT / 2), width, HEIGHT, facecolor=colour,
                                      boxstyle="round,pad=0,rounding_size=0.12",
                                      edgecolor="black", linewidth=1.6 if colour == WORK else 0.7, zorder=2))
        axes.text(x, y + 0.42, title, weight="bold", ha="center", va="center", zorder=3)
        axes.text(x, y - 0.22, text, ha="center", va="center", fontsize=7, zorder=3)
    for corners, label, place, dashed in ARROWS:
        arrow(axes, corners, dashed)
        axes.text(*place, label, ha="center", va="center", fontsize=7)
    axes.set(xlim=(-0.1, 13.2), ylim=(-0.9, 6.1))
    axes.set_aspect("equal")
    axes.axis("off")
    return figure


def main(folder: Path) -> None:
    with pictures.style():
        pictures.save(draw(), folder / "campaign_flow", pictures.Format("svg"))


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "pictures")
