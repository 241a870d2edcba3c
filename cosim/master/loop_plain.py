"""The tick loop in plain Python: the reference for `loop_compiled`, equal to the last bit, and its fallback."""
import ctypes
from typing import Any

import numpy as np

from . import program as P
from .wiring import Wiring

POINTER, SIZE, REAL, WHOLE = ctypes.c_void_p, ctypes.c_size_t, ctypes.c_double, ctypes.c_int
TRANSFER = ctypes.CFUNCTYPE(WHOLE, POINTER, POINTER, SIZE, POINTER, SIZE)
TRANSFER_SLOPES = ctypes.CFUNCTYPE(WHOLE, POINTER, POINTER, SIZE, POINTER, POINTER)
DO_STEP = ctypes.CFUNCTYPE(WHOLE, POINTER, REAL, REAL, WHOLE, *[POINTER] * 4)
MODE = ctypes.CFUNCTYPE(WHOLE, POINTER)
UPDATE = ctypes.CFUNCTYPE(WHOLE, *[POINTER] * 7)
STATE = ctypes.CFUNCTYPE(WHOLE, POINTER, POINTER)
DONE = (P.OK, P.WARNING)


class Bound:
    """A group's row as callable function, arguments and views of its shares of the vectors."""

    def __init__(self, wiring: Wiring, row: np.ndarray):
        (call, instance, references, count, buffer, first, self.kind, self.owner, slopes_call, slopes, orders,
         values) = row.tolist()
        mine = slice(first, first + values)
        self.call, self.arguments = TRANSFER(call), (instance, references, count, buffer, values)
        self.where, self.factor, self.offset = wiring.where[mine], wiring.factor[mine], wiring.offset[mine]
        self.values: np.ndarray = wiring.buffers[mine].view(P.DTYPES[self.kind])[:values]
        self.slopes = wiring.slopes[mine]
        self.slopes_call = TRANSFER_SLOPES(slopes_call) if slopes_call else None
        self.slopes_arguments = (instance, references, count, orders, slopes)


