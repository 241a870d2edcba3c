"""Draws docs/pictures/vehicle.svg: the vehicle from the side with its angles and forces, and the loop that flies it.

    .venv/bin/python docs/draw_vehicle.py [FOLDER]
"""
import sys
from math import cos, radians, sin
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, FancyBboxPatch, Polygon

# The angles are drawn larger than they are flown (in level flight theta is 1.6 deg), so that they can be told apart.
GAMMA, THETA, ELEVATOR = 9.0, 21.0, 24.0
# The body with its nose to the right, in body axes about the centre of gravity: x forward, y up.
BODY = [(-4.6, 0.62), (0.6, 0.62), (4.4, -0.12), (1.5, -0.62), (-1.2, -0.62), (-1.2, -0.45), (-4.6, 0.12)]
ENGINE = [(1.5, -0.62), (1.2, -0.95), (-0.9, -0.95), (-1.2, -0.62)]
HINGE, TAIL = (-3.9, 0.34), (-5.4, 0.34)
FORCES = {"lift": "#2a6f3c", "drag": "#a04040", "thrust": "#b06a00", "weight": "#555555"}


def turned(point: tuple[float, float], degrees: float) -> tuple[float, float]:
    (x, y), c, s = point, cos(radians(degrees)), sin(radians(degrees))
    return c * x - s * y, s * x + c * y


def arrow(axes: Axes, begin: tuple[float, float], end: tuple[float, float], colour: str = "black",
          width: float = 2.0) -> None:
    axes.annotate("", end, begin, arrowprops={"arrowstyle": "-|>", "color": colour, "linewidth": width, "shrinkA": 0,
                                              "shrinkB": 0, "mutation_scale": 14}, zorder=5)


def angle(axes: Axes, radius: float, low: float, high: float, label: str, at: tuple[float, float]) -> None:
    """An arc about the centre of gravity from `low` to `high` degrees; its label `at` (radius, degrees)."""
    axes.add_patch(Arc((0, 0), 2 * radius, 2 * radius, theta1=low, theta2=high, linewidth=1.3, zorder=4))
    axes.text(*turned((at[0], 0), at[1]), label, fontsize=14, ha="center", va="center", zorder=6)


def vehicle(axes: Axes) -> None:
    axes.add_patch(Polygon([turned(p, THETA) for p in BODY], facecolor="#dbe9f6", edgecolor="black", linewidth=1.4))
    axes.add_patch(Polygon([turned(p, THETA) for p in ENGINE], facecolor="#b9c9da", edgecolor="black", linewidth=1.4))
    hinge, tail = turned(HINGE, THETA), turned(TAIL, THETA)
    edge = tuple(h + d for h, d in zip(hinge, turned((TAIL[0] - HINGE[0], 0), THETA + ELEVATOR)))
    axes.plot(*zip(hinge, tail), "k:", linewidth=1.2)
    axes.plot(*zip(hinge, edge), color="#4060a0", linewidth=6, solid_capstyle="round", zorder=4)
    axes.text(edge[0] - 0.15, edge[1] - 0.1, r"elevator $\delta_e$", fontsize=12, ha="right", va="center",
              color="#4060a0")
    axes.add_patch(Arc(hinge, 2.5, 2.5, theta1=180 + THETA, theta2=180 + THETA + ELEVATOR, linewidth=1.3, zorder=4))

    ends = {"horizon": (turned((7.4, 0), 0), "#999999"), "path": (turned((7.6, 0), GAMMA), "black"),
            "axis": (turned((7.6, 0), THETA), "#4060a0")}
    for end, colour in ends.values():
        axes.plot(*zip((0, 0), end), "--", color=colour, linewidth=1.0, zorder=3)
    arrow(axes, (0, 0), turned((6.6, 0), GAMMA), width=2.4)
    x, y = turned((6.9, 0), GAMMA)
    axes.text(x, y + 0.28, "$V$", fontsize=15, ha="left", va="center")
    axes.text(7.5, -0.02, "horizon", fontsize=10, ha="left", va="center", color="#777777")
    axes.text(*turned((7.65, 0), THETA), "body axis", fontsize=10, ha="left", va="bottom", color="#4060a0")
    angle(axes, 5.4, 0, GAMMA, r"$\gamma$", (5.7, 4.5))
    angle(axes, 6.0, GAMMA, THETA, r"$\alpha$", (6.3, 15))
    angle(axes, 4.6, 0, THETA, r"$\theta$", (4.3, 4.5))
    axes.add_patch(Arc((0, 0), 3.4, 3.4, theta1=38, theta2=72, linewidth=1.5, zorder=4))
    arrow(axes, turned((1.7, 0), 70), turned((1.7, 0), 76), width=1.5)
    axes.text(*turned((2.35, 0), 58), "$Q,\\ M$", fontsize=14, ha="center", va="center")

    for word, label, begin, end, (dx, dy) in (
            ("lift", "lift $L$", (0, 0), turned((0, 3.1), GAMMA), (0.15, 0.15)),
            ("drag", "drag $D$", (0, 0), turned((-6.3, 0), GAMMA), (-0.1, -0.38)),
            ("weight", "weight $mg$", (0, 0), (0, -2.9), (0.15, 0.05)),
            ("thrust", "thrust $T$", turned((-1.0, -0.78), THETA), turned((2.4, -0.78), THETA), (0.1, -0.45))):
        arrow(axes, begin, end, FORCES[word])
        axes.text(end[0] + dx, end[1] + dy, label, fontsize=12, color=FORCES[word], ha="left" if dx > 0 else "center")
    axes.plot(0, 0, "o", color="black", markersize=6, zorder=7)
    axes.text(-7.5, 3.75, "All in their positive sense. A positive elevator pitches the nose down.", fontsize=10,
              ha="left", va="center", color="#444444")


