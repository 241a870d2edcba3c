"""Draws docs/pictures/stepping.svg: what Jacobi and Gauss-Seidel do in time with two components.

    .venv/bin/python docs/draw_stepping.py [FOLDER]
"""
import sys
from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cosim import pictures
from cosim.pictures import BLUE, RED, WIDTHS

STEP, ROWS = 4.0, {"A": 2.0, "B": 0.0}
# Number of the moment, from, to; an end is a component and a communication point. A dashed arrow is a value that is
# read at its begin and is the input during the step that begins at its end.
Arrow = tuple[str, tuple[str, int], tuple[str, int]]
STEPS: dict[str, tuple[str, list[Arrow], list[Arrow]]] = {
    "Jacobi": ("Both components step with what the other had at the start of the step.",
               [("2", ("A", k), ("A", k + 1)) for k in (0, 1)] + [("2", ("B", k), ("B", k + 1)) for k in (0, 1)],
               [("1", ("A", k), ("B", k)) for k in (0, 1)] + [("1", ("B", k), ("A", k)) for k in (0, 1)]),
    "Gauss-Seidel": ("A steps first, with what B had at the start. Then B steps, with what A has at the end.",
                     [("2", ("A", k), ("A", k + 1)) for k in (0, 1)] + [("4", ("B", k), ("B", k + 1)) for k in (0, 1)],
                     [("1", ("B", k), ("A", k)) for k in (0, 1)] + [("3", ("A", k + 1), ("B", k)) for k in (0, 1)]),
}


def place(end: tuple[str, int]) -> tuple[float, float]:
    return end[1] * STEP, ROWS[end[0]]


def arrow(axes: Axes, begin: tuple[float, float], end: tuple[float, float], colour: str, **line: object) -> None:
    axes.annotate("", end, begin, arrowprops={"arrowstyle": "-|>", "color": colour, "shrinkA": 4, "shrinkB": 4,
                                              "mutation_scale": 9, **line}, zorder=4)


def number(axes: Axes, x: float, y: float, word: str, colour: str) -> None:
    axes.text(x, y, word, ha="center", va="center", fontsize=7, color="white", zorder=6,
              bbox={"boxstyle": "circle,pad=0.2", "facecolor": colour, "edgecolor": "none"})


def draw_one(axes: Axes, title: str) -> None:
    remark, steps, values = STEPS[title]
    for name, y in ROWS.items():
        axes.plot([-0.4, 2 * STEP + 0.6], [y, y], "-", color="0.8", linewidth=0.8, zorder=1)
        axes.text(-0.6, y, name, ha="right", va="center", weight="bold", fontsize=9)
        axes.plot([k * STEP for k in range(3)], [y] * 3, "o", linestyle="none", color="black", markersize=4, zorder=5)
    for k, word in enumerate(("$t$", "$t + H$", "$t + 2H$")):
        axes.plot([k * STEP] * 2, [-0.5, 2.4], "-", color="0.85", linewidth=0.8, zorder=0)
        axes.text(k * STEP, -0.85, word, ha="center", va="center")
    for word, begin, end in steps:
        (x, y), (to, _) = place(begin), place(end)
        arrow(axes, (x, y), (to, y), BLUE, linewidth=2.2)
        number(axes, (x + to) / 2, y, word, BLUE)
    for word, begin, end in values:
        (x, y), (to, down) = place(begin), place(end)
        bend = 0.22 if x == to else 0.0  # two arrows between the same ends keep apart
        arrow(axes, (x, y), (to, down), RED, linewidth=1.2, linestyle=(0, (3, 1.5)),
              connectionstyle=f"arc3,rad={bend}")
        side = 0.32 if y < down else -0.32
        number(axes, (x + to) / 2 + (side if x == to else 0), (y + down) / 2, word, RED)
    axes.set_title(title, weight="bold")
    axes.text(STEP, -1.5, remark, ha="center", va="center", fontsize=7, wrap=True)
    axes.set(xlim=(-1.2, 2 * STEP + 0.9), ylim=(-1.9, 2.6))
    axes.axis("off")


def draw() -> Figure:
    figure = Figure(figsize=(WIDTHS[2], 4.4))
    for axes, title in zip(figure.subplots(2, 1), STEPS):
        draw_one(axes, title)
    figure.subplots_adjust(left=0.01, right=0.99, bottom=0.08, top=0.93, hspace=0.2)
    figure.text(0.5, 0.02, "Full: a component steps. Dashed: a value that the other holds as its input during its step."
                " Numbers: the order within a step of length H.", ha="center", fontsize=7)
    return figure


def main(folder: Path) -> None:
    with pictures.style():
        pictures.save(draw(), folder / "stepping", pictures.Format("svg"))


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "pictures")
