"""The report of a campaign that nobody flew: rows that are made up, with a stranger's text wherever one can be."""
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from cosim.campaign import report
from cosim.campaign.distributions import Choice, Uniform
from cosim.campaign.labels import Label
from cosim.campaign.sampling import Draw
from cosim.campaign.statistics import JUDGED, Results

LAWS = ("neural", "resilient")


def made_up(folder: Path, text: str = "x", runs: int = 40, laws: tuple[str, ...] = LAWS) -> SimpleNamespace:
    """The store of a campaign in `folder`: runs fail where a.x is above 0.75; the second law's always succeed."""
    folder.mkdir(parents=True, exist_ok=True)
    x = (np.arange(runs) * 0.382) % 1
    figure = SimpleNamespace(unit=text, headline="a figure")
    plan = SimpleNamespace(
        campaign=SimpleNamespace(
            name=text, runs=runs, seed=1, sampling="random", samples=None, dispersions={"a.x": 0}, correlations=[],
            metrics={text: "max(a.y)"}, success={f"{text} good": "m < 8"}, rare=None, stop_when=None, set={}),
        subject=SimpleNamespace(
            field="system", column="variant", noun="variant", name=text, remark=text, start=0.0, stop=10.0, step=0.1,
            drawn=("Signals over time", "Each signal"), sets={law: {} for law in laws},
            over_time={"error": (f"{text} error", "a.y")}, command=lambda law: ["ahv", "simulate", text],
            implied=lambda law, drawn: {}),
        laws=list(laws), constants={}, metrics={"m": figure, text: figure}, headlines=["m"], worst_by="m",
        draws=dict.fromkeys(laws, (
            Draw("a.x", ("a.x",), Uniform(distribution="uniform", low=0, high=1)),
            Draw("a.word", ("a.word",), Choice(distribution="choice", values=[text, "b b"])))),
        labels={"a.x": Label("a.x", text, f"{text} of x"), "a.word": Label("a.word", "", text),
                "a.y": Label("a.y", text, text)})
    rows = []
    for k in range(runs):
        for law in laws:
            good = law != laws[0] or x[k] < 0.75
            rows.append({"run": k, "variant": law, "seed": 1, "a.x": x[k] / 3, "a.word": (text, "b b")[k % 2],
                         "status": "finished" if good else "departed",
                         "message": "" if good else f"{text} at t = {k}.5 s",
                         "success": good, f"success.{text} good": good, "ticks": 100,
                         "departed_at_s": None if good else 0.5 + 9 * x[k], "m": 10 * x[k] + 1, text: float(k)})
    pq.write_table(pa.Table.from_pylist(rows), folder / "runs.parquet")
    time = np.linspace(0, 10, 101)
    pq.write_table(pa.table({
        "run": [r["run"] for r in rows], "variant": [r["variant"] for r in rows],
        "time": [time[:rows_of(r)] for r in rows],
        "error": [(np.sin(time + r["a.x"]) * r["m"])[:rows_of(r)].astype("f4") for r in rows]}),
        folder / "errors.parquet")
    kept = [r for r in rows if r["run"] < 6]
    pq.write_table(pa.table({
        "run": np.repeat([r["run"] for r in kept], 101), "variant": np.repeat([r["variant"] for r in kept], 101),
        "time": np.tile(time, len(kept)), "a.y": np.concatenate([np.cos(time * (1 + r["run"])) for r in kept])}),
        folder / "signals.parquet")
    return SimpleNamespace(plan=plan, folder=folder, file=lambda kind: folder / f"{kind}.parquet")


def rows_of(row: dict) -> int:
    """How many of the times a run reached."""
    return 101 if row["departed_at_s"] is None else int(row["departed_at_s"] * 10) + 1


def page_of(store: SimpleNamespace) -> str:
    """report.html."""
    runs, errors = pq.read_table(store.file("runs")), pq.read_table(store.file("errors"))
    plan, draws = store.plan, ["a.x", "a.word"]
    results = [Results.of(law, runs, "variant") for law in plan.laws]
    summary = {"judged": list(JUDGED), "interval": "none", "paired": {},
               "variants": {r.law: r.summary(draws, "m", plan.metrics, "variant") for r in results}}
    return report.html(store, summary, results, runs, errors, draws)
