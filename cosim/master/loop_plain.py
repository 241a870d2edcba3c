"""The tick loop in plain Python: the reference for `loop_compiled`, equal to the last bit, and its fallback."""
import ctypes
from typing import Any

import numpy as np

from . import program as P
from .wiring import LONGEST_TEXT, Wiring, strncpy_address

POINTER, SIZE, REAL, WHOLE = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_double, ctypes.c_int
TRANSFER = ctypes.CFUNCTYPE(WHOLE, POINTER, POINTER, SIZE, POINTER)
TRANSFER_SLOPES = ctypes.CFUNCTYPE(WHOLE, POINTER, POINTER, SIZE, POINTER, POINTER)
DO_STEP = ctypes.CFUNCTYPE(WHOLE, POINTER, REAL, REAL, WHOLE)
STATE = ctypes.CFUNCTYPE(WHOLE, POINTER, POINTER)
COPY = ctypes.CFUNCTYPE(POINTER, POINTER, POINTER, SIZE)
DONE = (0, 1)  # OK and Warning


class Bound:
    """A group's row as callable function, arguments and views of its shares of the vectors."""

    def __init__(self, wiring: Wiring, row: np.ndarray):
        call, instance, references, count, buffer, first, self.kind, _, slopes_call, slopes, orders = row.tolist()
        mine = slice(first, first + count)
        self.call, self.arguments = TRANSFER(call), (instance, references, count, buffer)
        self.where, self.factor, self.offset = wiring.where[mine], wiring.factor[mine], wiring.offset[mine]
        self.values: np.ndarray = (wiring.reals, wiring.wholes, wiring.pointers)[self.kind][mine]
        self.slopes = wiring.slopes[mine]
        self.slopes_call = TRANSFER_SLOPES(slopes_call) if slopes_call else None
        self.slopes_arguments = (instance, references, count, orders, slopes)


class Loop:
    """Carries out programs on one wiring; see `loop_compiled.kernel` for the meaning of the arguments."""

    def __init__(self, wiring: Wiring):
        self.wiring = wiring
        self.groups = [Bound(wiring, row) for row in wiring.groups]
        self.components: list[dict[int, Any]] = [
            {P.INSTANCE: row[P.INSTANCE], P.DO_STEP: DO_STEP(row[P.DO_STEP]),
             **{k: STATE(row[k]) for k in (P.GET_STATE, P.SET_STATE, P.FREE_STATE) if row[k]}}
            for row in wiring.components.tolist()]
        self.copy = COPY(strncpy_address())
        self.actions = {P.SET: self.set, P.PREDICT: self.predict, P.SLOPE: self.predict, P.STEP: self.step,
                        P.GET: self.get, P.MARK: self.mark, P.SAVE: self.save, P.RESTORE: self.restore}

    def run(self, ops: np.ndarray, rows: np.ndarray, times: np.ndarray, cursor: np.ndarray,
            first: int, count: int, start: float, step: float, decimate: int) -> int:
        """Carry out `ops`; see `loop_compiled.kernel`."""
        w = self.wiring
        listed = [(i, self.actions[code], code, *rest) for i, (code, *rest) in enumerate(ops.tolist())]
        for tick in range(first, first + count):
            cursor[P.TICK] = tick
            t = start + tick * step
            for i, action, code, index, period, phase, reach in listed:
                if period != 1 and tick % period != phase:
                    continue
                cursor[P.AT], cursor[P.CODE], cursor[P.INDEX] = i, code, index
                cursor[P.CALLS] += 1
                status = action(code, index, t, reach * step, step)
                if status not in DONE:
                    return int(status)
            if decimate > 0 and (tick + 1) % decimate == 0:
                now = start + (tick + 1) * step
                due = w.clock[w.holder[w.recorded], 0] <= now + 0.5 * step
                rows[cursor[P.ROWS]] = np.where(due, w.signals[w.recorded], w.before[w.recorded])
                times[cursor[P.ROWS]] = now
                cursor[P.ROWS] += 1
        return 0

    def set(self, code: int, index: int, t: float, reach: float, step: float) -> int:
        """Give a group its inputs, as the signals are now."""
        group = self.groups[index]
        if group.kind != P.TEXT:  # a text input points at its source already
            group.values[:] = group.factor * self.wiring.signals[group.where] + group.offset
        return int(group.call(*group.arguments))

    def predict(self, code: int, index: int, t: float, reach: float, step: float) -> int:
        """Give a group its inputs by their last slope (PREDICT), or with it (SLOPE)."""
        w, group = self.wiring, self.groups[index]
        if group.kind != P.REAL:
            return self.set(code, index, t, reach, step)
        ahead = 0.0 if code == P.SLOPE else 0.5 * reach
        for i, s in enumerate(group.where):
            value, slope = w.signals[s], 0.0
            now, earlier = w.clock[w.holder[s]]
            if w.smooth[s] and now > earlier:
                slope = (value - w.before[s]) / (now - earlier)
                value = value + slope * (t + ahead - now)
            group.slopes[i] = group.factor[i] * slope
            group.values[i] = group.factor[i] * value + group.offset[i]
        status = group.call(*group.arguments)
        if code == P.SLOPE and status in DONE:
            assert group.slopes_call is not None
            status = group.slopes_call(*group.slopes_arguments)
        return int(status)

    def step(self, code: int, index: int, t: float, reach: float, step: float) -> int:
        """One fmi2DoStep of a component."""
        component, not_back = self.components[index], self.wiring.states[index] == 0
        return int(component[P.DO_STEP](component[P.INSTANCE], t, reach, int(not_back)))

    def get(self, code: int, index: int, t: float, reach: float, step: float) -> int:
        """Read a group's variables into the signals; TOO_LONG for a text that does not fit."""
        w, group = self.wiring, self.groups[index]
        status = int(group.call(*group.arguments))
        if status not in DONE:
            return status
        if group.kind != P.TEXT:
            w.signals[group.where] = group.values
            return status
        for place, text in zip(group.where.tolist(), group.values.tolist()):
            if text:
                self.copy(w.texts.ctypes.data + place * LONGEST_TEXT, text, LONGEST_TEXT)
            else:  # a null pointer counts as an empty text
                w.texts[place, 0] = 0
            if w.texts[place, -1]:
                status = P.TOO_LONG
        return status

    def mark(self, code: int, index: int, t: float, reach: float, step: float) -> int:
        """Remember a component's signals and their time as the last ones."""
        w = self.wiring
        mine = slice(*w.components[index, P.SLOTS_FROM:P.SLOTS_TO + 1])
        w.before[mine] = w.signals[mine]
        w.clock[index] = t + reach, w.clock[index, 0]
        return 0

    def save(self, code: int, index: int, t: float, reach: float, step: float) -> int:
        """fmi2GetFMUstate, in place of the state saved before."""
        w, component = self.wiring, self.components[index]
        place = w.states.ctypes.data + 8 * index
        status = 0
        if w.states[index]:
            status = int(component[P.FREE_STATE](component[P.INSTANCE], place))
            w.states[index] = 0
        return int(component[P.GET_STATE](component[P.INSTANCE], place)) if status in DONE else status

    def restore(self, code: int, index: int, t: float, reach: float, step: float) -> int:
        """fmi2SetFMUstate of the saved state."""
        component = self.components[index]
        return int(component[P.SET_STATE](component[P.INSTANCE], int(self.wiring.states[index])))
