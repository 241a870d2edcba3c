"""What a campaign says on stderr while it runs: sentences, and a progress bar if stderr is a terminal."""
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

from .engine import Progress


@contextmanager
def shown(title: str, total: int, rows: int, successes: int, dashboard: str) -> Iterator[Progress]:
    """A function that is told of (rows, successes) that were added to the `rows` and `successes` of before."""
    if not sys.stderr.isatty():
        yield lambda more, good: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    console = Console(stderr=True)
    if dashboard:
        console.print(f"Dask dashboard: {dashboard}", highlight=False)
    began, before = time.monotonic(), rows
    with Progress(TextColumn(title, markup=False), BarColumn(), MofNCompleteColumn(),
                  TextColumn("{task.fields[rates]}"), TimeRemainingColumn(), console=console) as bar:
        task = bar.add_task(title, total=total, completed=rows, rates="")

        def update(more: int, good: int) -> None:
            nonlocal rows, successes
            rows, successes = rows + more, successes + good
            rate = (rows - before) / max(time.monotonic() - began, 1e-9)
            share = 100 * successes / rows
            bar.update(task, completed=rows, rates=f"{rate:.1f} runs/s, {share:.1f} % of all so far successes")

        yield update


def note(sentence: str) -> None:
    """A sentence that a reader should know although the campaign goes on."""
    print(f"ahv: {sentence}", file=sys.stderr, flush=True)
