"""Draws the block diagrams of the control laws, docs/pictures/blocks_*.svg, from the tables below.

    .venv/bin/python docs/draw_blocks.py [FOLDER]
"""
import sys
from dataclasses import dataclass
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyBboxPatch

SCALE = 0.92  # inches for each unit of the tables
# Colour and frame (style, width in points): the frame tells the kinds apart in grey.
KINDS = {"block": ("#eef3f9", "-", 0.9), "learns": ("#fdf0d5", "-", 2.2), "limit": ("#f3e3e3", "--", 1.2)}
RADIUS = 0.16  # of a summing point


@dataclass(frozen=True)
class Block:
    """Centre, width, text, note below it, kind: a box, "sum" for a summing point, "text" for a signal's name."""
    x: float
    y: float
    width: float
    text: str
    note: str = ""
    kind: str = "block"
    height: float = 0.9


# Arrows: from, to, the label, where it stands, its corners, dashed or not. "x3 y2": along x to 3, then along y to 2.
# An end is BLOCK.SIDE with an optional offset along the side (ref.e+0.2), or a point of its own, "3,2.5".
Arrow = tuple[str, str, str, tuple[float, float] | None, str, bool]

NEURAL: tuple[dict[str, Block], list[Arrow]] = ({
    "Vc": Block(0.25, 7.0, 0.9, "$V_{command}$", kind="text"),
    "ref1": Block(1.75, 7.0, 1.5, "Reference\nfilter", "(67)"),
    "sum1": Block(3.35, 7.0, 0, "", kind="sum"),
    "pi": Block(5.0, 7.0, 1.7, "PI and feed-\nforward $\\Phi_0$", "below (19)"),
    "sum2": Block(6.75, 7.0, 0, "", kind="sum"),
    "gain1": Block(7.8, 7.0, 1.0, "$1/k_V$", "(19)"),
    "lim1": Block(9.4, 7.0, 1.3, "Limits\n0.05 … 1.5", kind="limit"),
    "Phi": Block(10.75, 7.0, 0.4, "$\\Phi$", kind="text"),
    "ad1": Block(4.35, 5.3, 1.6, "Adapted\nparameter $\\hat\\varphi_1$", "(27)", "learns"),
    "net1": Block(6.75, 5.3, 1.9, "Network 1: $\\Phi_1$", "(26)", "learns"),
    "V1": Block(3.35, 6.1, 0.3, "$V$", kind="text"),
    "X1": Block(8.75, 5.3, 1.2, "$V,\\ \\Phi_0,\\ \\tilde V$", kind="text"),

    "hc": Block(0.25, 3.6, 0.9, "$h_{command}$", kind="text"),
    "ref2": Block(1.75, 3.6, 1.5, "Reference\nfilter", "(67)"),
    "gd": Block(4.3, 3.6, 1.8, "Flight-path\ncommand $\\gamma_d$", "(36)"),
    "hd": Block(6.75, 3.6, 1.9, "Differentiator\non $\\gamma_d$, $R_d$", "(13)"),
    "hV": Block(4.3, 2.75, 0.8, "$h,\\ V$", kind="text"),
    "meas": Block(0.9, 1.9, 1.0, "$\\gamma,\\ \\theta,\\ Q$", kind="text"),
    "ang": Block(4.3, 1.9, 1.8, "Tracked angle $y$", "$\\gamma + c_\\theta(\\theta-\\theta_{trim}) + c_Q Q$"),
    "hy": Block(6.75, 1.9, 1.9, "Differentiator\non $y$, $R$", "(13), $\\hat z_3 = \\ell(Q-\\hat z_2)$"),
    "ef": Block(9.4, 2.75, 1.7, "Error function $\\hat E$\nwith $\\int e_0$", "(43), (47), (48)", height=1.1),

    "d0": Block(2.3, 0.0, 1.7, "Control $\\delta_{e0}$", "(49)"),
    "sum3": Block(4.1, 0.0, 0, "", kind="sum"),
    "gain2": Block(5.35, 0.0, 1.2, "sign $/\\,k_h$", "(49)"),
    "filt": Block(7.25, 0.0, 1.5, "Structural\nfilter", "preset coupled only"),
    "lim2": Block(9.4, 0.0, 1.3, "Limits\n±20°", kind="limit"),
    "de": Block(10.75, 0.0, 0.4, "$\\delta_e$", kind="text"),
    "net2": Block(4.1, -1.5, 1.9, "Network 2: $\\delta_{e1}$", "(56)", "learns"),
    "ad2": Block(1.6, -1.5, 1.6, "Adapted\nparameter $\\hat\\varphi_2$", "(57)", "learns"),
    "X2": Block(6.35, -1.5, 1.5, "$\\gamma,\\ \\theta,\\ Q,\\ \\delta_{e0},\\ \\hat E$", kind="text"),
}, [
    ("Vc.e", "ref1.w", "", None, "", False),
    ("ref1.e", "sum1.w", "$V_{ref}$   $-$", (2.93, 7.15), "", False),
    ("ref1.n", "pi.n-0.45", "$\\dot V_{ref}$", (2.9, 7.95), "y7.8", False),
    ("V1.n", "sum1.s", "", None, "", False),
    ("sum1.e", "pi.w", "$\\tilde V$", (3.8, 7.15), "", False),
    ("pi.e", "sum2.w", "$\\Phi_0$", (6.2, 7.15), "", False),
    ("sum2.e", "gain1.w", "", None, "", False),
    ("gain1.e", "lim1.w", "", None, "", False),
    ("lim1.e", "Phi.w", "", None, "", False),
    ("net1.n", "sum2.s", "$-$", (6.9, 6.65), "", False),
    ("ad1.e+0.2", "net1.w+0.2", "$\\hat\\varphi_1$", (5.48, 5.65), "", False),
    ("net1.w-0.2", "ad1.e-0.2", "$h_1^Th_1$", (5.48, 4.95), "", False),
    ("X1.w", "net1.e", "", None, "", False),
    ("3.9,7.0", "ad1.n-0.45", "", None, "", False),
    ("lim1.n", "pi.n+0.45", "saturated: the integral stands still", (7.5, 8.0), "y7.8", True),
    ("hc.e", "ref2.w", "", None, "", False),
    ("ref2.e", "gd.w", "$h_{ref},\\ \\dot h_{ref}$", (2.95, 3.78), "", False),
    ("hV.n", "gd.s", "", None, "", False),
    ("gd.e", "hd.w", "$\\gamma_d$", (5.5, 3.75), "", False),
    ("hd.e", "ef.n-0.3", "$\\gamma_d, \\dot\\gamma_d, \\ddot\\gamma_d, \\dddot\\gamma_d$", (8.4, 3.8), "", False),
    ("meas.e", "ang.w", "", None, "", False),
    ("ang.e", "hy.w", "$y$", (5.5, 2.05), "", False),
    ("hy.e", "ef.s-0.3", "$y,\\ \\hat z_2,\\ \\hat z_3$", (8.35, 1.72), "", False),
    ("ef.s+0.1", "d0.n", "$\\hat E,\\ e_0,\\ \\dot e_0,\\ \\ddot e_0,\\ \\dddot\\gamma_d$", (3.3, 0.75), "y1.0", False),
    ("d0.e", "sum3.w", "$\\delta_{e0}$", (3.5, 0.15), "", False),
    ("sum3.e", "gain2.w", "", None, "", False),
    ("gain2.e", "filt.w", "", None, "", False),
    ("filt.e", "lim2.w", "", None, "", False),
    ("lim2.e", "de.w", "", None, "", False),
    ("net2.n", "sum3.s", "$-$", (4.25, -0.35), "", False),
    ("ad2.e+0.2", "net2.w+0.2", "$\\hat\\varphi_2$", (2.78, -1.15), "", False),
    ("net2.w-0.2", "ad2.e-0.2", "$h_2^Th_2$", (2.78, -1.85), "", False),
    ("X2.w", "net2.e", "", None, "", False),
    ("2.3,1.0", "ad2.n-0.4", "$\\hat E$", (1.0, 0.75), "x1.2", False),
    ("lim2.n+0.5", "ef.s+0.5", "saturated: $\\int e_0$ stands still", (8.7, 0.68), "", True),
])

