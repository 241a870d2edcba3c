"""The client: sends tasks to a Dask cluster, a bounded number at a time, and puts the outcomes into the store."""
import logging
import os
import tempfile
import uuid
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager
from itertools import count

import dask
from distributed import Client, Future, KilledWorker, LocalCluster, as_completed

from ..errors import RunError
from .plan import Plan
from .store import Store
from .worker import Outcome, SendFmu, SendJob, fly_batch, plugin_name, requests

AHEAD = 4            # tasks submitted at a time for each thread of the cluster
WAIT_S = 60.0        # for a first worker
CONTINUE = "what was flown until then is kept, and --resume continues"
GONE = f"The Dask scheduler is gone; {CONTINUE}."
Progress = Callable[[int, int], None]  # rows, successes that were added


@contextmanager
def connected(scheduler: str | None, workers: int | None) -> Iterator[Client]:
    """A client of the cluster at `scheduler`, or of a temporary one on this machine.

    Raises RunError if there is no cluster, or if it has no workers.
    """
    logging.disable(logging.CRITICAL)  # what matters is said by this program
    if scheduler is None:
        with (dask.config.set({"distributed.scheduler.allowed-failures": 1}),
              tempfile.TemporaryDirectory(prefix="ahv_campaign_") as folder,
              LocalCluster(n_workers=workers or os.cpu_count() or 1, threads_per_worker=1, local_directory=folder,
                           dashboard_address="127.0.0.1:0", silence_logs=logging.CRITICAL) as cluster,
              Client(cluster) as client):
            yield client
        return
    try:
        client = Client(scheduler, timeout=WAIT_S / 4)
    except (OSError, ValueError, TimeoutError) as error:
        raise RunError(f"There is no Dask scheduler at {scheduler}: {error}") from None
    with client:
        try:
            client.wait_for_workers(1, timeout=WAIT_S)
        except TimeoutError:
            raise RunError(f"The scheduler at {scheduler} has no workers.") from None
        yield client


def send(client: Client, plan: Plan) -> None:
    """Send the job and the FMU files to all workers, also to those that join later; not files that the cluster has."""
    known = client.run_on_scheduler(lambda dask_scheduler: list(dask_scheduler.worker_plugins))
    for stored, path in plan.fmus.items():
        if plugin_name(stored) not in known:
            client.register_plugin(SendFmu(stored, path.read_bytes()))
    client.register_plugin(SendJob(plan.job))


@contextmanager
def asking() -> Iterator[None]:
    """Around a request to the cluster. Raises RunError if the cluster is lost."""
    try:
        yield
    except (OSError, CancelledError, TimeoutError) as error:
        raise RunError(GONE) from error


class Batch:
    """A submitted task: runs first ... last - 1 of each law. If workers die of it, its runs are flown one by one."""

    def __init__(self, plan: Plan, first: int, last: int):
        self.first, self.last = first, last
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

    def run(self) -> None:
        """All runs that the store does not have yet.

        Raises RunError if the cluster is lost, or cannot fly at all.
        """
        missing = (b for b in self.plan.batches() if not self.store.has(b[0]))
        while True:
            with asking():
                most = AHEAD * max(1, sum(self.client.nthreads().values()))
            while len(self.flying) < most:
                if (span := next(missing, None)) is None:
                    break
                batch = Batch(self.plan, *span)
                self.submit(batch, list(range(batch.size)))
            if not self.flying:
                if not self.suspects:
                    return
                batch, position = self.suspects.popleft()  # alone, so that no other run can be the reason for a crash
                self.submit(batch, [position], alone=True)
            with asking():
                future = next(self.queue)
            self.take(future)

    def submit(self, batch: Batch, positions: list[int], alone: bool = False) -> None:
        """Submit the runs of a batch at `positions`; `alone` if a worker died of the run before."""
        number = next(self.numbers)
        future = self.client.submit(fly_batch, self.plan.job.key, batch.first, batch.last,
                                    None if len(positions) == batch.size else positions, pure=False,
                                    key=(f"{'alone' if alone else 'ahv'}-{self.name}", number))
        self.flying[future] = batch, positions
        self.queue.add(future)

    def take(self, future: Future) -> None:
        """Use the result of a task. Raises RunError if the cluster is lost or cannot fly."""
        batch, positions = self.flying.pop(future)
        if future.status == "finished":
            with asking():
                batch.outcomes.update(zip(positions, future.result()))
        elif future.status != "error":
            raise RunError(GONE)
        elif not isinstance(error := future.exception(), KilledWorker):
            raise RunError(f"The cluster cannot fly this campaign: {type(error).__name__}: {error}")
        elif str(future.key[0]).startswith("alone"):  # type: ignore[index]
            request = list(requests(self.plan.job, batch.first, batch.last))[positions[0]]
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
