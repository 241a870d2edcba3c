"""Measured flights flown with trial values: here, or in processes of their own, which may crash and hang."""
import faulthandler
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass, field
from multiprocessing import get_context

import numpy as np

from ..errors import RunError
from ..master.algorithms import method
from ..master.flight import Flight
from ..master.fly import fly_loaded
from ..master.kept import KeptSystems
from ..master.loaded import Master
from ..master.system import System
from ..master.table import Table
from ..processes import as_worker

LONGEST_S = 1e6
ENDLESS = 1e100  # a value that counts as infinite: the square of what is less is a number
Trial = tuple[int, dict[str, float]]  # the flight's place, and component.variable -> value


@dataclass(frozen=True)
class Plan:
    """One flight to repeat: `ticks` steps of `system`, and what is compared: the signals' names with the times (s) at
    which each is wanted, shape (its rows,)."""
    system: System
    ticks: int
    wanted: dict[str, np.ndarray]
    inputs: Table | None


@dataclass(frozen=True)
class Plans:
    """All flights. Times in s; a flight that takes longer than `time_limit` ends its process."""
    flights: list[Plan]
    algorithm: str
    step: float
    start: float
    tolerance: float | None = None
    time_limit: float | None = None


@dataclass(frozen=True)
class Shown:
    """What a flight showed, the signals one after the other; NaN where it did not come to. `message` says why it ended
    early; empty if it did not."""
    values: np.ndarray
    message: str = ""


def nothing(plan: Plan, message: str) -> Shown:
    """What a flight shows that did not begin."""
    return Shown(np.full(sum(map(len, plan.wanted.values())), np.nan), message)


class Bench:
    """The flights' systems, loaded when first flown and then reset. Flights without inputs from a table share one."""

    def __init__(self, plans: Plans):
        self.plans = plans
        self.kept = KeptSystems()
        self.method = method(plans.algorithm)
        self.record = sorted({name for plan in plans.flights for name in plan.wanted})

    def master(self, place: int, system: System) -> Master:
        """A master that is ready to initialise `system`, as the flight at `place` has it. Raises RunError if an FMU
        does not load, UsageError for values that do not fit."""
        table = self.plans.flights[place].inputs
        return self.kept.ready(place if table else -1, system, record=self.record, tolerance=self.plans.tolerance,
                               table=table)

    def fly(self, trial: Trial) -> Shown:
        """One flight. A flight that does not begin shows nothing. Raises UsageError for values that do not fit."""
        place, values = trial
        plan, plans = self.plans.flights[place], self.plans
        try:
            flight = fly_loaded(self.master(place, plan.system.with_values(values)), self.method, plans.step,
                                plan.ticks, start=plans.start)
        except RunError as error:
            return nothing(plan, str(error))
        finally:
            self.kept.drop_dead()
        return Shown(shown(flight, plan.wanted, plans.step), flight.message)

    def close(self) -> None:
        """Unload all systems."""
        self.kept.close()


def shown(flight: Flight, wanted: Mapping[str, np.ndarray], step: float) -> np.ndarray:
    """The signals at the wanted times, on straight lines between the flight's rows; NaN where it did not come to, and
    where a value is not finite."""
    found = []
    for name, times in wanted.items():
        course = flight.course(name)
        last = course.time[-1]
        near = np.where(np.abs(times - last) < 1e-6 * step, last, times)  # the last row's time may be rounded
        found.append(course.at(near))
    values = np.concatenate(found)
    return np.where(np.abs(values) < ENDLESS, values, np.nan)


# --- in processes of their own ----------------------------------------------------------------------------------------

BENCH: list[Bench] = []          # of this process
NOWHERE = open(os.devnull, "w")  # noqa: SIM115


def begin(plans: Plans) -> None:
    """Prepare a worker process."""
    as_worker()
    BENCH[:] = [Bench(plans)]


def flown_here(trial: Trial) -> Shown:
    """One flight in a worker process; one that takes too long ends the process."""
    limit = BENCH[0].plans.time_limit
    if limit is not None:
        faulthandler.dump_traceback_later(min(limit, LONGEST_S), exit=True, file=NOWHERE)
    try:
        return BENCH[0].fly(trial)
    finally:
        faulthandler.cancel_dump_traceback_later()


@dataclass
class Pool:
    """`workers` processes that fly trials; new ones follow those that an FMU has ended."""
    plans: Plans
    workers: int
    pools: list[ProcessPoolExecutor] = field(default_factory=list)

    def fly(self, trials: Sequence[Trial]) -> list[Shown]:
        """All trials; those that were not done when an FMU ended its process get another try, each alone."""
        return [one or self.attempt([trial])[0] or self.ended(trial)
                for one, trial in zip(self.attempt(trials), trials)]

    def attempt(self, trials: Sequence[Trial]) -> list[Shown | None]:
        """What trials show; None for those that were not done when an FMU ended its process."""
        found: list[Shown | None] = [None] * len(trials)
        if not self.pools:
            self.pools.append(ProcessPoolExecutor(self.workers, get_context("spawn"), begin, (self.plans,)))
        try:
            for k, future in enumerate([self.pools[0].submit(flown_here, trial) for trial in trials]):
                found[k] = future.result()
        except BrokenProcessPool:
            self.close()
        return found

    def ended(self, trial: Trial) -> Shown:
        """What a trial shows that ended its process."""
        limit = self.plans.time_limit
        return nothing(self.plans.flights[trial[0]], "An FMU ended its process" + (
            f", or took longer than {limit:g} s." if limit else "."))

    def close(self) -> None:
        """End the processes: what they fly is of no use, and may not end by itself."""
        for pool in self.pools:
            for process in list((pool._processes or {}).values()):
                process.kill()
            pool.shutdown(cancel_futures=True)
        self.pools.clear()


@contextmanager
def flying(plans: Plans, workers: int) -> Iterator[Callable[[Sequence[Trial]], list[Shown]]]:
    """A function that flies trials in so many processes; 0: in this one. Raises what `Bench.fly` raises."""
    if workers:
        pool = Pool(plans, workers)
        try:
            yield pool.fly
        finally:
            pool.close()
    else:
        bench = Bench(plans)
        try:
            yield lambda trials: [bench.fly(trial) for trial in trials]
        finally:
            bench.close()