BACKSTEPPING: tuple[dict[str, Block], list[Arrow]] = ({
    "Vc": Block(0.25, 5.2, 0.9, "$V_{command}$", kind="text"),
    "ref1": Block(1.75, 5.2, 1.5, "Reference\nfilter", "(67)"),
    "sum1": Block(3.35, 5.2, 0, "", kind="sum"),
    "V1": Block(3.35, 4.3, 0.3, "$V$", kind="text"),
    "pi": Block(5.0, 5.2, 1.7, "PI and feed-\nforward $\\dot V_d$", "$k_{V1},\\ k_{V2}$"),
    "inv1": Block(7.2, 5.2, 1.7, "Inverse of the\nnominal model", "$f_V,\\ b_V$"),
    "lim1": Block(9.4, 5.2, 1.3, "Limits\n0.05 … 1.5", kind="limit"),
    "Phi": Block(10.75, 5.2, 0.4, "$\\Phi$", kind="text"),
    "obs1": Block(7.2, 3.8, 1.7, "Disturbance\nobserver $\\hat d_V$", "observer_V", "learns"),

    "hc": Block(0.25, 1.6, 0.9, "$h_{command}$", kind="text"),
    "ref2": Block(1.75, 1.6, 1.5, "Reference\nfilter", "(67)"),
    "gd": Block(3.7, 1.6, 1.2, "$\\gamma_d$", "(36)  $k_\\gamma$"),
    "td": Block(5.4, 1.6, 1.2, "$\\theta_d$", "k_path"),
    "qd": Block(7.1, 1.6, 1.2, "$Q_d$", "k_theta"),
    "de": Block(8.8, 1.6, 1.2, "$\\delta_e$", "k_Q"),
    "lim2": Block(10.4, 1.6, 1.1, "Limits\n±20°", kind="limit"),
    "out": Block(11.5, 1.6, 0.4, "$\\delta_e$", kind="text"),
    "t1": Block(4.55, 2.8, 1.2, "Differentiator", "R_gamma", height=0.7),
    "t2": Block(6.25, 2.8, 1.2, "Differentiator", "R_theta", height=0.7),
    "t3": Block(7.95, 2.8, 1.2, "Differentiator", "R_Q", height=0.7),
    "hV": Block(3.7, 0.65, 0.8, "$h,\\ V$", kind="text"),
    "og": Block(5.4, 0.1, 1.5, "Disturbance\nobserver $\\hat d_\\gamma$", "observer_gamma", "learns"),
    "th": Block(7.1, 0.65, 0.5, "$\\theta$", kind="text"),
    "oq": Block(8.8, 0.1, 1.5, "Disturbance\nobserver $\\hat d_Q$", "observer_Q", "learns"),
    "gm": Block(4.0, 0.1, 0.6, "$\\gamma,\\ \\theta$", kind="text"),
    "Qm": Block(7.5, 0.1, 0.4, "$Q$", kind="text"),
    "Vm": Block(5.75, 3.8, 0.4, "$V$", kind="text"),
}, [
    ("Vc.e", "ref1.w", "", None, "", False),
    ("ref1.e", "sum1.w", "$V_{ref}$   $-$", (2.93, 5.35), "", False),
    ("ref1.n", "pi.n-0.45", "$\\dot V_{ref}$", (2.9, 6.15), "y6.0", False),
    ("V1.n", "sum1.s", "", None, "", False),
    ("sum1.e", "pi.w", "$\\tilde V$", (3.8, 5.35), "", False),
    ("pi.e", "inv1.w", "", None, "", False),
    ("inv1.e", "lim1.w", "", None, "", False),
    ("lim1.e", "Phi.w", "", None, "", False),
    ("obs1.n", "inv1.s", "$-\\hat d_V$", (7.55, 4.52), "", False),
    ("Vm.e", "obs1.w", "", None, "", False),
    ("lim1.s", "obs1.e", "$\\Phi$ as sent", (9.05, 3.95), "", False),
    ("lim1.n", "pi.n+0.45", "saturated: the integral stands still", (7.5, 6.2), "y6.0", True),
    ("hc.e", "ref2.w", "", None, "", False),
    ("ref2.e", "gd.w", "", None, "", False),
    ("hV.n", "gd.s", "", None, "", False),
    ("gd.e", "td.w", "", None, "", False),
    ("td.e", "qd.w", "", None, "", False),
    ("qd.e", "de.w", "", None, "", False),
    ("de.e", "lim2.w", "", None, "", False),
    ("lim2.e", "out.w", "", None, "", False),
    ("4.55,1.6", "t1.s", "", None, "", False),
    ("t1.e", "td.n", "$\\dot\\gamma_d$", (5.6, 2.3), "", False),
    ("6.25,1.6", "t2.s", "", None, "", False),
    ("t2.e", "qd.n", "$\\dot\\theta_d$", (7.3, 2.3), "", False),
    ("7.95,1.6", "t3.s", "", None, "", False),
    ("t3.e", "de.n", "$\\dot Q_d$", (9.0, 2.3), "", False),
    ("og.n", "td.s", "$\\gamma,\\ -\\hat d_\\gamma$", (5.85, 0.85), "", False),
    ("th.n", "qd.s", "", None, "", False),
    ("oq.n", "de.s", "$Q,\\ -\\hat d_Q$", (9.3, 0.85), "", False),
    ("gm.e", "og.w", "", None, "", False),
    ("Qm.e", "oq.w", "", None, "", False),
    ("lim2.s", "oq.e", "$\\delta_e$ as sent", (10.15, -0.1), "", False),
])

