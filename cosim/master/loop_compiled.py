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
SET, PREDICT, SLOPE, STEP, GET, MARK, SAVE, RESTORE, OFFER = 0, 1, 2, 3, 4, 5, 6, 7, 8
CALL, POINTER, REFERENCES, COUNT, BUFFER, FIRST, KIND, OWNER = 0, 1, 2, 3, 4, 5, 6, 7
SET_SLOPES, SLOPES, ORDERS, VALUES = 8, 9, 10, 11
REAL, WHOLE, TEXT, FLOAT, INT8, INT16, INT64, UINT8, UINT16, UINT32, UINT64 = 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10
INSTANCE, DO_STEP, GET_STATE, SET_STATE, FREE_STATE, SLOTS_FROM, SLOTS_TO = 0, 1, 2, 3, 4, 5, 6
ENTER_EVENTS, UPDATE, ENTER_STEPS, ANSWERS, OFFERS_FROM, OFFERS_TO = 7, 8, 9, 10, 11, 12
FLAGS, REACHED, UPDATED, NEXT, CHANGED, CALLED = 0, 1, 2, 3, 4, 5
EVENT_BYTE, END_BYTE, EARLY_BYTE = 0, 1, 2
IN_STEP, ENTERING, GIVING, UPDATING, LEAVING = 0, 1, 2, 3, 4
MOST_ROUNDS, LAST_BYTE, TOO_LONG, RESTLESS, DISCARD = 1000, 4095, 1 << 32, 1 << 33, 2
TICK, AT, USED, CODE, INDEX, CALLS = 0, 1, 2, 3, 4, 5
for _name, _value in list(globals().items()):
    assert _name.upper() != _name or _value == getattr(program, _name, _value), _name
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
call_1: Any = intrinsic(lambda typing, f, a: emit(I64))
call_2: Any = intrinsic(lambda typing, f, a, b: emit(I64, I64))
call_4: Any = intrinsic(lambda typing, f, a, b, c, d: emit(I64, I64, I64, I64))
call_5: Any = intrinsic(lambda typing, f, a, b, c, d, e: emit(I64, I64, I64, I64, I64))
call_7: Any = intrinsic(lambda typing, f, a, b, c, d, e, g, h: emit(I64, I64, I64, I64, I64, I64, I64))
call_step: Any = intrinsic(lambda typing, f, instance, time, step, keep, event, end, early, reached:
                           emit(I64, F64, F64, I32, I64, I64, I64, I64))


@njit(cache=True, error_model="numpy")
def read(buffers: Array, kind: int, a: int, k: int) -> Any:
    """The value k of the group that begins at word a, as a real number and as a whole one; not for texts."""
    if kind == REAL:
        return buffers.view(np.float64)[a + k], 0
    if kind == FLOAT:
        return np.float64(buffers.view(np.float32)[2 * a + k]), 0
    if kind == UINT64:
        return np.float64(buffers.view(np.uint64)[a + k]), buffers[a + k]
    whole = np.int64(0)
    if kind == WHOLE:
        whole = np.int64(buffers.view(np.int32)[2 * a + k])
    elif kind == UINT8:
        whole = np.int64(buffers.view(np.uint8)[8 * a + k])
    elif kind == INT64:
        whole = buffers[a + k]
    elif kind == INT8:
        whole = np.int64(buffers.view(np.int8)[8 * a + k])
    elif kind == INT16:
        whole = np.int64(buffers.view(np.int16)[4 * a + k])
    elif kind == UINT16:
        whole = np.int64(buffers.view(np.uint16)[4 * a + k])
    elif kind == UINT32:
        whole = np.int64(buffers.view(np.uint32)[2 * a + k])
    return np.float64(whole), whole


