"""Carries out what `wrong_use` draws, and tells how it ended.

    python tests/wrong_tried.py [KIND [FIRST LAST]]        # the failures, and a table
"""
import contextlib
import io
import os
import signal
import sys
import tempfile
import traceback
from dataclasses import dataclass
from pathlib import Path

from wrong_use import KINDS, Bad, drawn

LONGEST = 10.0  # s, for one input, of a processor's time: what else runs on the machine does not count
os.environ["BROWSER"] = "true"  # which --open starts: it shows nothing
PATIENCE = 60  # s, for one input, on a machine that has nothing else to do


class TooLong(BaseException):
    """An input took longer than it may."""


def tried(bad: Bad) -> tuple[int, float, str]:
    """Carry it out: (exit status, seconds of a processor, what was said). Status 99: an exception came out, or it took
    too long."""
    def late(*_: object) -> None:
        raise TooLong

    said, began = io.StringIO(), used()
    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(round(PATIENCE * max(1.0, os.getloadavg()[0] / (os.cpu_count() or 1))))
    try:
        with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
            try:
                status = bad.act()
            except (Exception, TooLong):
                status = 99
                said.write(traceback.format_exc())
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
    return status, used() - began, said.getvalue()


def used() -> float:
    """Processor time (s) of this process and of those that it waited for."""
    return sum(os.times()[:4])


def fault(status: int, seconds: float, said: str) -> str:
    """What is wrong with how an input ended; empty if nothing is."""
    if status not in (0, 1, 2):
        return f"exit status {status}"
    if "Traceback" in said:
        return "a traceback"
    if seconds > LONGEST:
        return f"{seconds:.1f} s"
    ours = [line for line in said.splitlines() if line.startswith("ahv: ")]
    if status == 2 and not ours and "Usage:" not in said:
        return "no sentence"
    return ""


@dataclass
class Tally:
    """How the inputs of a kind ended: exit status -> how many, the slowest (s), and what was wrong."""
    kind: str
    ended: dict[int, int]
    slowest: float
    faults: list[str]

    def __str__(self) -> str:
        counts = " ".join(f"{status}: {self.ended.get(status, 0):4}" for status in (0, 1, 2))
        return (f"{self.kind:20}{sum(self.ended.values()):6} tried   exit status {counts}   "
                f"slowest {self.slowest:4.1f} s   failures {len(self.faults)}")


def tally(kind: str, first: int, last: int, folder: Path) -> Tally:
    """Try the inputs `first` ... `last` - 1 of a kind in `folder`."""
    found = Tally(kind, {}, 0.0, [])
    with contextlib.chdir(folder):
        for k in range(first, last):
            bad = drawn(kind, k, folder)
            status, seconds, said = tried(bad)
            if seconds > LONGEST:
                status, seconds, said = tried(bad)
            found.ended[status] = found.ended.get(status, 0) + 1
            found.slowest = max(found.slowest, seconds)
            if wrong := fault(status, seconds, said):
                found.faults.append(f"{bad.text}: {wrong}\n{said[-1500:]}")
    return found


def main() -> None:
    """Print the failures and a table."""
    for kind in sys.argv[1:2] or KINDS:
        first, last = map(int, sys.argv[2:4] or (0, KINDS[kind][1]))
        with tempfile.TemporaryDirectory() as folder:
            found = tally(kind, first, last, Path(folder))
        print(*found.faults, found, sep="\n", flush=True)


if __name__ == "__main__":
    main()
