"""Signals that ask for an end, held while something must not be torn: an FMU's call, the writing of results."""
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

ASKING = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
LEFT = (signal.SIG_IGN, None)  # None: not set from Python
HELD: list[list[int]] = []  # the outermost block's list, if there is one


@contextmanager
def interruptions() -> Iterator[list[int]]:
    """Ctrl-C, SIGTERM and SIGHUP as entries of a list, instead of what they would do. Blocks within this one get the
    same list. A signal that the program ignores stays ignored. In threads other than the main one nothing is held.

    No FMU is torn out of a call in this way; a Python FMU would take an exception for its own failure.
    """
    if threading.current_thread() is not threading.main_thread():
        yield []
        return
    if HELD:
        yield HELD[0]
        return
    caught: list[int] = []
    previous = {number: handler for number in ASKING if (handler := signal.getsignal(number)) not in LEFT}
    HELD.append(caught)
    try:
        for number in previous:
            signal.signal(number, lambda number, _: caught.append(number))
        yield caught
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)
        HELD.clear()
