"""What a grid shows: its least and greatest figures, and a picture of each metric over the swept variables."""
from collections.abc import Callable, Mapping, Sequence
from itertools import islice, product
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure

from ..master.measures import parse
from ..master.system import Value
from ..pictures import COLOURS, LINES, MARKS, RED, SKY
from ..text import without_math
from .charts import figure, wide
from .plan import Plan
from .sampling import Draw
from .statistics import Results

MAP = colormaps["cividis"].with_extremes(under=SKY, over=RED)
MOST_PANELS, MOST_TICKS, MOST_NUMBERS = 24, 9, 50  # of a figure, of an axis, written into the cells of a panel


def shown_metrics(plan: Plan) -> list[str]:
    """The metrics that are drawn: the file's own and those of its criteria, else the one that ranks runs."""
    used = [name for text in plan.campaign.success.values() for name in parse(text).names if name in plan.metrics]
    return list(dict.fromkeys([*plan.campaign.metrics, *used])) or ([plan.worst_by] if plan.worst_by else [])


def cells(r: Results, column: str, shape: Sequence[int]) -> np.ndarray:
    """A column over the grid, shape `shape`; NaN where a run was not judged or has no value."""
    found = np.full(shape, np.nan)
    found.flat[r.table["run"].to_numpy()] = r.columns[column].astype(float)
    return found


def extremes(plan: Plan, r: Results) -> dict[str, Any]:
    """Metric -> its least and its greatest value, and where in the grid these are."""
    draws, found = plan.draws[r.law], {}
    for name in shown_metrics(plan):
        over = cells(r, name, [len(d.levels) for d in draws])
        finite = np.where(np.isfinite(over), over, np.nan)
        if np.isfinite(finite).any():
            found[name] = {word: {"value": float(finite.flat[k]), "run": int(k),
                                  "at": {d.name: d.levels[i] for d, i in zip(draws, np.unravel_index(k, over.shape))}}
                           for word, k in (("least", np.nanargmin(finite)), ("greatest", np.nanargmax(finite)))}
    return found


def pictures(plan: Plan, results: list[Results]) -> dict[str, Callable[[], Figure]]:
    """File name -> how to draw it: a picture of each metric."""
    draws = plan.draws[plan.laws[0]]
    draw = lines if len([d for d in draws if len(d.levels) > 1]) < 2 else maps
    return {f"sweep_{name}": lambda name=name: draw(plan, results, name)  # type: ignore[misc]
            for name in shown_metrics(plan)}


def label(plan: Plan, draw: Draw) -> str:
    """A swept variable on an axis."""
    unit = plan.labels[draw.name].unit
    return without_math(f"{draw.name} ({unit})" if unit else draw.name)


def metric_label(plan: Plan, name: str) -> str:
    """A metric on an axis."""
    unit = plan.metrics[name].unit
    return without_math(f"{name} ({unit})" if unit else name)


def written(value: Value) -> str:
    """A level for people."""
    return f"{value:g}" if isinstance(value, float) else str(value)


def places(levels: Sequence[Value]) -> np.ndarray:
    """Where levels lie on an axis, shape (levels,): at their values if these are numbers, else side by side."""
    numbers = all(isinstance(x, int | float) and not isinstance(x, bool) for x in levels)
    return np.array(levels, float) if numbers else np.arange(len(levels), dtype=float)


