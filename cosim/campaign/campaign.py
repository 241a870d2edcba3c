"""A campaign from its file to its report: what `ahv campaign` does."""
import logging
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from importlib import import_module
from pathlib import Path
from threading import Thread
from typing import TYPE_CHECKING, Any

from ..errors import RunError, UsageError
from ..master.folder import claimed
from ..temporary import Folder
from .plan import Plan, load
from .progress import note, on_terminal, shown
from .resume import prepare
from .store import CONTINUE, Store
from .subject import Subject

if TYPE_CHECKING:
    from distributed import Client


def campaign(path: Path, out: Path | None = None, scheduler: str | None = None, resume: bool = False,
             workers: int | None = None, tls: tuple[Path, Path, Path] | None = None,
             dashboard: bool = False, subjects: Sequence[type[Subject]] = ()) -> dict[str, Any]:
    """Fly the campaign in the file at `path` and write its results; a summary as JSON goes.

    `tls` are the files of CA, certificate and key for a `scheduler`; `dashboard` opens Dask's on the cluster of this
    machine, for everybody who can reach the port. `subjects` are what a file may be about, beside any system's file.
    Raises UsageError before any run flies if the file cannot be flown; RunError if the cluster was lost, the disk is
    full or the report cannot be drawn: what was flown is kept.
    """
    began = time.perf_counter()
    if tls and not (scheduler or "").startswith("tls://"):
        raise UsageError(f"--tls-ca, --tls-cert and --tls-key are for a --scheduler tls://..., not {scheduler}.")
    plan = load(path, *subjects)
    return carried_out(plan, path.read_text(), out, scheduler, resume, workers, tls, dashboard, began)


def carried_out(plan: Plan, text: str, out: Path | None, scheduler: str | None = None, resume: bool = False,
                workers: int | None = None, tls: tuple[Path, Path, Path] | None = None, dashboard: bool = False,
                began: float | None = None) -> dict[str, Any]:
    """As `campaign`, of a plan whose file has the content `text`; `began` is when (time.perf_counter, s)."""
    began = time.perf_counter() if began is None else began
    with claimed(out, "campaign", plan.campaign.name) as folder:
        store = Store(folder, plan)
        try:
            for sentence in (*plan.subject.remarks, *prepare(store, resume, text)):
                note(sentence)
            flown, flying_s = (0, 0.0) if store.complete else fly(plan, store, scheduler, workers, tls, dashboard)
            summary = reported(store)
        except (KeyboardInterrupt, SystemExit):
            note(f"Interrupted; {CONTINUE}.")
            raise
    return {**summary, "runs_flown_now": flown, "flying_s": flying_s, "wall_s": time.perf_counter() - began,
            "out": str(folder)}


def reported(store: Store) -> dict[str, Any]:
    """The report's numbers, once it is written. Raises RunError if that fails, for whatever reason."""
    try:
        if store.plan.campaign.rare:
            from .rare_report import write
        else:
            from .report import write  # imports matplotlib, which is slow

        return write(store)
    except Exception as error:
        raise RunError(f"The report could not be drawn ({type(error).__name__}: {error}). All runs are in "
                       f"{store.folder}, and --resume draws it.") from error


def fly(plan: Plan, store: Store, scheduler: str | None, workers: int | None, tls: tuple[Path, Path, Path] | None,
        dashboard: bool) -> tuple[int, float]:
    """What is missing; (rows that were flown, seconds that took)."""
    from .engine import Engine, send
    from .nominal import check

    total = plan.campaign.runs * len(plan.laws)
    rows, successes = store.counts()
    began = time.perf_counter()
    if any(store.missing()):
        with connected(scheduler, workers, tls, dashboard) as client:
            send(client, plan)
            for sentence in check(client, plan) if rows == 0 else ():
                note(sentence)
            began = time.perf_counter()
            Thread(target=import_for_report, daemon=True).start()
            with shown(plan.campaign.name, total, rows, successes,
                       client.dashboard_link if dashboard or (scheduler and on_terminal()) else None) as progress:
                engine = Engine(client, plan, store, progress)
                if plan.campaign.rare:
                    from .rare_flights import fly as fly_levels

                    fly_levels(engine, plan, store)
                else:
                    engine.run()
    flying, flown = time.perf_counter() - began, store.counts()[0] - rows
    store.finish()
    return flown, flying


def import_for_report() -> None:
    """Import what the report needs, which takes a second, while others fly."""
    with suppress(Exception):  # `reported` says what is wrong
        for name in ("scipy.stats", "cosim.campaign.report"):
            import_module(name)


@contextmanager
def connected(scheduler: str | None, workers: int | None, tls: tuple[Path, Path, Path] | None, dashboard: bool
              ) -> Iterator["Client"]:
    """A client of the cluster at `scheduler`, or of a temporary one on this machine."""
    from . import cluster  # imports Dask, which is slow

    logging.disable(logging.CRITICAL)  # what matters is said by this program
    if scheduler is not None:
        with cluster.remote(scheduler, cluster.Tls(*tls) if tls else None) as client:
            yield client
    else:
        with Folder() as folder, cluster.local(folder.path / "work", workers, dashboard) as client:
            yield client
