"""The tables of docs/laws/retuned.md: the laws retuned, behind the protection, and the network inside `resilient`.

    .venv/bin/python benchmarks/retuned_table.py [ROW | ROW:LAW]...     (all; ten minutes on one free core)

A row is a campaign of docs/campaigns with a seed that no tuning has seen. Its flights are those of `ahv campaign`, one
after the other in this process. They are kept in results/retuned/ROW_LAW.json; what is there is only printed. Intervals
are Clopper and Pearson's, 95 %.
"""
import json
import shutil
import sys
import tempfile
from pathlib import Path

import numpy as np
import yaml
from law_table import CAMPAIGNS, DEPARTED, share
from network_laws import IN_THEIR_PLACE
from network_laws import MODEL as NETWORK
from protected_laws import MODELS, OUT

from cosim.campaign import plan
from cosim.campaign.worker import LoadedSystems, requests
from cosim.vehicle.campaigns import Laws
from fmus.builder import build

RESULTS = Path("results") / "retuned"
NO_LIMIT = {"protect_k_barrier": 1e4}  # what is left: the thrust pitches where the elevator's stop does not
LAMBDAS = (0, 10, 1e3, 1e4, 1e5)
KEPT = ("altitude_error_ft.max_abs", "velocity_error_fps.max_abs", "elevator_deg.travel")


def law(word: str, preset: str, **values: float) -> dict[str, object]:
    """A controller as a campaign file has it; a capital begins the name of an experimental FMU."""
    file = (OUT / "native" / f"{word}.fmu").resolve()
    return {"law": f"law={file}" if word[0].isupper() else word, "name": "law", "preset": preset,
            "set": {f"controller.{key}": float(value) for key, value in values.items()}}


RETUNED = {
    "neural": law("neural", "calibrated"),
    "neural_robust": law("neural", "robust"),
    "neural_retuned": law("neural", "independent"),
    "neural_retuned_no_network": law("neural", "independent", lambda_1=0, lambda_2=0),
    "neural_protected": law("ProtectedNeural", "start"),
    "neural_retuned_protected": law("ProtectedNeural", "independent"),
    "neural_tuned_together": law("ProtectedNeural", "tuned"),
    "neural_retuned_thrust_only": law("ProtectedNeural", "independent", **NO_LIMIT),
    "rival": law("backstepping", "calibrated"),
    "rival_retuned": law("backstepping", "independent"),
    "rival_protected": law("ProtectedBackstepping", "start"),
    "rival_retuned_protected": law("ProtectedBackstepping", "independent"),
    "rival_tuned_together": law("ProtectedBackstepping", "tuned"),
    "rival_retuned_thrust_only": law("ProtectedBackstepping", "independent", **NO_LIMIT),
    "resilient": law("resilient", "quiet"),
}
NETWORKS = {f"{name}_{value:g}": law("ResilientNetwork", "quiet", lambda_2=value, **gains)
            for name, gains in (("beside", {}), ("in_place", IN_THEIR_PLACE)) for value in LAMBDAS}
# Row -> the campaign's file, its laws, runs and seed.
ROWS = {"case1": ("case1", RETUNED, 500, 4713), "case2": ("case2", RETUNED, 500, 4714),
        "network": ("case1", NETWORKS, 300, 4715)}


def flown(row: str, name: str) -> dict[str, np.ndarray]:
    """The flights of one law: whether each reached the end, and KEPT."""
    kept = RESULTS / f"{row}_{name}.json"
    if not kept.is_file():
        kept.parent.mkdir(parents=True, exist_ok=True)
        file, laws, runs, seed = ROWS[row]
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "campaign.yaml"
            path.write_text(yaml.safe_dump({**yaml.safe_load((CAMPAIGNS / f"{file}.yaml").read_text()),
                                            "controllers": [laws[name]], "runs": runs, "seed": seed}))
            made = plan.load(path, Laws)
            for stored, fmu in made.fmus.items():
                (Path(folder) / stored).parent.mkdir(exist_ok=True)
                shutil.copy(fmu, Path(folder) / stored)
            loaded = LoadedSystems(made.job, Path(folder))
            outcomes = [loaded.fly(request) for request in requests(made.job, 0, runs)]
            loaded.close()
        kept.write_text(json.dumps({"finished": [one.status == "finished" for one in outcomes],
                                    **{key: [one.metrics[key] for one in outcomes] for key in KEPT}}))
    return {key: np.array(values) for key, values in json.loads(kept.read_text()).items()}


def show(row: str, name: str) -> None:
    """A line for a law: errors of all flights, speed and travel of those that were kept."""
    found = flown(row, name)
    h = found[KEPT[0]]
    kept = found["finished"] & (h < DEPARTED)
    V, travel = (found[key][kept] for key in KEPT[1:])
    print(f"{row:8} {name:25} {len(h):4} within {share(kept & (h < 20))}  kept {share(kept)}  "
          f"h median, 99 %, of all {np.median(h):8.2f} {np.quantile(h, 0.99):8.2f}, of those kept "
          f"{np.median(h[kept]):6.2f} {np.quantile(h[kept], 0.99):6.2f}  V {np.median(V):6.2f} "
          f"{np.quantile(V, 0.99):6.1f}  travel {np.median(travel):5.0f} {np.quantile(travel, 0.99):5.0f}", flush=True)


if __name__ == "__main__":
    if not all((OUT / "native" / f"{model.NAME}.fmu").is_file() for model in (*MODELS.values(), NETWORK)):
        for model in (*MODELS.values(), NETWORK):
            build(model, "native", OUT)
    for word in sys.argv[1:] or ROWS:
        row, _, only = word.partition(":")
        for name in [only] if only else ROWS[row][1]:
            show(row, name)
