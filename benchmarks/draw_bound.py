"""Draws docs/pictures/bound.png from the rows of bound.py, with the laws flown on the same draws; prints their figures.

    .venv/bin/python benchmarks/draw_bound.py [--out DIR]

The laws fly as FMUs in campaigns of the same files (a few minutes, kept in DIR). A flight that ends early has no error.
"""
import argparse
import json
import sys
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import yaml
from bound import CASES, KNOWN, MODES, QUANTILES, ROOT, WITHIN, bounds
from matplotlib.figure import Figure

from cosim import pictures
from cosim.campaign.campaign import campaign
from cosim.campaign.statistics import interval
from cosim.vehicle.campaigns import Laws

PICTURE = ROOT / "docs" / "pictures" / "bound.png"
LAWS = [{"law": "resilient", "preset": "quiet", "name": "resilient, quiet"},
        {"law": "neural", "preset": "calibrated", "name": "neural, calibrated"},
        {"law": "neural", "preset": "independent", "name": "neural, retuned"},
        {"law": "backstepping", "preset": "independent", "name": "backstepping, retuned"}]
LABELS = {KNOWN: "bound, all known", "0.1": "bound, blind for 0.1 s", "0.3": "bound, blind for 0.3 s"}
BINS = (0.0, 1.0, 5.0, np.inf)  # ft: draws by their bound when blind for 0.1 s
LEAST, MOST = 0.01, 200.0      # ft, ends of the axis


def campaign_file(case: str) -> dict[str, Any]:
    """What docs/campaigns/CASE.yaml says."""
    return yaml.safe_load((ROOT / "docs" / "campaigns" / f"{case}.yaml").read_text())


def flown(case: str, runs: int, out: Path) -> dict[str, np.ndarray]:
    """Law -> the largest altitude error (ft) of runs 0 ... runs - 1; infinite where the flight ended early."""
    text = campaign_file(case)
    path, folder = out / f"laws-{case}-{runs}.yaml", out / f"laws-{case}-{runs}"
    changed = {**text, "controllers": LAWS, "runs": runs, "signals": {"share": 0.0}}
    path.write_text(yaml.safe_dump(changed, sort_keys=False))  # the order of the dispersions decides the draws
    campaign(path, folder, resume=True, workers=1, subjects=[Laws])
    rows = pq.read_table(folder / "runs.parquet").to_pylist()
    found = {law["name"]: np.full(runs, np.inf) for law in LAWS}
    for row in rows:
        if row["status"] == "finished":
            found[row["controller"]][row["run"]] = row["altitude_error_ft.max_abs"]
    return found


def curve(axis: Any, errors: np.ndarray, **options: Any) -> None:
    """The share of draws (%) whose error is at most that of the axis."""
    x = np.sort(np.maximum(errors, LEAST))
    share = 100 * np.arange(1, len(x) + 1) / len(x)
    shown = x <= MOST
    axis.step([LEAST, *x[shown], MOST], [0.0, *share[shown], 100 * shown.mean()], where="post", **options)


def number(x: float) -> float | None:
    """`x` as JSON can have it."""
    return float(x) if np.isfinite(x) else None


def line(errors: np.ndarray, least: dict[str, np.ndarray]) -> dict[str, Any]:
    """What the errors (ft) of a law say beside the bounds of the same draws."""
    within = int((errors < WITHIN).sum())
    bins = {}
    for low, high in pairwise(BINS):
        chosen = (least["0.1"] >= low) & (least["0.1"] < high)
        if chosen.any():
            bins[f"{low:g} to {high:g} ft"] = {
                "draws": int(chosen.sum()), "bound_median_ft": float(np.median(least["0.1"][chosen])),
                "median_ft": number(np.median(errors[chosen])), "max_ft": number(errors[chosen].max()),
                **{f"share_above_{mode}": float((errors > least[mode])[chosen].mean()) for mode in MODES}}
    return {"draws": len(errors), "within_20_ft": within / len(errors), "interval": interval(within, len(errors)),
            "finished": float(np.isfinite(errors).mean()),
            **{f"{name}_ft": number(np.quantile(errors, q, method="higher")) for name, q in QUANTILES.items()},
            "by_bound_when_blind_for_0.1_s": bins}


def draw(axis: Any, case: str, out: Path, draws: int | None) -> dict[str, Any]:
    """The bounds and the laws of a case, on the first `draws` of it; what the laws' errors say."""
    path = out / f"{case}-seed{campaign_file(case)['seed']}.csv"
    found = {mode: bounds(path, mode, draws and range(draws)) for mode in MODES}
    runs = sorted(set.intersection(*(set(errors) for errors in found.values())))
    laws = {name: errors[runs] for name, errors in flown(case, runs[-1] + 1, out).items()}
    least = {mode: np.array([errors[run] for run in runs]) for mode, errors in found.items()}
    for (mode, label), shade in zip(LABELS.items(), ("0.75", "0.5", "0.2")):
        curve(axis, least[mode], color=shade, linestyle="--", label=label)
    marks = zip(laws.items(), pictures.COLOURS, pictures.MARKS)
    for place, ((name, errors), hue, mark) in enumerate(marks):
        curve(axis, errors, label=name, color=hue, linestyle="-", marker=mark, markevery=(0.05 + 0.02 * place, 0.15))
    axis.axvline(WITHIN, color="k", lw=0.8, linestyle=":")
    axis.text(1.1 * WITHIN, 1.0, f"{WITHIN:g} ft", fontsize=7)
    axis.set(xscale="log", xlim=(LEAST, MOST), title=f"Case {case[-1]}, {len(runs)} draws",
             xlabel="largest altitude error of a flight (ft)")
    axis.xaxis.set_major_formatter(pictures.number)
    return {name: line(errors, least) for name, errors in laws.items()}


def main() -> int:
    """The command line; its exit status."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("results/bound"), metavar="DIR", help="that of bound.py")
    parser.add_argument("--draws", type=int, help="the first so many, where there are more")
    given = parser.parse_args()
    said: dict[str, Any] = {}
    with pictures.style():
        figure = Figure(figsize=(pictures.WIDTHS[2], 3.6), layout="constrained")
        axes = figure.subplots(1, 2, sharey=True)
        for axis, case in zip(axes, CASES):
            said[case] = draw(axis, case, given.out, given.draws)
        axes[0].set_ylabel("share of draws with at most that error (%)")
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
        pictures.save(figure, PICTURE)
    print(json.dumps(said, indent=2))
    return 0


if __name__ == "__main__":
    sys.exit(main())
