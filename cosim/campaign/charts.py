"""The report's pictures."""
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from textwrap import fill
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import NullFormatter

from ..pictures import BLUE, RED, colour, styled
from ..text import without_math
from .labels import Label, on_axes
from .plan import Plan
from .statistics import EXPLAINED, Results
from .subject import Figure as Metric

WIDTH = 9.0
POINTS = 2000      # of a scatter plot
MOST_PANELS = 24
WRAP = 44          # characters of a line of a label
FAILURE, SUCCESS = RED, BLUE


def figure(height: float, rows: int = 1, columns: int = 1, **options: Any) -> tuple[Figure, np.ndarray]:
    """A figure of WIDTH by `height` inches with its axes, shape (rows, columns)."""
    made = Figure(figsize=(WIDTH, height), layout="constrained")
    FigureCanvasAgg(made)
    return made, made.subplots(rows, columns, squeeze=False, **options)


def wide(values: np.ndarray) -> bool:
    """Whether positive values want a logarithmic axis."""
    values = values[np.isfinite(values)]
    return bool(len(values) and values.min() > 0 and values.max() > 50 * np.quantile(values, 0.1))


def probability(results: list[Results]) -> Figure:
    """Each law's probability of success with its interval."""
    made, axes = figure(0.8 + 0.5 * len(results))
    axis = axes[0, 0]
    for i, r in enumerate(results):
        p, (low, high) = r.probability or 0.0, r.interval
        axis.errorbar(p, i, xerr=[[max(0.0, p - low)], [max(0.0, high - p)]], fmt="o", color=colour(i), capsize=5,
                      clip_on=False)
    axis.set_yticks(range(len(results)), [r.law for r in results])
    axis.set_ylim(len(results) - 0.5, -0.5)
    axis.set_xlim(0, 1)
    axis.set_xlabel("success, share of the judged runs, with 95 % interval")
    axis.grid(True, axis="x", alpha=0.3)
    return made


def envelopes(results: list[Results], errors: pa.Table, labels: Mapping[str, str], start: float, stop: float
              ) -> Figure:
    """Quantiles over the runs that still fly, at each time (s) from `start` to `stop`, of the columns of `labels`,
    which are what is on the axis; below, how many runs that are."""
    made, axes = figure(3.5 + 2.5 * len(labels), len(labels) + 1, len(results), sharex=True, sharey="row")
    for column, r in enumerate(results):
        mine = errors.filter(pa.compute.equal(errors[r.column], r.law))
        time, by_name = over_time(mine, labels)
        for row, (name, label) in enumerate(labels.items()):
            axis, lines = axes[row, column], by_name[name]
            if len(lines):
                levels = np.nanquantile(lines, [0.0, 0.05, 0.5, 0.95, 1.0], axis=0)
                axis.fill_between(time, levels[0], levels[4], color=colour(column), alpha=0.15, label="all")
                axis.fill_between(time, levels[1], levels[3], color=colour(column), alpha=0.35, label="5 to 95 %")
                axis.plot(time, levels[2], color=colour(column), label="median")
                small = float(np.nanmedian(np.abs(lines))) or 1e-6
                if np.nanmax(np.abs(lines)) > 50 * small:
                    axis.set_yscale("symlog", linthresh=10.0**np.ceil(np.log10(5 * small)))
            axis.set_title(r.law if row == 0 else "")
            axis.set_ylabel(label if column == 0 else "")
            axis.grid(True, alpha=0.3)
        flying = 100 * np.isfinite(lines).mean(axis=0)
        if len(time) and time[-1] < stop * (1 - 1e-9):
            time, flying = np.append(time, [time[-1], stop]), np.append(flying, [0.0, 0.0])
        axes[-1, column].plot(time, flying, color=colour(column))
        axes[-1, column].set_xlim(start, stop)
        axes[-1, column].set_ylim(-3, 103)
        axes[-1, column].set_xlabel("time (s)")
        axes[-1, column].grid(True, alpha=0.3)
    axes[0, 0].legend(fontsize="small")
    axes[-1, 0].set_ylabel("still flying (%)")
    return made