class Loop:
    """Carries out programs on one wiring; see `loop_compiled`."""

    def __init__(self, wiring: Wiring):
        self.wiring = wiring
        self.groups = [Bound(wiring, row) for row in wiring.groups]
        self.components: list[dict[int, Any]] = [
            {P.INSTANCE: row[P.INSTANCE], P.DO_STEP: DO_STEP(row[P.DO_STEP]), P.ANSWERS: row[P.ANSWERS],
             **{k: STATE(row[k]) for k in (P.GET_STATE, P.SET_STATE, P.FREE_STATE) if row[k]},
             **{k: kind(row[k]) for k, kind in ((P.ENTER_EVENTS, MODE), (P.UPDATE, UPDATE), (P.ENTER_STEPS, MODE))
                if row[k]}}
            for row in wiring.components.tolist()]
        self.actions = {P.SET: self.set, P.PREDICT: self.predict, P.SLOPE: self.predict, P.STEP: self.step,
                        P.GET: self.get, P.MARK: self.mark, P.SAVE: self.save, P.RESTORE: self.restore,
                        P.OFFER: self.offer}

    def run(self, ops: np.ndarray, rows: np.ndarray, times: np.ndarray, cursor: np.ndarray,
            first: int, count: int, start: float, step: float, decimate: int) -> int:
        """Carry out `ops`; see `loop_compiled.Loop.run`."""
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
            group.values[:] = self.given(group)
        return int(group.call(*group.arguments))

    def given(self, group: Bound) -> np.ndarray:
        """What a group of inputs is to be given, as the signals are now; not of texts."""
        w = self.wiring
        if group.kind in (P.REAL, P.FLOAT):
            values: np.ndarray = group.factor * w.signals[group.where] + group.offset
        else:
            values = w.exact[group.where]
        return values.astype(group.values.dtype)

    def offer(self, code: int, index: int, t: float, reach: float, step: float) -> int:
        """Look whether a group's inputs have changed: the component is given them at its next step."""
        group = self.groups[index]
        if group.kind == P.TEXT:
            self.wiring.events[group.owner, P.CHANGED] = 1
            return 0
        given = self.given(group)
        if (given != group.values).any():
            self.wiring.events[group.owner, P.CHANGED] = 1
        group.values[:] = given
        return 0

    def predict(self, code: int, index: int, t: float, reach: float, step: float) -> int:
        """Give a group its inputs by their last slope (PREDICT), or with it (SLOPE)."""
        w, group = self.wiring, self.groups[index]
        if group.kind not in (P.REAL, P.FLOAT):
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
        """One step of a component, and what follows it."""
        events, status = self.wiring.events[index], 0
        if events[P.CHANGED]:
            status = self.in_event_mode(index, t)
        if status in DONE:
            status = self.do_step(index, t, reach)
            if events[P.FLAGS] and status in DONE:
                return self.step_on(index, t, t + reach)
        return status

    def do_step(self, index: int, t: float, reach: float) -> int:
        """One call of fmi2DoStep or fmi3DoStep."""
        component, keep = self.components[index], int(self.wiring.states[index] == 0)
        place = component[P.ANSWERS]
        return int(component[P.DO_STEP](component[P.INSTANCE], t, reach, keep, place, place + P.END_BYTE,
                                        place + P.EARLY_BYTE, place + 8 * P.REACHED))

    def in_event_mode(self, index: int, time: float) -> int:
        """See `in_event_mode` in loop.c."""
        component, events, row = self.components[index], self.wiring.events[index], self.wiring.components[index]
        instance, place, flags = component[P.INSTANCE], component[P.ANSWERS], events.view(np.uint8)
        events[P.CALLED] = P.ENTERING
        status = int(component[P.ENTER_EVENTS](instance))
        if events[P.CHANGED]:
            events[P.CALLED] = P.GIVING
            for group in self.groups[row[P.OFFERS_FROM]:row[P.OFFERS_TO]]:
                status = int(group.call(*group.arguments)) if status in DONE else status
            events[P.CHANGED] = 0
        update = place + 8 * P.UPDATED
        for _ in range(P.MOST_ROUNDS):
            if status not in DONE:
                return status
            events[P.CALLED], events[P.UPDATED] = P.UPDATING, 0
            status = int(component[P.UPDATE](instance, *range(update, update + 5), place + 8 * P.NEXT))
            if status not in DONE:
                return status
            if flags[8 * P.UPDATED + P.END_BYTE]:
                flags[8 * P.FLAGS + P.END_BYTE] = 1
                events.view(float)[P.REACHED] = time
                return P.DISCARD
            if not flags[8 * P.UPDATED]:
                events[P.CALLED] = P.LEAVING
                status = int(component[P.ENTER_STEPS](instance))
                events[P.CALLED] = P.IN_STEP if status in DONE else P.LEAVING
                return status
        return P.RESTLESS

    def step_on(self, index: int, begun: float, end: float) -> int:
        """See `step_on` in loop.c."""
        events, rounds = self.wiring.events[index], 0
        flags, reached = events.view(np.uint8), events.view(float)
        while True:
            early = flags[8 * P.FLAGS + P.EARLY_BYTE] != 0
            if flags[8 * P.FLAGS + P.END_BYTE]:
                reached[P.REACHED] = reached[P.REACHED] if early else end
                return P.DISCARD
            now, status = float(reached[P.REACHED]) if early else end, 0
            if flags[8 * P.FLAGS + P.EVENT_BYTE] and P.ENTER_EVENTS in self.components[index]:
                events[P.FLAGS] = 0
                status = self.in_event_mode(index, now)
            events[P.FLAGS] &= 1 << 8 * P.END_BYTE
            if status not in DONE or not early or now >= end - P.EARLY * (end - begun):
                return status
            rounds = 0 if now > begun else rounds + 1
            if rounds > P.MOST_ROUNDS:
                return P.RESTLESS
            begun = now if now > begun else begun
            status = self.do_step(index, begun, end - begun)
            if status not in DONE or not events[P.FLAGS]:
                return status

    def get(self, code: int, index: int, t: float, reach: float, step: float) -> int:
        """Read a group's variables into the signals; TOO_LONG for a text that does not fit."""
        w, group = self.wiring, self.groups[index]
        status = int(group.call(*group.arguments))
        if status not in DONE:
            return status
        if group.kind != P.TEXT:
            w.signals[group.where] = group.values
            if group.kind not in (P.REAL, P.FLOAT):
                w.exact[group.where] = group.values.astype(np.int64)
            return status
        for place, text in zip(group.where.tolist(), group.values.tolist()):
            found = ctypes.string_at(text) if text else b""  # a null pointer counts as an empty text
            kept = found[:P.LONGEST_TEXT - 1]
            w.texts[place, :len(kept) + 1] = np.frombuffer(kept + b"\0", np.uint8)
            if len(kept) < len(found):
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
        component, w = self.components[index], self.wiring
        status = int(component[P.SET_STATE](component[P.INSTANCE], int(w.states[index])))
        w.events[index, P.CHANGED] = w.offers[index]  # the FMU has the inputs of that time
        return status
