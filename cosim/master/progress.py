"""How far a flight is, shown while it flies: a bar in a terminal or in a notebook, nothing elsewhere."""
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from html import escape
from typing import Any

Progress = Callable[[float], None]  # is told the simulated time, s


def progress_bar(title: str, stop: float) -> tuple[AbstractContextManager[Any], Progress | None]:
    """A context manager and a progress function: a bar while the context lasts, or nothing where it would not show."""
    notebook = notebook_display()
    if notebook:
        bar = NotebookBar(notebook, title, stop)
        return bar.shown(), bar.update
    if not sys.stderr.isatty():
        return nullcontext(), None
    from rich.console import Console
    from rich.markup import escape as plain
    from rich.progress import Progress as Bar

    terminal = Bar(console=Console(stderr=True), transient=True)
    task = terminal.add_task(plain(title), total=stop)
    return terminal, lambda t: terminal.update(task, completed=t)


def notebook_display() -> Any:
    """IPython.display if this runs in a notebook, else None. Asks only for what a notebook has imported already."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython else None
    if getattr(shell, "kernel", None) is None:
        return None
    from IPython import display

    return display


class NotebookBar:
    """A <progress> element that appears with the first report and goes with the flight."""

    def __init__(self, display: Any, title: str, stop: float):
        self.display, self.title, self.stop = display, title, stop
        self.handle: Any = None

    def update(self, t: float) -> None:
        """The flight is at `t` (s)."""
        html = self.display.HTML(f'<progress value="{t:g}" max="{self.stop:g}"></progress> {escape(self.title)}: '
                                 f"{t:.6g} of {self.stop:g} s")
        if self.handle is None:
            self.handle = self.display.display(html, display_id=True)
        else:
            self.handle.update(html)

    @contextmanager
    def shown(self) -> Iterator[None]:
        """The bar, for as long as the context lasts."""
        try:
            yield
        finally:
            if self.handle is not None:
                self.handle.update(self.display.HTML(""))