@njit(cache=True, error_model="numpy")
def write(buffers: Array, kind: int, a: int, k: int, number: float, whole: int) -> Any:
    """Write the value k of the group that begins at word a; whether it was another one. Not for texts."""
    if kind == REAL:
        differs = buffers.view(np.float64)[a + k] != number
        buffers.view(np.float64)[a + k] = number
        return differs
    if kind == FLOAT:
        small = np.float32(number)
        differs = buffers.view(np.float32)[2 * a + k] != small
        buffers.view(np.float32)[2 * a + k] = small
        return differs
    if kind in (INT64, UINT64):
        differs = buffers[a + k] != whole
        buffers[a + k] = whole
    elif kind in (WHOLE, UINT32):
        bits = buffers.view(np.int32)
        differs = bits[2 * a + k] != np.int32(whole)
        bits[2 * a + k] = np.int32(whole)
    elif kind in (INT16, UINT16):
        shorts = buffers.view(np.int16)
        differs = shorts[4 * a + k] != np.int16(whole)
        shorts[4 * a + k] = np.int16(whole)
    else:
        bytes_ = buffers.view(np.int8)
        differs = bytes_[8 * a + k] != np.int8(whole)
        bytes_[8 * a + k] = np.int8(whole)
    return differs


@njit(cache=True, error_model="numpy")
def take_in(groups: Array, g: int, where: Array, buffers: Array, signals: Array, exact: Array) -> None:
    """The values of the group g, of any type but texts, into the signals. A function of its own for rarer types: the
    kernel stays small, which is what makes it fast."""
    kind, a = groups[g, KIND], groups[g, FIRST]
    for p in range(a, a + groups[g, VALUES]):
        signals[where[p]], exact[where[p]] = read(buffers, kind, a, p - a)


@njit(cache=True, error_model="numpy")
def hand_out(groups: Array, g: int, where: Array, factor: Array, offset: Array, buffers: Array, signals: Array,
             exact: Array) -> Any:
    """The signals into the values of the group g, of any type but texts; whether any has changed."""
    kind, a, changed = groups[g, KIND], groups[g, FIRST], False
    for p in range(a, a + groups[g, VALUES]):
        s = where[p]
        changed |= write(buffers, kind, a, p - a, factor[p] * signals[s] + offset[p], exact[s])
    return changed


@njit(cache=True, error_model="numpy")
def in_event_mode(groups: Array, components: Array, events: Array, g: int, time: float) -> np.int64:
    """Event mode of the component g at `time` (s): inputs that have been offered, then discrete states; and back."""
    instance, place = components[g, INSTANCE], components[g, ANSWERS]
    flags, reached = events.view(np.uint8), events.view(np.float64)
    events[g, CALLED] = ENTERING
    status = np.int64(call_1(components[g, ENTER_EVENTS], instance))
    if events[g, CHANGED] != 0:
        events[g, CALLED] = GIVING
        for n in range(components[g, OFFERS_FROM], components[g, OFFERS_TO]):
            if status == 0 or status == 1:
                status = np.int64(call_5(groups[n, CALL], groups[n, POINTER], groups[n, REFERENCES], groups[n, COUNT],
                                         groups[n, BUFFER], groups[n, VALUES]))
        events[g, CHANGED] = 0
    for _ in range(MOST_ROUNDS):
        if status != 0 and status != 1:
            return status
        events[g, CALLED] = UPDATING
        events[g, UPDATED] = 0
        update = place + 8 * UPDATED
        status = np.int64(call_7(components[g, UPDATE], instance, update, update + 1, update + 2, update + 3,
                                 update + 4, place + 8 * NEXT))
        if status != 0 and status != 1:
            return status
        if flags[g, 8 * UPDATED + END_BYTE] != 0:
            flags[g, 8 * FLAGS + END_BYTE] = 1
            reached[g, REACHED] = time
            return np.int64(DISCARD)
        if flags[g, 8 * UPDATED] == 0:
            events[g, CALLED] = LEAVING
            status = np.int64(call_1(components[g, ENTER_STEPS], instance))
            if status == 0 or status == 1:
                events[g, CALLED] = IN_STEP
            return status
    return np.int64(RESTLESS)


