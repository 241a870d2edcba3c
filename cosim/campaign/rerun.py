"""The command line that repeats one run of a campaign by itself."""
import shlex
from pathlib import Path
from typing import Any

from ..vehicle.closed_loop import FOLLOWS, absolute
from .plan import Plan


def command(plan: Plan, row: dict[str, Any]) -> str:
    """The `ahv run` command of `row`, one of runs.parquet, with numbers in full: it gives the same bits, in a folder of
    its own."""
    campaign, folder = plan.campaign, plan.path.parent
    law = next(law for law in campaign.controllers if law.name == row["controller"])
    drawn = {target: row[d.name] for d in plan.draws[law.name] for target in d.targets}
    values = {**commanded(plan, law.name), **campaign.set, **law.set, **plan.constants, **drawn}
    words = ["ahv", "run", plan.scenario_word, "--controller", absolute(law.law, folder),
             "--preset", ",".join(f"{component}={name}" for component, name in plan.loops[law.name].presets.items()),
             "--flavour", campaign.flavour, "--plant", absolute(campaign.plant, folder), "--step", repr(campaign.step),
             "--stop", repr(plan.stop), "--algorithm", campaign.algorithm]
    for name, value in values.items():
        words += ["--set", f"{name}={value!r}" if isinstance(value, float) else f"{name}={value}"]
    words += ["--out", str(Path("results") / "run" / f"{campaign.name}-{law.name}-{row['run']}")]
    return shlex.join(words)


def commanded(plan: Plan, law: str) -> dict[str, Any]:
    """The commands of the campaign where a start is drawn: on the command line they would follow that start."""
    targets = {target for d in plan.draws[law] for target in d.targets}
    scenario = plan.loops[law].system.components[0]
    return {f"scenario.{command}": scenario.values[command] for command, start in FOLLOWS.items()
            if f"plant.{start}" in targets}
