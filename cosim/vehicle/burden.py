"""What a step of a control law costs, beside others: timed by turns in short rounds, with the spread."""
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack
from multiprocessing import get_context
from typing import Any

import numpy as np

from ..errors import RunError
from ..master.algorithms import method
from ..master.fly import fly_loaded
from ..master.guard import POSSIBLE
from ..master.loaded import Master, open_files
from ..master.system import System

ROUNDS, ROUND_S = 40, 1e-3
WARM_UP, MOST_STEPS = (10, 100, 100, 100, 100), 5000  # steps
COST, SPREAD = "cost_per_step_us", "cost_per_step_spread_us"


def by_turns(laws: list[System], step: float) -> np.ndarray:
    """Microseconds of a step of `step` seconds of each system, inputs held; shape (ROUNDS, laws).

    A round is a flight of about ROUND_S for each; how many steps that are is found out before. Raises RunError if an
    FMU cannot be started.
    """
    with ExitStack() as stack:
        masters = []
        for law in laws:
            masters.append(Master(law, stack.enter_context(open_files(law)), ["controller.elevator"]))
            stack.callback(masters[-1].close)

        def took(k: int, steps: int) -> float:
            flight = fly_loaded(masters[k], method("gauss-seidel"), step, steps)
            flight.check_interrupted()
            masters[k].reset(laws[k])
            return flight.wall_s / max(flight.ticks, 1)

        counts = [int(np.clip(ROUND_S / min(took(k, steps) for steps in WARM_UP), 1, MOST_STEPS))
                  for k in range(len(laws))]
        return np.array([[1e6 * took(k, count) for k, count in enumerate(counts)] for _ in range(ROUNDS)])


def costs(laws: list[System], step: float) -> list[dict[str, Any]]:
    """What `by_turns` finds, in a process of its own where that is possible: for each system the median, and the
    quartiles as its spread. Raises RunError if an FMU ends that process."""
    if not POSSIBLE:
        found = by_turns(laws, step)
    else:
        with ProcessPoolExecutor(1, get_context("fork")) as pool:
            try:
                found = pool.submit(by_turns, laws, step).result()
            except BrokenProcessPool:
                raise RunError("The cost of a step could not be measured: an FMU ended the process.") from None
    return [{COST: float(middle), SPREAD: {"from": float(low), "to": float(high)}}
            for low, middle, high in np.quantile(found, [0.25, 0.5, 0.75], axis=0).T]


def alike(rows: dict[str, dict[str, Any]]) -> list[str]:
    """The laws of the smallest cost: the one with the smallest median, and those whose spread overlaps its own."""
    least = min(rows.values(), key=lambda row: row[COST])
    return [law for law, row in rows.items() if row[SPREAD]["from"] <= least[SPREAD]["to"]]
