"""The command line that repeats one run of a campaign by itself."""
import shlex
from pathlib import Path
from typing import Any

from .plan import Plan


def command(plan: Plan, row: dict[str, Any]) -> str:
    """The command of `row`, one of runs.parquet, with numbers in full: it gives the same bits, in a folder of its
    own."""
    return shlex.join(word if isinstance(word, str) else f"{word[0]}{written(row[word[1]])}"
                      for word in words(plan, row[plan.subject.column]))


def words(plan: Plan, variant: str) -> list[str | tuple[str, str]]:
    """The words of a variant's commands; of one that differs from run to run its beginning, and the column of
    runs.parquet that has the rest."""
    campaign, subject = plan.campaign, plan.subject
    drawn = {target: d.name for d in plan.draws[variant] for target in d.targets}
    fixed = {**subject.implied(variant, drawn), **campaign.set, **subject.sets[variant], **plan.constants}
    found: list[str | tuple[str, str]] = [*subject.command(variant)]
    for name in (*fixed, *(target for target in drawn if target not in fixed)):
        found += ["--set", (f"{name}=", drawn[name]) if name in drawn else f"{name}={written(fixed[name])}"]
    return [*found, "--out", (str(Path("results") / "run" / f"{campaign.name}-{variant}-"), "run")]


def written(value: Any) -> str:
    """A value as the command line takes it, with all its digits."""
    return repr(value) if isinstance(value, float) else str(value)
