"""The tick loop, compiled by numba: carries out a program (see `program`) on a wiring's arrays.

FMU functions are called by their addresses. The machine code is kept on disk beside this file (or in
numba's folder for the user, where that is read-only), so only the first run after a change compiles.
The interpreter's lock stays held, as FMUs made with pythonfmu expect of a calling Python thread.
"""
from typing import Any

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic

from . import program
from .wiring import LONGEST_TEXT, Wiring, strncpy_address

# Literal, because numba's cache looks for changes in this file only.
SET, PREDICT, SLOPE, STEP, GET, MARK, SAVE, RESTORE = 0, 1, 2, 3, 4, 5, 6, 7
CALL, POINTER, REFERENCES, COUNT, BUFFER, FIRST, KIND, OWNER = 0, 1, 2, 3, 4, 5, 6, 7
SET_SLOPES, SLOPES, ORDERS = 8, 9, 10
REAL, WHOLE, TEXT = 0, 1, 2
INSTANCE, DO_STEP, GET_STATE, SET_STATE, FREE_STATE, SLOTS_FROM, SLOTS_TO = 0, 1, 2, 3, 4, 5, 6
LAST_BYTE, TOO_LONG = 4095, 1 << 32
TICK, AT, USED, CODE, INDEX, CALLS = 0, 1, 2, 3, 4, 5
for _name in ("SET", "PREDICT", "SLOPE", "STEP", "GET", "MARK", "SAVE", "RESTORE", "CALL", "POINTER", "REFERENCES",
              "COUNT", "BUFFER", "FIRST", "KIND", "OWNER", "SET_SLOPES", "SLOPES", "ORDERS", "REAL", "WHOLE", "TEXT",
              "INSTANCE", "DO_STEP", "GET_STATE", "SET_STATE", "FREE_STATE", "SLOTS_FROM", "SLOTS_TO",
              "TOO_LONG", "TICK", "AT", "CODE", "INDEX", "CALLS"):
    assert globals()[_name] == getattr(program, _name), _name
assert (LAST_BYTE, USED) == (LONGEST_TEXT - 1, program.ROWS)


I32, I64, F64 = ir.IntType(32), ir.IntType(64), ir.DoubleType()
Array = np.ndarray  # the annotations of `kernel` are for readers and mypy: numba takes the types of the call
WIDE: dict[ir.Type, Any] = {I32: types.int32, I64: types.int64, F64: types.float64}


def emit(*parameters: ir.Type) -> Any:
    """What numba wants to know to call `int32 f(parameters)` at an address: types, and code."""
    def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        pointer = ir.FunctionType(I32, parameters).as_pointer()
        return builder.call(builder.inttoptr(arguments[0], pointer), arguments[1:])
    return types.int32(types.int64, *(WIDE[p] for p in parameters)), code


# (address, ...): pointers and sizes are 64 bits wide.
call_2: Any = intrinsic(lambda typing, f, a, b: emit(I64, I64))
call_4: Any = intrinsic(lambda typing, f, a, b, c, d: emit(I64, I64, I64, I64))
call_5: Any = intrinsic(lambda typing, f, a, b, c, d, e: emit(I64, I64, I64, I64, I64))
call_step: Any = intrinsic(lambda typing, f, instance, time, step, keep: emit(I64, F64, F64, I32))


