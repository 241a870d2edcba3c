"""What a table has at a time, as a C function that the tick loops call like an FMU's fmi2GetReal.

The function is given the address of a `Place`'s numbers instead of an instance, and columns instead of value
references. The time is that of the loop's tick. The functions are in loop.c; where that is not compiled, in Python.
"""
import ctypes
from typing import Any

import numpy as np

from . import loop_compiled
from . import program as P
from .table import Inputs, look_up

SIGNATURE = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p,
                             ctypes.c_size_t)


class Place:
    """Addresses and sizes for the C function, in `numbers`: the loop's cursor and span, times, rows, held; rows,
    columns."""

    def __init__(self, inputs: Inputs, cursor: np.ndarray, span: np.ndarray):
        self.inputs, self.cursor, self.span = inputs, cursor, span
        self.kept = inputs.times, inputs.rows, inputs.held
        addresses = [a.ctypes.data for a in (cursor, span, *self.kept)]
        self.numbers = np.array([*addresses, *inputs.rows.shape], np.int64)
        library = loop_compiled.library()
        self.functions = ([library.look_up_reals, library.look_up_wholes] if library is not None
                          else self.interpreted())

    @property
    def pointer(self) -> int:
        """What the C function is given."""
        return int(self.numbers.ctypes.data)

    def address(self, whole: bool) -> int:
        """The C function, which writes doubles, or 64-bit integers if `whole`."""
        return int(ctypes.cast(self.functions[whole], ctypes.c_void_p).value or 0)

    def interpreted(self) -> list[Any]:
        """The C functions in Python."""
        def made(whole: bool) -> Any:
            def function(_: int, columns: int, count: int, buffer: int, __: int) -> int:
                start, step = self.span.tolist()
                values = np.empty(count)
                look_up(*self.kept, start + int(self.cursor[P.TICK]) * step, P.EARLY * step,
                        np.ctypeslib.as_array(ctypes.cast(columns, ctypes.POINTER(ctypes.c_uint32)), (count,)), values)
                ctypes.memmove(buffer, (values.astype(np.int64) if whole else values).ctypes.data, 8 * count)
                return 0
            return SIGNATURE(function)
        return [made(False), made(True)]
