"""Helpers that fly small campaigns in tests."""
from functools import partial

import yaml

from cosim.campaign import campaign as campaigns
from cosim.campaign import plan
from cosim.campaign.store import Store
from cosim.campaign.worker import JOBS, LOADED, LoadedSystems, fly_batch, keep
from cosim.vehicle.campaigns import Laws

campaign = partial(campaigns.campaign, subjects=[Laws])  # as `ahv campaign` flies a file
TABLES = ("runs.parquet", "signals.parquet", "errors.parquet")
FILE = {
    "name": "small", "scenario": "case1", "controllers": ["neural", "backstepping"], "stop": 10, "runs": 24, "seed": 3,
    "sampling": "sobol", "runs_per_task": 2,
    "dispersions": {
        "plant.mass": {"distribution": "normal", "mean": 300, "std": 10},
        "plant.CM_alpha": {"distribution": "uniform", "low": 0.5, "high": 1.5, "relative": True},
        "scenario.scale_lift": {"distribution": "sinusoid", "amplitude": 0.4, "period": 40}},
    "correlations": [{"draws": ["plant.mass", "plant.CM_alpha"], "coefficient": 0.5}],
    "success": {"altitude": "altitude_error_ft.max_abs < 20"}, "signals": {"share": 0.2, "failures": True},
}


def load(path):
    """The plan of a campaign file, as `ahv campaign` reads it."""
    return plan.load(path, Laws)


def written(folder, **changes):
    """A campaign file in `folder`."""
    folder.mkdir(exist_ok=True)
    (folder / "campaign.yaml").write_text(yaml.dump({**FILE, **changes}, sort_keys=False))
    return folder / "campaign.yaml"


def tables(out):
    """The bytes of the final tables."""
    return [(out / name).read_bytes() for name in TABLES]


def fly_here(store: Store, folder) -> None:
    """Fly what is missing in this process, without a cluster."""
    plan = store.plan
    JOBS[plan.job.key] = plan.job
    for stored, path in plan.fmus.items():
        keep(folder, stored, path.read_bytes())
    LOADED[:] = [LoadedSystems(plan.job, folder)]
    try:
        for first, last in store.missing():
            store.add(first, fly_batch(plan.job.key, first, last))
    finally:
        LOADED.pop().close()
