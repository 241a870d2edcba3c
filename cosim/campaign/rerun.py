"""The command line that repeats one run of a campaign by itself."""
import shlex
from typing import Any

from .plan import Plan


def command(plan: Plan, row: dict[str, Any]) -> str:
    """The `ahv run` command of `row`, one of runs.parquet, with numbers in full: it gives the same bits."""
    campaign = plan.campaign
    law = next(law for law in campaign.controllers if law.name == row["controller"])
    presets = {"controller": law.preset, **campaign.presets}
    drawn = {target: row[d.name] for d in plan.draws[law.name] for target in d.targets}
    values = {**campaign.set, **law.set, **plan.constants, **drawn}
    words = ["ahv", "run", plan.scenario_word, "--controller", law.law,
             "--preset", ",".join(f"{component}={name}" for component, name in presets.items()),
             "--flavour", campaign.flavour, "--plant", campaign.plant, "--step", repr(campaign.step),
             "--stop", repr(plan.stop), "--algorithm", campaign.algorithm]
    for name, value in values.items():
        words += ["--set", f"{name}={value!r}" if isinstance(value, float) else f"{name}={value}"]
    return shlex.join(words)
