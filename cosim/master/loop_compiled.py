"""The tick loop in C (loop.c, see `compile_loop`): carries out programs (`program`) on a wiring's arrays.

The interpreter's lock stays held during a call, as FMUs made with pythonfmu expect of a calling Python thread.
"""
import ctypes
import subprocess
from functools import cache
from typing import Any

import numpy as np

from . import compile_loop
from .notes import note
from .wiring import Wiring

ARRAYS = ("groups", "components", "where", "factor", "offset", "buffers", "slopes", "signals", "exact", "before",
          "clock", "holder", "smooth", "texts", "states", "events", "offers", "recorded")  # Wiring in loop.c
WORD, REAL, POINTER = ctypes.c_int64, ctypes.c_double, ctypes.c_void_p
start_of: Any = (ctypes.c_char * 0).from_buffer  # of an array, in a third of the time of `array.ctypes`


@cache
def library() -> ctypes.PyDLL | None:
    """The compiled loop; None where there is none, and no compiler. A note says it where that is for other reasons."""
    try:
        path = compile_loop.library()
        found = ctypes.PyDLL(str(path)) if path else None
    except (OSError, subprocess.CalledProcessError) as error:
        said = " ".join(getattr(error, "stderr", b"").decode(errors="replace").split()) or str(error)
        note(f"The tick loop cannot be compiled or loaded, so ticks take the slower one in Python: {said}")
        return None
    if found is not None:
        found.run.argtypes = [POINTER, POINTER, WORD, POINTER, POINTER, POINTER, WORD, WORD, WORD, REAL, REAL, WORD]
        found.run.restype = WORD
    return found


class Loop:
    """`run` in loop.c on one wiring."""

    def __init__(self, wiring: Wiring, library: ctypes.PyDLL):
        self.function = library.run
        self.arrays = [getattr(wiring, name) for name in ARRAYS]
        assert all(a.flags.c_contiguous for a in self.arrays)
        self.tables = (POINTER * len(ARRAYS))(*(a.ctypes.data for a in self.arrays))

    def run(self, ops: np.ndarray, rows: np.ndarray, times: np.ndarray, cursor: np.ndarray,
            first: int, count: int, start: float, step: float, decimate: int) -> int:
        """Carry out `ops` on ticks first ... first + count - 1, of `step` from `start` (s); a row of the recorded
        signals and its time after each tick whose number, counted from 1, `decimate` divides (0: none). A signal that
        is marked for later shows what it was before.

        Returns 0, or the status of the call that failed, which is any but OK and Warning; `cursor` tells where it is at
        any time, see `program`.
        """
        status: int = self.function(self.tables, start_of(ops), len(ops), start_of(rows), start_of(times),
                                    start_of(cursor), rows.shape[1], first, count, start, step, decimate)
        return status