RESILIENT: tuple[dict[str, Block], list[Arrow]] = ({
    "Vc": Block(0.25, 7.0, 0.9, "$V_{command}$", kind="text"),
    "ref1": Block(1.75, 7.0, 1.5, "Reference\nfilter", "(67)"),
    "inv1": Block(5.6, 7.0, 2.3, "Fuel ratio for the speed:\ninverse of the model", "k_V, at most V_recovery",
                  height=1.0),
    "V": Block(3.3, 6.75, 0.7, "$\\hat V,\\ \\hat d_V$", kind="text"),
    "share": Block(12.1, 5.8, 1.9, "Thrust pitches\nwith what the\nelevator's band\nleaves", "elevator_band",
                   height=3.4),
    "lim1": Block(14.1, 7.0, 1.3, "Limits\n0.05 … 1.5", kind="limit"),
    "Phi": Block(15.4, 7.0, 0.4, "$\\Phi$", kind="text"),

    "hc": Block(0.25, 4.6, 0.9, "$h_{command}$", kind="text"),
    "ref2": Block(1.75, 4.6, 1.5, "Reference\nfilter", "(67)"),
    "alt": Block(4.1, 4.6, 1.8, "Altitude → lift\n→ wanted $\\alpha$", "k_gamma, k_path", height=1.0),
    "min": Block(6.15, 4.6, 1.2, "Not above\nthe limit", kind="limit"),
    "rate": Block(8.0, 4.6, 1.5, "Wanted\npitch rate", "k_alpha, k_barrier", height=1.0),
    "mom": Block(9.75, 4.6, 1.2, "Moment\ndemand", "k_Q", height=1.0),
    "Q": Block(10.1, 3.4, 0.4, "$\\hat Q$", kind="text"),
    "filt": Block(9.75, 6.05, 1.5, "Structural\nfilter", "coupled only"),
    "lim2": Block(14.1, 4.6, 1.3, "Limits\n±20°", kind="limit"),
    "de": Block(15.4, 4.6, 0.4, "$\\delta_e$", kind="text"),

    "hg": Block(0.5, 3.0, 0.6, "$h,\\ \\gamma$", kind="text"),
    "slow": Block(1.9, 3.0, 1.5, "Filters", "filter_h, filter_gamma"),
    "top": Block(8.0, 2.6, 2.2, "Largest $\\alpha$ that the\nelevator can hold", "alpha_margin, barrier_margin",
                 "limit", 1.0),
    "meas": Block(0.4, 0.6, 0.8, "$V,\\ \\gamma,\\ Q$", kind="text"),
    "obs": Block(2.1, 0.6, 1.8, "Three observers", "observer_V, _gamma, _Q", "learns", 1.0),
    "sent": Block(2.1, -0.7, 1.6, "$\\Phi,\\ \\delta_e$ as sent", kind="text"),
    "lift": Block(4.1, 2.3, 1.6, "Lift scale $\\hat s_L$", "filter_lift, lift_lead", "learns"),
    "sM": Block(5.2, 0.6, 1.8, "Moment scale $\\hat s_M$", "moment_gain", "learns"),
    "hold": Block(8.0, 0.6, 2.0, "Elevator $\\delta_h$ that\nholds the present $\\alpha$", "hold_rate", height=1.0),
}, [
    ("Vc.e", "ref1.w", "", None, "", False),
    ("ref1.e+0.2", "inv1.w+0.2", "$V_{ref},\\ \\dot V_{ref}$", (3.35, 7.38), "", False),
    ("V.e", "inv1.w-0.25", "", None, "", False),
    ("inv1.e", "share.w+1.2", "$\\Phi_V$", (8.5, 7.15), "", False),
    ("share.e+1.2", "lim1.w", "", None, "", False),
    ("lim1.e", "Phi.w", "", None, "", False),
    ("hc.e", "ref2.w", "", None, "", False),
    ("ref2.e", "alt.w", "$h_{ref},\\ \\dot h_{ref},\\ \\ddot h_{ref}$", (2.9, 5.25), "", False),
    ("hg.e", "slow.w", "", None, "", False),
    ("slow.e", "alt.s-0.5", "", None, "x3.6", False),
    ("lift.n", "alt.s", "$\\hat s_L$", (4.35, 3.4), "", False),
    ("alt.e", "min.w", "$\\alpha_{des}$", (5.28, 4.78), "", False),
    ("min.e", "rate.w", "$\\alpha_c$", (7.0, 4.78), "", False),
    ("rate.e", "mom.w", "", None, "", False),
    ("mom.n", "filt.s", "", None, "", False),
    ("filt.e", "share.w+0.25", "demand", (10.82, 6.2), "", False),
    ("share.e-1.2", "lim2.w", "", None, "", False),
    ("lim2.e", "de.w", "", None, "", False),
    ("top.w", "min.s", "limit", (6.5, 3.3), "x6.15", False),
    ("top.n", "rate.s", "stop", (8.3, 3.6), "", False),
    ("hold.n", "top.s", "$\\delta_h$", (8.3, 1.6), "", False),
    ("hold.e", "share.s", "$\\delta_h$", (10.6, 0.78), "", False),
    ("meas.e", "obs.w", "", None, "", False),
    ("sent.n", "obs.s", "", None, "", False),
    ("2.5,1.1", "lift.w", "", None, "y2.3", False),
    ("obs.e", "sM.w", "$\\hat d_Q$", (3.65, 0.78), "", False),
    ("sM.e", "hold.w", "$\\hat s_M,\\ \\hat d_Q$", (6.55, 0.78), "", False),
    ("6.55,0.6", "mom.s", "$\\hat s_M,\\ \\hat d_Q$", (9.2, -0.55), "y-0.7 x9.75", False),
    ("Q.n", "mom.s+0.35", "", None, "", False),
])
DIAGRAMS = {"neural": NEURAL, "backstepping": BACKSTEPPING, "resilient": RESILIENT}


