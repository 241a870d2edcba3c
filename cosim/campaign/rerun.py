"""The command line that repeats one run of a campaign by itself."""
import shlex
from pathlib import Path
from typing import Any

from .plan import Plan


def command(plan: Plan, row: dict[str, Any]) -> str:
    """The command of `row`, one of runs.parquet, with numbers in full: it gives the same bits, in a folder of its
    own."""
    campaign, subject = plan.campaign, plan.subject
    variant = row[subject.column]
    drawn = {target: row[d.name] for d in plan.draws[variant] for target in d.targets}
    values = {**subject.implied(variant, drawn), **campaign.set, **subject.sets[variant], **plan.constants, **drawn}
    words = subject.command(variant)
    for name, value in values.items():
        words += ["--set", f"{name}={value!r}" if isinstance(value, float) else f"{name}={value}"]
    words += ["--out", str(Path("results") / "run" / f"{campaign.name}-{variant}-{row['run']}")]
    return shlex.join(words)
