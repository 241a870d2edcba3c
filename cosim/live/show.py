"""A flight on a live page, from its first tick until its results are written."""
from collections.abc import Callable
from functools import cache
from pathlib import Path
from types import TracebackType

import numpy as np

from ..master.desk import Desk
from ..master.flight import Flight
from ..pages.write import fingerprint
from ..pages.write import read as read_shared
from ..text import filled_in, html_text
from .board import Board
from .feed import Feed
from .server import Server

FILES = Path(__file__).parent / "page"
UPLOT = Path(__file__).parents[1] / "playground" / "page" / "uplot"  # 51 kB; BokehJS has a megabyte
SCRIPTS = ("gauges.js", "charts.js", "live.js")


class Show:
    """A `Watch` of a flight: the page is there from the flight's beginning to the end of the context, and `announce`
    is told its address. `desk` is for the flight."""

    def __init__(self, board: Board, announce: Callable[[str], None]):
        self.desk = Desk([lever.input for lever in board.levers])
        self.feed, self.announce = Feed(board, self.desk), announce
        self.server: Server | None = None

    def __enter__(self) -> "Show":
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
                 ) -> None:
        if self.server:
            if error is not None:
                self.feed.ended(trouble=str(error) or kind.__name__ if kind else "")
            self.server.end()

    def begun(self, flight: Flight) -> None:
        """Serve the page. The flight's process has begun: it has no part in the server's threads and sockets."""
        self.feed.begun(flight)
        self.server = Server(*page(self.feed.board.title), self.feed)
        self.server.begin()
        self.announce(self.server.address)

    def rows(self, times: np.ndarray, rows: np.ndarray) -> None:
        """Rows as they come."""
        self.feed.rows(times, rows)

    def ended(self, flight: Flight) -> None:
        """The flight is over, and its results are to be written."""
        self.feed.ended(finished=flight.finished, message=flight.message, reached=flight.reached,
                        interrupted=bool(flight.interrupted))

    def written(self, folder: Path) -> None:
        """The results are in `folder`."""
        self.feed.ended(written=str(folder))


def page(title: str) -> tuple[str, str]:
    """The page as a text of HTML, and its content security policy."""
    style, script = parts()
    policy = (f"default-src 'none'; script-src {fingerprint(script)}; style-src {fingerprint(style)}; "
              f"connect-src 'self'; img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'")
    return filled_in(read("live.html"), {"title": html_text(title), "style": style, "script": script}), policy


@cache
def parts() -> tuple[str, str]:
    """The page's styles and scripts."""
    style = [(UPLOT / "uPlot.min.css").read_text(encoding="utf-8"), read_shared("style.css"), read("live.css")]
    script = [(UPLOT / "uPlot.iife.min.js").read_text(encoding="utf-8"), *map(read, SCRIPTS)]
    return "\n".join(style), "\n".join(script)


def read(name: str) -> str:
    """A file of the page."""
    return (FILES / name).read_text(encoding="utf-8")
