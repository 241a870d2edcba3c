"""`look_up` compiled by numba, see there; the machine code is kept on disk as that of `loop_compiled`."""
from typing import Any

import numpy as np
from numba import carray, cfunc, njit
from numba import types as _types
from numba.extending import intrinsic

from . import program
from .table import EARLY as _EARLY
from .table import look_up as _look_up

types: Any = _types  # it has no annotations
EARLY, TICK = 1e-9, 0  # literal, see `loop_compiled`
assert (EARLY, TICK) == (_EARLY, program.TICK)
look_up = njit(cache=True, error_model="numpy")(_look_up)
SIGNATURE = types.int32(types.CPointer(types.int64), types.CPointer(types.uint32), types.uint64,
                        types.CPointer(types.float64), types.uint64)


def at(kind: Any) -> Any:
    """An intrinsic that takes an address for a pointer to `kind`."""
    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.inttoptr(arguments[0], context.get_value_type(signature.return_type))

    @intrinsic
    def pointer(typing: Any, address: Any) -> Any:
        return types.CPointer(kind)(types.int64), code
    return pointer


whole_at, real_at, flag_at = at(types.int64), at(types.float64), at(types.boolean)


@njit(cache=True, error_model="numpy")
def values_now(numbers: Any, columns: Any, values: Any) -> None:
    """What the columns have at the time of the tick."""
    tick, span = carray(whole_at(numbers[0]), 1)[TICK], carray(real_at(numbers[1]), 2)
    times, held = carray(real_at(numbers[2]), numbers[5]), carray(flag_at(numbers[4]), numbers[6])
    rows = carray(real_at(numbers[3]), (numbers[5], numbers[6]))
    look_up(times, rows, held, span[0] + tick * span[1], EARLY * span[1], columns, values)


@cfunc(SIGNATURE, cache=True)
def real(numbers: Any, columns: Any, count: Any, buffer: Any, _: Any) -> Any:
    """As the loops call fmi2GetReal: doubles into `buffer`."""
    values_now(numbers, carray(columns, count), carray(buffer, count))
    return 0


@cfunc(SIGNATURE, cache=True)
def whole(numbers: Any, columns: Any, count: Any, buffer: Any, _: Any) -> Any:
    """The same with 64-bit integers."""
    values = np.empty(count)
    values_now(numbers, carray(columns, count), values)
    wholes = carray(buffer, count).view(np.int64)
    for i in range(count):
        wholes[i] = np.int64(values[i])
    return 0