def end(blocks: dict[str, Block], word: str) -> tuple[float, float]:
    """The point that an arrow's end names."""
    if "," in word:
        x, y = map(float, word.split(","))
        return x, y
    name, _, place = word.partition(".")
    block, side, offset = blocks[name], place[0], float(place[1:] or 0)
    half, tall = ((RADIUS, RADIUS) if block.kind == "sum" else
                  (block.width / 2, 0.17 if block.kind == "text" else block.height / 2))
    return {"n": (block.x + offset, block.y + tall), "s": (block.x + offset, block.y - tall),
            "e": (block.x + half, block.y + offset), "w": (block.x - half, block.y + offset)}[side]


def corners(blocks: dict[str, Block], arrow: Arrow) -> list[tuple[float, float]]:
    """The arrow's points, each leg along x or along y."""
    begin, target, _, _, via, _ = arrow
    points, last = [end(blocks, begin)], end(blocks, target)
    for move in via.split():
        x, y = points[-1]
        points.append((float(move[1:]), y) if move[0] == "x" else (x, float(move[1:])))
    x, y = points[-1]
    if x != last[0] and y != last[1]:
        arrives_vertically = "." in target and "," not in target and target.partition(".")[2][0] in "ns"
        points.append((last[0], y) if arrives_vertically else (x, last[1]))
    return [*points, last]


