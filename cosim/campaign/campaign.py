"""A campaign from its file to its report: what `ahv campaign` does."""
import time
from pathlib import Path
from typing import Any

from ..errors import RunError
from ..master.folder import claimed
from .plan import load
from .store import Store


def campaign(path: Path, out: Path | None = None, scheduler: str | None = None, resume: bool = False,
             workers: int | None = None) -> dict[str, Any]:
    """Fly the campaign in the file at `path` and write its results; a summary as JSON goes.

    Raises UsageError before any run flies if the file cannot be flown; RunError if the cluster was lost.
    """
    began = time.perf_counter()
    plan = load(path)
    with claimed(out, "campaign", plan.campaign.name) as folder:
        store = Store(folder, plan)
        store.prepare(resume, path.read_text())
        flown, flying_s = (0, 0.0) if store.complete else fly(plan, store, scheduler, workers)
        from .report import write  # imports matplotlib, which is slow

        summary = write(store)
    return {**summary, "runs_flown_now": flown, "flying_s": flying_s, "wall_s": time.perf_counter() - began,
            "out": str(folder)}


def fly(plan: Any, store: Store, scheduler: str | None, workers: int | None) -> tuple[int, float]:
    """What is missing; (rows that were flown, seconds that took)."""
    from .engine import CONTINUE, Engine, connected, send
    from .nominal import check
    from .progress import note, shown

    total = plan.campaign.runs * len(plan.laws)
    rows, successes = store.counts()
    began = time.perf_counter()
    try:
        if rows < total:
            with connected(scheduler, workers) as client:
                send(client, plan)
                for sentence in check(client, plan) if rows == 0 else ():
                    note(sentence)
                began = time.perf_counter()
                with shown(plan.campaign.name, total, rows, successes, client.dashboard_link) as progress:
                    Engine(client, plan, store, progress).run()
    except KeyboardInterrupt:
        raise RunError(f"Interrupted; {CONTINUE}.") from None
    flying = time.perf_counter() - began
    store.finish()
    return total - rows, flying