@njit(cache=True, error_model="numpy")
def kernel(ops: Array, groups: Array, components: Array, where: Array, factor: Array, offset: Array, reals: Array,
           wholes: Array, pointers: Array, slopes: Array, signals: Array, before: Array, clock: Array, holder: Array,
           smooth: Array, texts: Array, text_place: int, states: Array, state_place: int, strncpy: int,
           recorded: Array, rows: Array, times: Array, cursor: Array,
           first: int, count: int, start: float, step: float, decimate: int) -> np.int64:
    """Ticks first ... first + count - 1, of `step` from `start`; a row of the recorded signals after each tick whose
    number, counted from 1, `decimate` divides (0: none); a signal that is marked for later shows what it was before.
    Returns 0, or the status of the call that failed, which is any but OK and Warning; `cursor` tells where it is, see
    `program`."""
    for tick in range(first, first + count):
        cursor[TICK] = tick
        t = start + tick * step
        for i in range(ops.shape[0]):
            if ops[i, 2] != 1 and tick % ops[i, 2] != ops[i, 3]:
                continue
            code, g = ops[i, 0], ops[i, 1]
            cursor[AT], cursor[CODE], cursor[INDEX] = i, code, g
            cursor[CALLS] += 1
            status = np.int64(0)
            if code == STEP:
                status = call_step(components[g, DO_STEP], components[g, INSTANCE], t, ops[i, 4] * step,
                                   np.int32(states[g] == 0))  # not 0: it may be set back yet
            elif code == GET:
                status = call_4(groups[g, CALL], groups[g, POINTER], groups[g, REFERENCES], groups[g, COUNT],
                                groups[g, BUFFER])
                if status == 0 or status == 1:
                    kind, a = groups[g, KIND], groups[g, FIRST]
                    if kind == REAL:
                        for p in range(a, a + groups[g, COUNT]):
                            signals[where[p]] = reals[p]
                    elif kind == WHOLE:
                        for p in range(a, a + groups[g, COUNT]):
                            signals[where[p]] = wholes[p]
                    else:
                        for p in range(a, a + groups[g, COUNT]):
                            if pointers[p] == 0:  # counts as an empty text
                                texts[where[p], 0] = 0
                            else:
                                call_4(strncpy, text_place + where[p] * (LAST_BYTE + 1), pointers[p], LAST_BYTE + 1, 0)
                            if texts[where[p], LAST_BYTE] != 0:
                                status = np.int64(TOO_LONG)
            elif code <= SLOPE:
                kind, a = groups[g, KIND], groups[g, FIRST]
                if kind == WHOLE:
                    for p in range(a, a + groups[g, COUNT]):
                        wholes[p] = int(signals[where[p]])
                elif kind == REAL:
                    reach = 0.0 if code == SLOPE else 0.5 * (ops[i, 4] * step)
                    for p in range(a, a + groups[g, COUNT]):
                        s = where[p]
                        value = signals[s]
                        if code != SET:
                            now, earlier = clock[holder[s], 0], clock[holder[s], 1]
                            slope = 0.0
                            if smooth[s] and now > earlier:
                                slope = (value - before[s]) / (now - earlier)
                                value = value + slope * (t + reach - now)
                            slopes[p] = factor[p] * slope
                        reals[p] = factor[p] * value + offset[p]
                status = call_4(groups[g, CALL], groups[g, POINTER], groups[g, REFERENCES], groups[g, COUNT],
                                groups[g, BUFFER])
                if code == SLOPE and (status == 0 or status == 1):
                    status = call_5(groups[g, SET_SLOPES], groups[g, POINTER], groups[g, REFERENCES],
                                    groups[g, COUNT], groups[g, ORDERS], groups[g, SLOPES])
            elif code == MARK:
                for s in range(components[g, SLOTS_FROM], components[g, SLOTS_TO]):
                    before[s] = signals[s]
                clock[g, 1] = clock[g, 0]
                clock[g, 0] = t + ops[i, 4] * step
            elif code == SAVE:
                if states[g] != 0:
                    status = call_2(components[g, FREE_STATE], components[g, INSTANCE], state_place + 8 * g)
                    states[g] = 0
                if status == 0 or status == 1:
                    status = call_2(components[g, GET_STATE], components[g, INSTANCE], state_place + 8 * g)
            elif code == RESTORE:
                status = call_2(components[g, SET_STATE], components[g, INSTANCE], states[g])
            if status != 0 and status != 1:
                return status
        if decimate > 0 and (tick + 1) % decimate == 0:
            used = cursor[USED]
            now = start + (tick + 1) * step
            for c in range(recorded.shape[0]):
                s = recorded[c]
                due = clock[holder[s], 0] <= now + 0.5 * step
                rows[used, c] = signals[s] if due else before[s]
            times[used] = now
            cursor[USED] = used + 1
    return np.int64(0)


class Loop:
    """`kernel` on one wiring."""

    def __init__(self, wiring: Wiring):
        w = self.wiring = wiring
        self.tables = (w.groups, w.components, w.where, w.factor, w.offset, w.reals, w.wholes, w.pointers, w.slopes,
                       w.signals, w.before, w.clock, w.holder, w.smooth, w.texts, w.texts.ctypes.data, w.states,
                       w.states.ctypes.data, strncpy_address(), w.recorded)
        nothing = program.program(()), np.empty((0, 0)), np.empty(0), program.cursor()
        self.run(*nothing, 0, 0, 0.0, 0.0, 0)  # compiles now, and not within the first tick

    def run(self, ops: Array, rows: Array, times: Array, cursor: Array,
            first: int, count: int, start: float, step: float, decimate: int) -> int:
        """Carry out `ops`; see `kernel`."""
        return int(kernel(ops, *self.tables, rows, times, cursor, first, count, float(start), float(step), decimate))