def tick(axis: Any, levels: Sequence[Value]) -> None:
    """Ticks at the levels, at some of them where there are many."""
    every = -(-len(levels) // MOST_TICKS)
    axis.set_ticks(places(levels)[::every], [without_math(written(x)) for x in levels[::every]])


def lines(plan: Plan, results: list[Results], metric: str) -> Figure:
    """A metric over the one variable that varies, a line for each variant."""
    made, axes = figure(4.5)
    axis = axes[0, 0]
    draws = plan.draws[plan.laws[0]]
    across = max(range(len(draws)), key=lambda i: len(draws[i].levels))
    x, failed = places(draws[across].levels), False
    order = np.argsort(x)
    for i, r in enumerate(results):
        shape = [len(d.levels) for d in plan.draws[r.law]]
        y, success = cells(r, metric, shape).ravel(), cells(r, "success", shape).ravel()
        axis.plot(x[order], y[order], marker=MARKS[i % len(MARKS)], linestyle=LINES[i % len(LINES)],
                  color=COLOURS[i % len(COLOURS)], ms=5, label=without_math(r.law))
        if (success == 0).any():
            axis.plot(x[success == 0], y[success == 0], "x", color="k", ms=9, label="" if failed else "no success")
            failed = True
    if wide(np.concatenate([line.get_ydata() for line in axis.get_lines()])):
        axis.set_yscale("log")
    tick(axis.xaxis, draws[across].levels)
    axis.set_xlabel(label(plan, draws[across]))
    axis.set_ylabel(metric_label(plan, metric))
    axis.grid(True, alpha=0.3)
    if len(results) > 1 or failed:
        axis.legend(fontsize="small")
    return made


def maps(plan: Plan, results: list[Results], metric: str) -> Figure:
    """A metric over the first two variables that vary: a map for each variant and each value of the others."""
    draws = plan.draws[plan.laws[0]]
    shape = [len(d.levels) for d in draws]
    x, y, *others = sorted(range(len(draws)), key=lambda i: shape[i] == 1)
    fixed = product(*(range(shape[i]) for i in others))
    panels = list(islice(product(results, list(fixed)), MOST_PANELS))
    columns = min(3, len(panels)) if len(panels) != 4 else 2
    rows = -(-len(panels) // columns)
    made, axes = figure(0.8 + (4.6 if columns == 1 else 3.4) * rows, rows, columns, sharex=True, sharey=True)
    over = {r.law: (cells(r, metric, shape), cells(r, "success", shape)) for r in results}
    scale, beyond = colours(*(np.concatenate([part.ravel() for part in parts]) for parts in zip(*over.values())))
    for axis, (r, at) in zip(axes.flat, panels):
        chosen: list[Any] = [slice(None)] * len(draws)
        for i, level in zip(others, at):
            chosen[i] = level
        found, success = (part[tuple(chosen)].T for part in over[r.law])
        mesh = heat(axis, places(draws[x].levels), places(draws[y].levels), found, success, scale)
        tick(axis.xaxis, draws[x].levels)
        tick(axis.yaxis, draws[y].levels)
        titles = [r.law] if len(results) > 1 else []
        titles += [f"{draws[i].name} = {written(draws[i].levels[k])}" for i, k in zip(others, at) if shape[i] > 1]
        axis.set_title(without_math("\n".join(titles)), fontsize="small")
    for axis in axes.flat[len(panels):]:
        axis.set_visible(False)
    made.supxlabel(label(plan, draws[x]), fontsize="medium")
    made.supylabel(label(plan, draws[y]), fontsize="medium")
    made.colorbar(mesh, ax=axes, label=metric_label(plan, metric), extend=beyond)
    if any((success == 0).any() for _, success in over.values()):
        made.text(0.005, 0.005, "× no success", fontsize="small", ha="left", va="bottom")
    return made


def colours(values: np.ndarray, success: np.ndarray) -> tuple[Normalize, str]:
    """The scale of a map, from the successes' values where these differ, since failures can be far off; and at which
    end values lie beyond it."""
    every = values[np.isfinite(values)]
    inner = values[np.isfinite(values) & (success == 1)]
    shown = inner if len(inner) and np.ptp(inner) > 0 else every if len(every) else np.array([0.0, 1.0])
    low, high = float(shown.min()), float(shown.max())
    below, above = bool((every < low).any()), bool((every > high).any())
    beyond = "both" if below and above else "min" if below else "max" if above else "neither"
    return (LogNorm if wide(shown) else Normalize)(low, high), beyond


def heat(axis: Axes, x: np.ndarray, y: np.ndarray, values: np.ndarray, success: np.ndarray, scale: Normalize) -> Any:
    """A map of `values`, shape (y, x), as cells about the points; those without a success are crossed out, those
    without a value are grey."""
    axis.set_facecolor("#bbbbbb")
    columns, rows = np.argsort(x), np.argsort(y)
    x, y, values, success = x[columns], y[rows], values[np.ix_(rows, columns)], success[np.ix_(rows, columns)]
    mesh = axis.pcolormesh(borders(x), borders(y), np.ma.masked_invalid(values), norm=scale, cmap=MAP)
    few = values.size <= MOST_NUMBERS and len(x) <= 10
    for j, i in np.argwhere(np.isfinite(success)):
        bright = np.isfinite(values[j, i]) and scale(values[j, i]) > 0.5
        failed = success[j, i] == 0
        text = f"{values[j, i]:#.3g}".rstrip(".") if few and np.isfinite(values[j, i]) else ""
        axis.text(x[i], y[j], f"{text}\n×".strip() if failed else text, ha="center", va="center", fontsize=7,
                  color="k" if bright else "w")
    return mesh


def borders(points: np.ndarray) -> np.ndarray:
    """The borders of cells about ascending points, shape (points + 1,): half way between neighbours."""
    if len(points) == 1:
        return points[0] + np.array([-0.5, 0.5])
    middles = (points[1:] + points[:-1]) / 2
    return np.concatenate([[2 * points[0] - middles[0]], middles, [2 * points[-1] - middles[-1]]])


def table_rows(plan: Plan, found: Mapping[str, Mapping[str, Any]]) -> list[list[str]]:
    """Rows for a table: variant, metric, its least and its greatest value with where they are."""
    def text(name: str, one: Mapping[str, Any]) -> str:
        unit = plan.metrics[name].unit
        at = ", ".join(f"{variable} = {written(value)}" for variable, value in one["at"].items())
        return f"{one['value']:.4g}{f' {unit}' if unit else ''} at {at}"

    return [[law, name, text(name, both["least"]), text(name, both["greatest"])]
            for law, metrics in found.items() for name, both in metrics.items()]
