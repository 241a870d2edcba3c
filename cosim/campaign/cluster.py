"""Dask clusters: one on this machine for the time of a campaign, or one that is there already.

Who can reach a scheduler without TLS can run code on its workers, and sees what is sent. The cluster on this machine
takes only those who have the certificate that is made for it; its files are where this user alone can read.
"""
import logging
import multiprocessing
import os
import shutil
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any

import dask
from distributed import Client, LocalCluster
from distributed.comm.registry import get_backend
from distributed.security import Security

from ..errors import RunError, UsageError

WAIT_S = 60.0  # for a first worker
ANSWER_S = 15.0  # for an answer of the scheduler
KILLED_S = 0.5   # for processes that are killed, or are just starting
CLOSING_S = 0.1  # for what has no processes any more: it goes on by itself, and nothing waits for it


@dataclass(frozen=True)
class Tls:
    """Files in PEM format: who is trusted, and who we are."""
    ca: Path
    cert: Path
    key: Path

    def security(self) -> Security:
        """As Dask takes it. Raises UsageError for a file that cannot be used."""
        found = Security(require_encryption=True, tls_ca_file=str(self.ca), tls_client_cert=str(self.cert),
                         tls_client_key=str(self.key))
        for path in (self.ca, self.cert, self.key):
            if not path.is_file():
                raise UsageError(f"{path}: there is no such file.")
        try:
            found.get_connection_args("client")
        except (OSError, ValueError) as error:
            raise UsageError(f"{self.ca}, {self.cert}, {self.key}: these are not two certificates and the key of "
                             f"the second ({error}).") from None
        return found


@contextmanager
def local(folder: Path, workers: int | None, dashboard: bool) -> Iterator[Client]:
    """A client of a cluster of worker processes on this machine, which have their files in `folder`.

    Processes and folder are gone at the end.

    Raises RunError if no worker starts.
    """
    shutil.rmtree(folder, ignore_errors=True)
    os.environ.setdefault("PYTHONWARNINGS", "ignore:resource_tracker")  # it tells that it cleans up after a kill
    options: dict[str, Any] = {"distributed.scheduler.allowed-failures": 1, "temporary-directory": str(folder)}
    if not dashboard:
        options |= {f"distributed.{who}.http.routes": [] for who in ("scheduler", "worker")}
        options["distributed.worker.profile.enabled"] = False  # what only a dashboard shows
    others = set(multiprocessing.active_children())
    with dask.config.set(options):
        with ThreadPoolExecutor(1) as apart:  # an interrupt in the middle would leave what neither runs nor ends
            cluster, client = apart.submit(start, folder, dashboard).result()
        try:
            cluster.scale(workers or os.cpu_count() or 1)
            with_workers(client, "No worker process started on this machine.")
            yield client
        finally:
            end(cluster, client, others)
            shutil.rmtree(folder, ignore_errors=True)


def start(folder: Path, dashboard: bool) -> tuple[LocalCluster, Client]:
    """A cluster without workers, and its client."""
    cluster = LocalCluster(n_workers=0, threads_per_worker=1, local_directory=str(folder), security=own(folder),
                           dashboard_address="127.0.0.1:0", scheduler_kwargs={"dashboard": dashboard},
                           silence_logs=logging.CRITICAL)
    return cluster, Client(cluster)


def own(folder: Path) -> Security:
    """A certificate made for one cluster, as files below `folder`: from memory, Dask would write them to a temporary
    folder for each connection, and a process that is killed then would leave the key."""
    made, place = Security.temporary(), folder / "certificates"
    place.mkdir(mode=0o700, parents=True)
    names = ["tls_ca_file"]
    names += [f"tls_{who}_{what}" for who in ("client", "scheduler", "worker") for what in ("cert", "key")]
    for name in names:
        (place / name).write_text(getattr(made, name))
    return Security(require_encryption=True, **{name: str(place / name) for name in names})


def end(cluster: LocalCluster, client: Client, others: set[BaseProcess]) -> None:
    """End a cluster at once, but not `others` than its processes: what its workers still do is of no use."""
    cluster.shutdown_on_close = False  # not once more when Python ends
    for nanny in cluster.workers.values():
        nanny.auto_restart = False
    starting = cluster.workers.keys() != cluster.worker_spec.keys()
    kill(others)
    for one in (client, cluster):
        with suppress(Exception):  # processes that are gone cannot say goodbye
            one.close(timeout=KILLED_S if starting else CLOSING_S)
    kill(others)  # that were just starting


def kill(others: set[BaseProcess]) -> None:
    """Kill all child processes but `others`, and see them end: they write no file any more then."""
    killed = set(multiprocessing.active_children()) - others
    for process in killed:
        process.kill()
    for process in killed:
        process.join(KILLED_S)


@contextmanager
def remote(scheduler: str, tls: Tls | None) -> Iterator[Client]:
    """A client of the cluster at `scheduler`. Without `tls` Dask's own configuration holds.

    Raises UsageError for an address that cannot be one, or TLS files that cannot be used; RunError if there is no
    cluster, or if it has no workers.
    """
    security = tls.security() if tls else Security()
    check_address(scheduler, security)
    try:
        client = Client(scheduler, timeout=ANSWER_S, security=security)
    except (OSError, ValueError, TypeError, RuntimeError) as error:
        raise RunError(f"There is no Dask scheduler at {scheduler} that takes us: {error}") from None
    with client:
        with_workers(client, f"The scheduler at {scheduler} has no workers.")
        yield client


def check_address(scheduler: str, security: Security) -> None:
    """Raises UsageError for an address that names no host and port, that Dask cannot reach from here, or that needs
    certificates which `security` does not have."""
    protocol, _, place = scheduler.rpartition("://")
    host, _, port = place.rpartition(":")
    if not (host.strip() and port.isascii() and port.isdigit() and 0 < int(port[:6]) <= 65535):
        raise UsageError(f"--scheduler {scheduler} is not an address: give tcp://HOST:PORT or tls://HOST:PORT.")
    try:
        get_backend(protocol or "tcp").get_connector()
    except (ValueError, ImportError, TypeError) as error:
        raise UsageError(f"--scheduler {scheduler} cannot be reached from here: {error}.") from None
    if protocol in ("tls", "wss") and not security.get_connection_args("client").get("ssl_context"):
        raise UsageError(f"--scheduler {scheduler} needs certificates: give --tls-ca, --tls-cert and --tls-key, or set "
                         f"Dask's own configuration.")


def with_workers(client: Client, otherwise: str) -> None:
    """Wait for a worker. Raises RunError with the sentence `otherwise` if none comes."""
    try:
        client.wait_for_workers(1, timeout=WAIT_S)
    except TimeoutError:
        raise RunError(otherwise) from None
