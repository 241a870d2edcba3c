"""What a terminal shows while a campaign runs, on stderr; nothing where stderr is none."""
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

from .engine import Progress


@contextmanager
def shown(title: str, total: int, rows: int, successes: int, dashboard: str) -> Iterator[Progress]:
    """A progress function; `rows` and `successes` are there from before."""
    if not sys.stderr.isatty():
        yield lambda more, good: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    console = Console(stderr=True)
    if dashboard:
        console.print(f"Dask dashboard: {dashboard}", highlight=False)
    began, before = time.monotonic(), rows
    with Progress(TextColumn(title), BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[said]}"),
                  TimeRemainingColumn(), console=console) as bar:
        task = bar.add_task(title, total=total, completed=rows, said="")

        def update(more: int, good: int) -> None:
            nonlocal rows, successes
            rows, successes = rows + more, successes + good
            rate = (rows - before) / max(time.monotonic() - began, 1e-9)
            bar.update(task, completed=rows, said=f"{rate:.1f} runs/s, {100 * successes / rows:.1f} % successes")

        yield update
