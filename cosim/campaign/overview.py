"""What the report's page draws of all runs: probabilities, histograms, envelopes, drivers, and maps of a grid."""
from collections.abc import Sequence
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute

from ..pages.decimate import text
from .charts import axes_over_time, over_time, wide
from .grid import cells, shown_metrics
from .labels import Label
from .plan import Plan
from .statistics import Results

BINS = 40
LEVELS = (0.0, 0.05, 0.5, 0.95, 1.0)


def overview(plan: Plan, results: Sequence[Results], errors: pa.Table) -> dict[str, Any]:
    """What the page's scripts draw of all runs."""
    swept = plan.campaign.sampling == "grid"
    return {"probability": [] if swept else [
                {"p": r.probability, "interval": r.interval, "successes": r.successes, "judged": r.judged}
                for r in results],
            "histograms": [histogram(results, name, plan.metrics[name].unit)
                           for name in plan.headlines if not swept],
            "envelopes": envelopes(plan, results, errors) if errors.num_rows and not swept else None,
            "sweep": sweep(plan, results) if swept else None}


def histogram(results: Sequence[Results], name: str, unit: str) -> dict[str, Any]:
    """How many judged runs of each variant lie between `edges`, which are as the axis is: logarithmic or not."""
    values = [r.columns[name][np.isfinite(r.columns[name])] for r in results]
    every = np.concatenate(values) if values else np.empty(0)
    log = wide(every)
    low, high = (float(every.min()), float(every.max())) if len(every) else (0.0, 1.0)
    if low == high:
        low, high = low - (abs(low) or 1.0) / 2, high + (abs(high) or 1.0) / 2
    edges = np.geomspace(low, high, BINS + 1) if log else np.linspace(low, high, BINS + 1)
    edges[[0, -1]] = low, high
    return {"name": name, "unit": unit, "log": log, "edges": edges.tolist(),
            "counts": [np.histogram(one, edges)[0].tolist() for one in values],
            "endless": sum(int(np.isinf(r.columns[name]).sum()) for r in results)}


def envelopes(plan: Plan, results: Sequence[Results], errors: pa.Table) -> dict[str, Any]:
    """Quantiles over the runs that still fly at each time, and the share of them in per cent."""
    labels, variants, every = axes_over_time(plan), [], {name: [np.empty(0)] for name in axes_over_time(plan)}
    for r in results:
        mine = errors.filter(pa.compute.equal(errors[r.column], r.law))
        time, by_name = over_time(mine, labels)
        bands, flying = {}, np.zeros(len(time))
        for name, lines in by_name.items():
            every[name].append(np.abs(lines[np.isfinite(lines)]))
            if lines.size:
                bands[name] = [text(row) for row in np.nanquantile(lines, LEVELS, axis=0)]
                flying = 100 * np.isfinite(lines).mean(axis=0)
        variants.append({"times": text(time), "bands": bands, "flying": text(flying), "runs": mine.num_rows})
    return {"start": plan.subject.start, "stop": plan.subject.stop,
            "panels": [{"name": name, "label": label, "bend": bend(np.concatenate(every[name]))}
                       for name, label in labels.items()], "variants": variants}


def is_number(level: object) -> bool:
    """Whether a level has a place of its own on an axis."""
    return isinstance(level, int | float) and not isinstance(level, bool)


def bend(sizes: np.ndarray) -> float:
    """Up to which size an axis is even, that is logarithmic beyond; 0 where it is even as a whole."""
    small = float(np.median(sizes)) if len(sizes) else 0.0
    small = small or 1e-6
    return float(10.0 ** np.ceil(np.log10(5 * small))) if len(sizes) and sizes.max() > 50 * small else 0.0


def sweep(plan: Plan, results: Sequence[Results]) -> dict[str, Any]:
    """Each metric over the grid; values and successes (-1: not judged) are in the order of the runs."""
    draws = plan.draws[plan.laws[0]]
    shape = [len(d.levels) for d in draws]
    metrics = []
    for name in shown_metrics(plan):
        found = [cells(r, name, shape).ravel() for r in results]
        good = np.concatenate([values[cells(r, "success", shape).ravel() == 1] for values, r in zip(found, results)])
        metrics.append({"name": name, "unit": plan.metrics[name].unit, "values": [text(values) for values in found],
                        "log": wide(good if len(good) else np.concatenate(found))})
    return {"axes": [{"name": d.name, "unit": plan.labels.get(d.name, Label(d.name)).unit,
                      "levels": [x if is_number(x) else str(x) for x in d.levels]} for d in draws],
            "success": [text(np.nan_to_num(cells(r, "success", shape).ravel(), nan=-1.0), "i1") for r in results],
            "metrics": metrics}
