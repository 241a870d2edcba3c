"""What browsers are told of a flight, as texts of JSON. The flight's process tells it; threads wait for news of it."""
import json
import time
from collections import deque
from collections.abc import Iterator
from math import isfinite
from threading import Condition
from typing import Any

import numpy as np

from ..master.desk import Desk
from ..master.flight import Flight
from .board import Board

RATE = 20           # rows a second of wall time
MOST_ROWS = 24_000  # 20 minutes; the oldest go
QUIET_S = 1.0       # without news: a line that tells whether the browser is still there


class Feed:
    """A flight as pages see it. A page that comes later, or again, is told everything from the beginning."""

    def __init__(self, board: Board, desk: Desk):
        self.board, self.desk = board, desk
        self.news = Condition()
        self.about: dict[str, Any] = {}
        self.places: list[int] = []
        self.kept: deque[str] = deque(maxlen=MOST_ROWS)   # rows as JSON: they are told to several pages
        self.seen = 0                                     # rows kept so far, also those that have gone
        self.due = 0.0
        self.last: tuple[float, np.ndarray] | None = None   # the row that is not kept yet
        self.end: dict[str, Any] | None = None            # how the flight ended
        self.closed = False                               # nothing follows
        self.version = 0                                  # grows with all news

    def begun(self, flight: Flight) -> None:
        """What is known before the first tick."""
        known = [c.name for c in self.board.signals(flight.columns)]
        self.places = [flight.places[name] for name in known]
        self.about = {**self.board.about(flight), "columns": known}

    def rows(self, times: np.ndarray, rows: np.ndarray) -> None:
        """Keep the last of these rows, unless the one before is as good as new."""
        now, self.last = time.monotonic(), (float(times[-1]), rows[-1])
        if now >= self.due:
            self.due = now + 1 / RATE
            self.keep()

    def keep(self) -> None:
        """Tell the last row, unless that was done."""
        with self.news:
            if self.last:
                row = [self.last[0], *self.last[1][self.places].tolist()]
                self.kept.append(f"[{','.join(repr(x) if isfinite(x) else 'null' for x in row)}]")
                self.seen, self.last = self.seen + 1, None
            self.tell()

    def tell(self) -> None:
        """Wake all who wait; the lock is held."""
        self.version += 1
        self.news.notify_all()

    def ended(self, **how: Any) -> None:
        """Tell how the flight ended, or more of that."""
        self.keep()
        with self.news:
            self.end = {**(self.end or {}), **how}
            self.tell()

    def close(self) -> None:
        """Nothing follows: pages have been told all."""
        with self.news:
            self.closed = True
            self.tell()

    def messages(self) -> Iterator[str]:
        """Texts of JSON for one page, as there are news, to the end; an empty one after QUIET_S without any."""
        told = version = 0
        about: dict[str, Any] = {"about": self.about}
        while True:
            with self.news:
                if self.version == version and not self.closed:
                    self.news.wait(QUIET_S)
                fresh = list(self.kept)[-(self.seen - told):] if self.seen > told else []
                quiet, over, end = self.version == version and not about, self.closed, self.end
                told, version = self.seen, self.version
            if quiet and not over:
                yield ""
                continue
            state = {"made": self.desk.made(), "wanted": dict(zip(self.desk.inputs, self.desk.wanted.tolist())),
                     "late": self.desk.late.tolist(), "end": end, **about}
            yield f'{{"rows":[{",".join(fresh)}],{json.dumps(state, separators=(",", ":"))[1:]}'
            about = {}
            if over:
                return
