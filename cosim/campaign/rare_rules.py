"""What a campaign of rare failures asks of its file; checked before anything flies."""
from collections.abc import Mapping
from importlib.metadata import version as installed

import numpy as np

from ..errors import UsageError, did_you_mean
from ..yaml_file import Source
from . import margin
from .rare import block, library
from .sampling import Draw
from .spec import Campaign, Rare

TASKS = 8     # of a block at least: the next block waits for all of them
TRIED = 200   # probabilities at which a continuous distribution has values that all differ


def check_rare(source: Source, campaign: Campaign, draws: Mapping[str, tuple[Draw, ...]]) -> None:
    """Raises UsageError, with line and field, for what does not fit a campaign of rare failures; without OpenTURNS."""
    if (rare := campaign.rare) is None:
        return
    with source.at("rare"):
        library()
        if len(draws) > 1:
            raise UsageError(f"it flies one system at a time, not {', '.join(draws)}: write a file for each")
    if rare.failure not in (None, *campaign.success):
        source.fail(("rare", "failure"), f"there is no {rare.failure} in success"
                    f"{did_you_mean(str(rare.failure), campaign.success).rstrip('.')}")
    if campaign.sampling != "random":
        source.fail(("sampling",), f"rare chooses its own points: {campaign.sampling} does not belong here")
    if campaign.stop_when:
        source.fail(("stop_when",), "rare ends by itself: stop_when does not belong here")
    if campaign.runs != rare.most_runs:
        source.fail(("runs",), f"rare flies {rare.runs_per_level:,} runs_per_level and {rare.most_levels} most_levels: "
                    "leave runs out")
    for name in towards(campaign):
        with source.at("success", name):
            margin.check(campaign.success[name])
    for draw in next(iter(draws.values())):
        if not continuous(draw):
            source.fail(("dispersions",), f"rare needs continuous distributions, and {draw.name} has steps")


def continuous(draw: Draw) -> bool:
    """Whether a draw has no steps."""
    values = [draw.value(float(u)) for u in np.linspace(0.01, 0.99, TRIED)]
    return len({*values}) == TRIED and all(isinstance(x, float) for x in values)


def towards(campaign: Campaign) -> tuple[str, ...]:
    """The criteria of which the margin is wanted."""
    if campaign.rare is None:
        return ()
    return (campaign.rare.failure,) if campaign.rare.failure else tuple(campaign.success)


def version() -> str:
    """OpenTURNS's, which decides on the points."""
    return installed("openturns")


def whole_tasks(rare: Rare, wanted: int) -> int:
    """Runs of one task: about `wanted`, so that tasks fill a block exactly and workers share it."""
    size = block(rare)
    most = max(1, min(wanted, size // TASKS))
    return next(n for n in range(most, 0, -1) if size % n == 0)
