"""Signals that end the program, as exceptions: what is open is closed, and temporary files go.

An exception can get lost, since Python swallows those that are raised in some of its callbacks, for example those of
imports. Therefore an alarm follows: if nothing is being closed when it comes, the exception is raised again. Python's
report of the lost one is left out.
"""
import atexit
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager

from ..master.interruptions import ASKING, HELD

ENDING = (KeyboardInterrupt, SystemExit)
AGAIN_S = 0.2
PATIENCE_S = 2.0


@contextmanager
def ending() -> Iterator[None]:
    """Ctrl-C as KeyboardInterrupt, SIGTERM and SIGHUP as SystemExit with 128 + their number. Once one has come, and
    after the context, such signals do nothing more."""
    taken = [number for number in ASKING if signal.getsignal(number) != signal.SIG_IGN]  # nohup ignores SIGHUP
    for number in taken:
        signal.signal(number, end)
    usual = sys.unraisablehook
    sys.unraisablehook = lambda lost: None if isinstance(lost.exc_value, ENDING) else usual(lost)
    try:
        yield
    finally:
        for number in taken:
            signal.signal(number, signal.SIG_IGN)
        if hasattr(signal, "setitimer"):
            signal.setitimer(signal.ITIMER_REAL, 0)


def end(number: int, _: object = None) -> None:
    """End the program because of the signal `number`, unless that is under way."""
    if hasattr(signal, "setitimer"):
        signal.signal(signal.SIGALRM, lambda *_: end(number))
        signal.setitimer(signal.ITIMER_REAL, AGAIN_S)
    if HELD:
        HELD[0].append(number)
    elif not unwinding():
        raise KeyboardInterrupt if number == signal.SIGINT else SystemExit(128 + number)


@contextmanager
def ended_in_any_case() -> Iterator[None]:
    """Around calls of FMUs in this process: a signal that asks for an end also ends the program, PATIENCE_S later, if
    a call does not come back. Temporary folders go."""
    heard, told = os.pipe()
    os.set_blocking(told, False)
    over = threading.Event()

    def listen() -> None:
        while word := os.read(heard, 1):
            if word[0] in ASKING and not over.wait(PATIENCE_S):
                print("ahv: Interrupted in a call of an FMU that does not come back.", file=sys.stderr, flush=True)
                atexit._run_exitfuncs()
                os._exit(128 + word[0])
        os.close(heard)

    threading.Thread(target=listen, daemon=True).start()
    before = signal.set_wakeup_fd(told, warn_on_full_buffer=False)
    try:
        yield
    finally:
        over.set()
        signal.set_wakeup_fd(before)
        os.close(told)


def unwinding() -> bool:
    """Whether an exception that ends the program is being handled: it runs through the blocks that close things."""
    error = sys.exc_info()[1]
    while error is not None:
        if isinstance(error, ENDING):
            return True
        error = error.__context__
    return False
