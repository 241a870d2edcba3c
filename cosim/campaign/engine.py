"""The client: sends tasks to a Dask cluster, a bounded number at a time, and puts the outcomes into the store."""
import uuid
from collections import deque
from collections.abc import Iterable, Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager
from itertools import count

import numpy as np
from distributed import Client, Future, KilledWorker, as_completed

from ..errors import RunError
from .code import code, differences
from .plan import Plan
from .progress import Progress, note
from .store import CONTINUE, Store
from .worker import (
    OtherCode,
    Outcome,
    SendFmu,
    SendJob,
    disk_is_full,
    fly_batch,
    plugin_name,
    refusal,
    requests,
)

AHEAD = 4            # tasks submitted at a time for each thread of the cluster
GONE = f"The Dask scheduler is gone; {CONTINUE}."


def send(client: Client, plan: Plan) -> None:
    """Send the job and the FMU files to all workers, also to those that join later; not files that the cluster has.

    Raises RunError if a worker has other code.
    """
    with asking():
        for address, found in client.run(code, on_error="return").items():
            if other := differences(found, plan.job.code):
                raise RunError(refusal(address, other))
        known = client.run_on_scheduler(lambda dask_scheduler: list(dask_scheduler.worker_plugins))
        for stored, path in plan.fmus.items():
            if plugin_name(stored) not in known:
                client.register_plugin(SendFmu(stored, path.read_bytes()))
        client.register_plugin(SendJob(plan.job))


@contextmanager
def asking() -> Iterator[None]:
    """Around a request to the cluster. Raises RunError if the cluster is lost, or has a full disk."""
    try:
        yield
    except (OSError, CancelledError, TimeoutError) as error:
        raise RunError(f"A disk of the cluster is full; {CONTINUE}." if disk_is_full(error) else GONE) from error


def cannot_fly(error: BaseException) -> RunError:
    """The end of a campaign of which a task failed with `error`."""
    reason = str(error) if isinstance(error, RunError) else f"{type(error).__name__}: {error}"
    return RunError(f"The cluster cannot fly this campaign: {reason.rstrip('.')}; {CONTINUE}.")


class Batch:
    """A submitted task: runs first ... last - 1 of each law, at `points` if these are not the sampler's. If workers die
    of it, its runs are flown one by one."""

    def __init__(self, plan: Plan, first: int, last: int, points: np.ndarray | None = None):
        self.first, self.last, self.points = first, last, points
        self.size = (last - first) * len(plan.laws)
        self.outcomes: dict[int, Outcome] = {}

    @property
    def complete(self) -> bool:
        """Whether all outcomes are there."""
        return len(self.outcomes) == self.size

    @property
    def rows(self) -> list[Outcome]:
        """The outcomes in order."""
        return [self.outcomes[i] for i in range(self.size)]


class Engine:
    """One campaign on one cluster."""

    def __init__(self, client: Client, plan: Plan, store: Store, progress: Progress):
        self.client, self.plan, self.store, self.progress = client, plan, store, progress
        self.flying: dict[Future, tuple[Batch, list[int]]] = {}
        self.queue = as_completed()
        self.suspects: deque[tuple[Batch, int]] = deque()
        self.name, self.numbers = uuid.uuid4().hex, count()

    def run(self, batches: Iterable[Batch] | None = None) -> None:
        """All `batches`; without them, all runs that the store does not have yet, unless enough are there to stop.

        Raises RunError if the cluster is lost, or cannot fly at all.
        """
        missing = iter(batches) if batches is not None else (Batch(self.plan, *span) for span in self.store.missing())
        rule = self.store.front.rule is not None  # it waits for each run in turn: those that are suspected come first
        while self.store.front.stopped is None:
            with asking():
                most = AHEAD * max(1, sum(self.client.nthreads().values()))
            while len(self.flying) < most and not (rule and self.suspects):
                if (batch := next(missing, None)) is None:
                    break
                self.submit(batch, list(range(batch.size)))
            if not self.flying:
                if not self.suspects:
                    return
                batch, position = self.suspects.popleft()  # alone, so that no other run can be the reason for a crash
                self.submit(batch, [position], alone=True)
            with asking():
                future = next(self.queue)
            self.take(future)
        with asking():
            self.client.cancel(list(self.flying))

    def submit(self, batch: Batch, positions: list[int], alone: bool = False) -> None:
        """Submit the runs of a batch at `positions`; `alone` if a worker died of the run before."""
        number = next(self.numbers)
        future = self.client.submit(fly_batch, self.plan.job.key, batch.first, batch.last,
                                    None if len(positions) == batch.size else positions, batch.points, pure=False,
                                    key=(f"{'alone' if alone else 'ahv'}-{self.name}", number))
        self.flying[future] = batch, positions
        self.queue.add(future)

    def take(self, future: Future) -> None:
        """Use the result of a task. Raises RunError if the cluster is lost or cannot fly."""
        batch, positions = self.flying.pop(future)
        if future.status == "finished":
            with asking():
                batch.outcomes.update(zip(positions, future.result()))
        elif future.status in ("lost", "pending"):  # its worker died before we had the result: Dask flies it again
            self.flying[future] = batch, positions
            self.queue.add(future)
        elif future.status != "error":
            raise RunError(GONE)
        elif isinstance(error := future.exception(), OtherCode):
            self.refuse(error)
            self.submit(batch, positions, alone=is_alone(future))
        elif not isinstance(error, KilledWorker):
            raise cannot_fly(error)
        elif is_alone(future):
            request = list(requests(self.plan.job, batch.first, batch.last, batch.points))[positions[0]]
            batch.outcomes[positions[0]] = Outcome(
                request, "crashed", "Each worker that flew this run died of it: an FMU crashed, or hung beyond "
                f"timeout_s = {self.plan.job.timeout_s:g}.")
        elif len(positions) == 1:
            self.suspects.append((batch, positions[0]))
        else:
            for position in positions:
                self.submit(batch, [position])
        if batch.complete:
            self.store.add(batch.first, batch.rows)
            self.progress(batch.size, sum(o.succeeded for o in batch.outcomes.values()))

    def refuse(self, error: OtherCode) -> None:
        """Send a worker away that joined with other code. Raises RunError if there is no other."""
        sentence, address = error.args
        with asking():
            if address in self.client.nthreads():
                note(sentence)
                self.client.retire_workers([address])
            if not self.client.nthreads():
                raise RunError(f"{sentence.rstrip('.')}, and there is no other; {CONTINUE}.")


def is_alone(future: Future) -> bool:
    """Whether a task was submitted alone."""
    return str(future.key[0]).startswith("alone")  # type: ignore[index]
