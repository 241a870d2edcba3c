"""What a campaign says on stderr while it runs: a progress bar on a terminal, else a line a minute; and sentences."""
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Event, Thread

LINE_S = 60.0
Progress = Callable[[int, int], None]  # rows, successes that were added


class Count:
    """The rows and successes of a campaign, and the rate since it was made."""

    def __init__(self, title: str, total: int, rows: int, successes: int):
        self.title, self.total, self.rows, self.successes = title, total, rows, successes
        self.before, self.began = rows, time.monotonic()

    @property
    def rates(self) -> str:
        """Runs a second, and the share of successes."""
        share = f", {100 * self.successes / self.rows:.1f} % of all so far successes" if self.rows else ""
        return f"{self.rate:.1f} runs/s{share}"

    @property
    def rate(self) -> float:
        """Runs a second, 1/s."""
        return (self.rows - self.before) / max(time.monotonic() - self.began, 1e-9)

    @property
    def line(self) -> str:
        """All of it in one sentence."""
        left = "unknown time" if self.rate == 0 else duration((self.total - self.rows) / self.rate)
        return f"{self.title}: {self.rows:,} of {self.total:,} runs, {self.rates}, {left} left"


def duration(seconds: float) -> str:
    """A time (s) as h:mm:ss."""
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes // 60}:{minutes % 60:02d}:{rest:02d}"


@contextmanager
def shown(title: str, total: int, rows: int, successes: int, dashboard: str | None = None,
          every: float = LINE_S) -> Iterator[Progress]:
    """A function that is told of (rows, successes) that were added to the `rows` and `successes` of before.

    Without a terminal there is a line `every` so many seconds, whether or not something was added.
    """
    count = Count(title, total, rows, successes)
    if dashboard:
        note(f"Dask dashboard: {dashboard}")
    with (bar if on_terminal() else lines)(count, every) as update:
        def added(more: int, good: int) -> None:
            count.rows, count.successes = count.rows + more, count.successes + good
            update()

        yield added


@contextmanager
def lines(count: Count, every: float) -> Iterator[Callable[[], None]]:
    """A line `every` so many seconds."""
    done = Event()

    def say() -> None:
        while not done.wait(every):
            note(count.line)

    thread = Thread(target=say, daemon=True)
    thread.start()
    try:
        yield lambda: None
    finally:
        done.set()
        thread.join()


@contextmanager
def bar(count: Count, every: float) -> Iterator[Callable[[], None]]:
    """A bar that moves when the count does."""
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    with Progress(TextColumn(count.title, markup=False), BarColumn(), MofNCompleteColumn(),
                  TextColumn("{task.fields[rates]}"), TimeRemainingColumn(), console=Console(stderr=True)) as shown:
        task = shown.add_task(count.title, total=count.total, completed=count.rows, rates="")
        yield lambda: shown.update(task, completed=count.rows, rates=count.rates)


def on_terminal() -> bool:
    """Whether somebody watches."""
    return sys.stderr.isatty()


def note(sentence: str) -> None:
    """A sentence that a reader should know although the campaign goes on."""
    print(f"ahv: {sentence}", file=sys.stderr, flush=True)