def draw_block(axes: Axes, block: Block) -> None:
    if block.kind == "sum":
        axes.add_patch(Circle((block.x, block.y), RADIUS, facecolor="white", edgecolor="black", zorder=2))
        axes.text(block.x, block.y, "Σ", ha="center", va="center", fontsize=9, zorder=3)
        return
    if block.kind != "text":
        corner = block.x - block.width / 2, block.y - block.height / 2
        colour, frame, width = KINDS[block.kind]
        axes.add_patch(FancyBboxPatch(corner, block.width, block.height, boxstyle="round,pad=0,rounding_size=0.08",
                                      facecolor=colour, edgecolor="black", linestyle=frame, linewidth=width, zorder=2))
    lift = 0.13 if block.note else 0.0
    axes.text(block.x, block.y + lift, block.text, ha="center", va="center", fontsize=10, linespacing=1.25, zorder=3)
    axes.text(block.x, block.y - block.height / 2 + 0.13, block.note, ha="center", va="center", fontsize=8,
              color="#444444", zorder=3)


def draw(blocks: dict[str, Block], arrows: list[Arrow]) -> Figure:
    xs = [b.x for b in blocks.values()]
    ys = [b.y for b in blocks.values()] + [y for arrow in arrows for _, y in corners(blocks, arrow)]
    left, right, low, high = min(xs) - 0.5, max(xs) + 0.4, min(ys) - 0.6, max(ys) + 0.5
    figure = Figure(figsize=((right - left) * SCALE, (high - low) * SCALE))
    axes = figure.add_axes((0, 0, 1, 1))
    for block in blocks.values():
        draw_block(axes, block)
    for arrow in arrows:
        _, _, label, place, _, dashed = arrow
        points = corners(blocks, arrow)
        style, colour = ("--", "#a04040") if dashed else ("-", "black")
        axes.plot(*zip(*points[:-1]), style, color=colour, linewidth=1.1, zorder=1)
        axes.annotate("", points[-1], points[-2],
                      arrowprops={"arrowstyle": "-|>", "color": colour, "linewidth": 1.1, "linestyle": style,
                                  "shrinkA": 0, "shrinkB": 0, "mutation_scale": 11}, zorder=1)
        if place:
            axes.text(*place, label, ha="center", va="center", fontsize=9, color=colour)
    axes.set(xlim=(left, right), ylim=(low, high))
    axes.set_aspect("equal")
    axes.axis("off")
    return figure


def main(folder: Path) -> None:
    matplotlib.rcParams["svg.hashsalt"] = "ahv"  # the same bytes each time
    for name, (blocks, arrows) in DIAGRAMS.items():
        draw(blocks, arrows).savefig(folder / f"blocks_{name}.svg", facecolor="white", metadata={"Date": None})


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "pictures")