@njit(cache=True, error_model="numpy")
def step_on(groups: Array, components: Array, events: Array, g: int, begun: float, end: float,
            keep: Any) -> np.int64:
    """What follows a step of the component g from `begun` to `end` (s) whose answers are not all false: the update of
    discrete states, and the rest of the step after an early return.

    Discard if the FMU ends the simulation: its answers tell when."""
    flags, reached = events.view(np.uint8), events.view(np.float64)
    place, rounds = components[g, ANSWERS], 0
    while True:
        if flags[g, 8 * FLAGS + END_BYTE] != 0:
            if flags[g, 8 * FLAGS + EARLY_BYTE] == 0:
                reached[g, REACHED] = end
            return np.int64(DISCARD)
        early = flags[g, 8 * FLAGS + EARLY_BYTE] != 0
        now = reached[g, REACHED] if early else end
        status = np.int64(0)
        if flags[g, 8 * FLAGS + EVENT_BYTE] != 0 and components[g, ENTER_EVENTS] != 0:
            events[g, FLAGS] = 0
            status = in_event_mode(groups, components, events, g, now)
        events[g, FLAGS] &= 1 << 8 * END_BYTE
        if (status != 0 and status != 1) or not early or now >= end - 1e-9 * (end - begun):
            return status
        rounds = 0 if now > begun else rounds + 1
        if rounds > MOST_ROUNDS:
            return np.int64(RESTLESS)
        begun = max(now, begun)
        status = np.int64(call_step(components[g, DO_STEP], components[g, INSTANCE], begun, end - begun, keep,
                                    place, place + END_BYTE, place + EARLY_BYTE, place + 8 * REACHED))
        if (status != 0 and status != 1) or events[g, FLAGS] == 0:
            return status