def loop(axes: Axes) -> None:
    boxes = {"AhvScenario": (10.9, 2.6, "#f2f2f2", "commands"),
             "AhvController": (15.6, 2.6, "#fdf0d5", "control law"),
             "AhvPlant": (15.6, -1.8, "#dbe9f6", "vehicle")}
    for name, (x, y, colour, role) in boxes.items():
        axes.add_patch(FancyBboxPatch((x - 1.55, y - 0.65), 3.1, 1.3, boxstyle="round,pad=0,rounding_size=0.12",
                                      facecolor=colour, edgecolor="black", linewidth=1.3))
        axes.text(x, y + 0.2, name, fontsize=12, weight="bold", ha="center", va="center")
        axes.text(x, y - 0.27, role, fontsize=10, ha="center", va="center", color="#444444")
    for points, label, (x, y), side in (
            (((12.45, 2.6), (14.05, 2.6)), "$V_c,\\ h_c$", (13.2, 2.9), "center"),
            (((14.9, 1.95), (14.9, -1.15)), "fuel ratio $\\Phi$\nelevator $\\delta_e$", (14.7, 0.4), "right"),
            (((16.3, -1.15), (16.3, 1.95)), "$V,\\ h,$\n$\\gamma,\\ \\theta,\\ Q$", (16.5, 0.4), "left"),
            (((10.9, 1.95), (10.9, -1.8), (14.05, -1.8)), "uncertain\ncoefficients", (11.1, -1.1), "left")):
        axes.plot(*zip(*points[:-1]), color="black", linewidth=1.4)
        arrow(axes, points[-2], points[-1], width=1.4)
        axes.text(x, y, label, fontsize=11, ha=side, va="center")


def draw() -> Figure:
    figure = Figure(figsize=(12.6, 3.72))
    axes = figure.add_axes((0, 0, 1, 1))
    vehicle(axes)
    loop(axes)
    axes.set(xlim=(-7.7, 18.1), ylim=(-3.5, 4.1))
    axes.set_aspect("equal")
    axes.axis("off")
    return figure


def main(folder: Path) -> None:
    matplotlib.rcParams["svg.hashsalt"] = "ahv"  # the same bytes each time
    draw().savefig(folder / "vehicle.svg", facecolor="white", metadata={"Date": None})


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "pictures")