def over_time(errors: pa.Table, names: Iterable[str]) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Time (s), shape (times,), of the run that flew the longest; name -> errors, shape (runs, times), NaN where a run
    had ended."""
    time = max((np.asarray(x, float) for x in errors["time"].to_pylist()), key=len, default=np.empty(0))
    found = {name: np.full((errors.num_rows, len(time)), np.nan) for name in names}
    for name, lines in found.items():
        for line, values in zip(lines, errors[name].to_pylist()):
            line[:len(values)] = values
    return time, found


def histograms(results: list[Results], metrics: Mapping[str, Metric]) -> Figure:
    """How often each value of the metrics occurs."""
    rows = -(-len(metrics) // 2)
    made, axes = figure(3.0 * rows, rows, 2)
    for axis in axes.flat[len(metrics):]:
        axis.set_visible(False)
    for axis, (name, metric) in zip(axes.flat, metrics.items()):
        columns = [r.columns[name][np.isfinite(r.columns[name])] for r in results]
        together = np.concatenate(columns)
        log = wide(together)
        if len(together):
            low, high = float(together.min()), float(together.max())
            if low == high:
                low, high = low - 0.05 * (abs(low) or 1), high + 0.05 * (abs(low) or 1)
            bins = np.geomspace(low, high, 50) if log else np.linspace(low, high, 50)
            for r, values, line in zip(results, columns, styled(len(results))):
                axis.stairs(np.histogram(values, bins)[0], bins, label=r.law, **line)
        if log:
            axis.set_xscale("log")
        endless = sum(int(np.isinf(r.columns[name]).sum()) for r in results)
        axis.set_xlabel((f"{name} ({metric.unit})" if metric.unit else name)
                        + (f"; not shown: {endless:,} infinite" if endless else ""))
        axis.set_ylabel("runs")
        axis.grid(True, alpha=0.3)
    lines = [Line2D([], [], **line) for line in styled(len(results))]
    made.legend(lines, [r.law for r in results], loc="outside upper center", ncols=4, fontsize="small")
    return made


def drivers(results: list[Results], draws: list[str], metric: str | None, labels: Mapping[str, Label]) -> Figure:
    """What failure and the metric go with: rank correlations with each draw, and what it explains of failure."""
    found = [r.drivers(draws, metric) for r in results]
    names = list(found[0])[:MOST_PANELS]
    with_metric = {metric: f"rank correlation with\n{metric}"} if metric else {}
    shown = {"failure": "rank correlation\nwith failure", **with_metric,
             EXPLAINED: "share of failure's variance\nexplained by it alone"}
    made, axes = figure(1.4 + 0.32 * len(names) * max(1, len(results) / 2), 1, len(shown), sharey=True)
    for axis, (what, title) in zip(axes[0], shown.items()):
        for i, (r, by_draw) in enumerate(zip(results, found)):
            at = np.arange(len(names)) + (i - (len(results) - 1) / 2) * 0.8 / len(results)
            axis.barh(at, [by_draw[n][what] for n in names], 0.8 / len(results), color=colour(i), label=r.law)
        axis.set_xlim(0 if what == EXPLAINED else -1, 1)
        axis.set_xticks([0, 0.5, 1] if what == EXPLAINED else [-1, -0.5, 0, 0.5, 1])
        axis.set_title(title, fontsize="small")
        axis.set_xlabel("(1)", fontsize="small")
        axis.tick_params(labelsize="small")
        axis.grid(True, alpha=0.3)
    words = on_axes(names, labels)
    axes[0, 0].set_yticks(range(len(names)), [fill(without_math(words[n]), WRAP) for n in names], fontsize="small")
    axes[0, 0].invert_yaxis()
    if len(results) > 1:
        made.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=4, fontsize="small")
    return made


def scatter(r: Results, draws: list[str], metric: str, labels: Mapping[str, Label], unit: str = "") -> Figure:
    """`metric` against each draw that is a number, failures apart."""
    by_draw = r.drivers(draws, metric)
    names = [name for name in by_draw if name in r.columns][:MOST_PANELS // 2]
    rows = max(1, -(-len(names) // 3))
    made, axes = figure(0.8 + 2.3 * rows, rows, 3, sharey=True)
    chosen, words = slice(None, POINTS), on_axes(names, labels)
    y, success = r.columns[metric][chosen], r.columns["success"][chosen].astype(bool)
    for axis, name in zip(axes.flat, names):
        x = r.columns[name][chosen]
        axis.plot(x[~success], y[~success], "x", ms=3, alpha=0.5, color=FAILURE, label="failure")
        axis.plot(x[success], y[success], ".", ms=3, alpha=0.5, color=SUCCESS, label="success")
        axis.set_xlabel(fill(without_math(words[name]), WRAP), fontsize="small")
        axis.set_title(f"rank correlation with failure: {by_draw[name]['failure']:.2f}".replace("-", "\N{MINUS SIGN}"),
                       fontsize="small")
        axis.tick_params(labelsize="small")
        axis.grid(True, alpha=0.3)
        if wide(y):
            axis.set_yscale("log")
            axis.yaxis.set_minor_formatter(NullFormatter())  # it would write none
    for axis in axes.flat[len(names):]:
        axis.set_visible(False)
    made.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=2, fontsize="small",
                markerscale=3)
    for axis in axes[:, 0]:
        axis.set_ylabel(f"{metric} ({unit})" if unit else metric, fontsize="small")
    return made


def axes_over_time(plan: Plan) -> dict[str, str]:
    """What is drawn over time: name -> what is on its axis."""
    return {name: on_axes([name], plan.labels)[name] if name == label else label
            for name, (label, _) in plan.subject.over_time.items()}


def every(plan: Plan, results: list[Results], errors: pa.Table, draws: list[str]) -> dict[str, Callable[[], Figure]]:
    """File name -> how to draw it."""
    subject, metric = plan.subject, plan.worst_by
    made: dict[str, Callable[[], Figure]] = {"probability": lambda: probability(results)}
    if plan.headlines:
        made["histograms"] = lambda: histograms(results, {name: plan.metrics[name] for name in plan.headlines})
    if errors.num_rows:
        labels = {name: without_math(label) for name, label in axes_over_time(plan).items()}
        made["envelopes"] = lambda: envelopes(results, errors, labels, subject.start, subject.stop)
    if results[0].drivers(draws, metric):
        made["drivers"] = lambda: drivers(results, draws, metric, plan.labels)
        if metric is not None:
            made |= {f"scatter_{r.law}": partial(scatter, r, draws, metric, plan.labels, plan.metrics[metric].unit)
                     for r in results}
    return made