@njit(cache=True, error_model="numpy")
def kernel(ops: Array, groups: Array, components: Array, where: Array, factor: Array, offset: Array, buffers: Array,
           slopes: Array, signals: Array, exact: Array, before: Array, clock: Array, holder: Array, smooth: Array,
           texts: Array, text_place: int, states: Array, state_place: int, events: Array, offers: Array, strncpy: int,
           recorded: Array, rows: Array, times: Array, cursor: Array,
           first: int, count: int, start: float, step: float, decimate: int) -> np.int64:
    """Ticks first ... first + count - 1, of `step` from `start`; a row of the recorded signals after each tick whose
    number, counted from 1, `decimate` divides (0: none); a signal that is marked for later shows what it was before.
    Returns 0, or the status of the call that failed, which is any but OK and Warning; `cursor` tells where it is, see
    `program`."""
    reals, wholes, floats = buffers.view(np.float64), buffers.view(np.int32), buffers.view(np.float32)
    for tick in range(first, first + count):
        cursor[TICK] = tick
        t = start + tick * step
        for i in range(ops.shape[0]):
            if ops[i, 2] != 1 and tick % ops[i, 2] != ops[i, 3]:
                continue
            code, g = ops[i, 0], ops[i, 1]
            u = np.uint64(g)  # saves the look whether an index counts from the end
            cursor[AT], cursor[CODE], cursor[INDEX] = i, code, g
            cursor[CALLS] += 1
            status = np.int64(0)
            if code == STEP:
                if events[u, CHANGED] != 0:
                    status = in_event_mode(groups, components, events, g, t)
                if status == 0 or status == 1:
                    keep, place = np.int32(states[g] == 0), components[u, ANSWERS]  # not 0: it may be set back yet
                    status = np.int64(call_step(components[u, DO_STEP], components[u, INSTANCE], t, ops[i, 4] * step,
                                                keep, place, place + END_BYTE, place + EARLY_BYTE, place + 8 * REACHED))
                    if events[u, FLAGS] != 0 and (status == 0 or status == 1):
                        status = step_on(groups, components, events, g, t, t + ops[i, 4] * step, keep)
            elif code == GET:
                status = np.int64(call_5(groups[u, CALL], groups[u, POINTER], groups[u, REFERENCES], groups[u, COUNT],
                                         groups[u, BUFFER], groups[u, VALUES]))
                if status == 0 or status == 1:
                    kind, a = groups[u, KIND], groups[u, FIRST]
                    if kind == REAL:
                        for p in range(a, a + groups[u, VALUES]):
                            signals[where[p]] = reals[p]
                    elif kind == WHOLE:
                        for p in range(a, a + groups[u, VALUES]):
                            signals[where[p]] = exact[where[p]] = wholes[a + p]
                    elif kind != TEXT:
                        take_in(groups, g, where, buffers, signals, exact)
                    else:
                        for p in range(a, a + groups[u, VALUES]):
                            if buffers[p] == 0:  # counts as an empty text
                                texts[where[p], 0] = 0
                            else:
                                call_4(strncpy, text_place + where[p] * (LAST_BYTE + 1), buffers[p], LAST_BYTE + 1, 0)
                            if texts[where[p], LAST_BYTE] != 0:
                                status = np.int64(TOO_LONG)
            elif code <= SLOPE:
                kind, a = groups[u, KIND], groups[u, FIRST]
                if kind == WHOLE:
                    for p in range(a, a + groups[u, VALUES]):
                        wholes[a + p] = exact[where[p]]
                elif kind in (REAL, FLOAT):
                    reach = 0.0 if code == SLOPE else 0.5 * (ops[i, 4] * step)
                    for p in range(a, a + groups[u, VALUES]):
                        s = where[p]
                        value = signals[s]
                        if code != SET:
                            now, earlier = clock[holder[s], 0], clock[holder[s], 1]
                            slope = 0.0
                            if smooth[s] and now > earlier:
                                slope = (value - before[s]) / (now - earlier)
                                value = value + slope * (t + reach - now)
                            slopes[p] = factor[p] * slope
                        if kind == REAL:
                            reals[p] = factor[p] * value + offset[p]
                        else:
                            floats[a + p] = factor[p] * value + offset[p]
                elif kind != TEXT:  # a text input points at its source already
                    hand_out(groups, g, where, factor, offset, buffers, signals, exact)
                status = np.int64(call_5(groups[u, CALL], groups[u, POINTER], groups[u, REFERENCES], groups[u, COUNT],
                                         groups[u, BUFFER], groups[u, VALUES]))
                if code == SLOPE and (status == 0 or status == 1):
                    status = np.int64(call_5(groups[u, SET_SLOPES], groups[u, POINTER], groups[u, REFERENCES],
                                             groups[u, COUNT], groups[u, ORDERS], groups[u, SLOPES]))
            elif code == MARK:
                for s in range(components[u, SLOTS_FROM], components[u, SLOTS_TO]):
                    before[s] = signals[s]
                clock[g, 1] = clock[g, 0]
                clock[g, 0] = t + ops[i, 4] * step
            elif code == SAVE:
                if states[g] != 0:
                    status = np.int64(call_2(components[u, FREE_STATE], components[u, INSTANCE], state_place + 8 * g))
                    states[g] = 0
                if status == 0 or status == 1:
                    status = np.int64(call_2(components[u, GET_STATE], components[u, INSTANCE], state_place + 8 * g))
            elif code == RESTORE:
                status = np.int64(call_2(components[u, SET_STATE], components[u, INSTANCE], states[g]))
                events[u, CHANGED] = offers[g]  # the FMU has the inputs of that time
            elif groups[u, KIND] == TEXT or hand_out(groups, g, where, factor, offset, buffers, signals, exact):
                # OFFER
                events[groups[u, OWNER], CHANGED] = 1
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
        self.tables = (w.groups, w.components, w.where, w.factor, w.offset, w.buffers, w.slopes, w.signals, w.exact,
                       w.before, w.clock, w.holder, w.smooth, w.texts, w.texts.ctypes.data, w.states,
                       w.states.ctypes.data, w.events, w.offers, strncpy_address(), w.recorded)
        nothing = program.program(()), np.empty((0, 0)), np.empty(0), program.cursor()
        self.run(*nothing, 0, 0, 0.0, 0.0, 0)  # compiles now, and not within the first tick

    def run(self, ops: Array, rows: Array, times: Array, cursor: Array,
            first: int, count: int, start: float, step: float, decimate: int) -> int:
        """Carry out `ops`; see `kernel`."""
        return int(kernel(ops, *self.tables, rows, times, cursor, first, count, float(start), float(step), decimate))
