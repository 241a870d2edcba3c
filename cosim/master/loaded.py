"""The master: a system's FMUs loaded, wired and initialised, and programs carried out on them.

The algorithms (`algorithms`) say what to do on a tick, as programs; `flight` flies from start to stop.
"""
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import cached_property
from typing import Protocol

import numpy as np

from ..errors import RunError
from . import last_call, loop_compiled, loop_plain
from . import program as P
from .connections import checked_connections, recorded_names
from .dependencies import step_order
from .fmu import FmuFile
from .initialise import Batch, initialise, order
from .instance import Instance
from .look_up import Place
from .system import System, Value
from .table import Table, inputs_of
from .wirer import Wirer
from .wiring import Signal, Wiring

OF_GROUPS = (P.SET, P.PREDICT, P.SLOPE, P.GET, P.OFFER)
CALLS = {P.SET: "Set{}", P.PREDICT: "Set{}", P.SLOPE: "SetRealInputDerivatives", P.GET: "Get{}", P.OFFER: "Set{}",
         P.STEP: "DoStep", P.SAVE: "Get{}", P.RESTORE: "Set{}"}
IN_EVENTS = {P.ENTERING: "EnterEventMode", P.GIVING: "Set... in event mode", P.UPDATING: "UpdateDiscreteStates",
             P.LEAVING: "EnterStepMode"}


class Ended(RunError):
    """An FMU ended the simulation, which it may: the run is over, and `time` (s) is the last that the FMU computed."""

    def __init__(self, sentence: str, time: float):
        super().__init__(sentence)
        self.time = time


class Loop(Protocol):
    """Carries out programs on one wiring: `loop_plain.Loop` or `loop_compiled.Loop`."""

    def run(self, ops: np.ndarray, rows: np.ndarray, times: np.ndarray, cursor: np.ndarray,
            first: int, count: int, start: float, step: float, decimate: int) -> int:
        """Carry out `ops` on `count` ticks, see `loop_compiled.Loop.run`; 0, or the status of the call that failed."""


class Master:
    """A loaded system. `wiring.signals` holds what is connected or recorded at the current time."""

    def __init__(self, system: System, files: dict[str, FmuFile], record: list[str] | None = None,
                 plain: bool = False, apart: bool = False, tolerance: float | None = None,
                 table: Table | None = None, also: Iterable[str] = ()):
        """`files` has the open FMU file of every component; `record` picks variables by component.variable,
        * for any (None: all numeric outputs); `plain` takes the loop in Python; `apart` reads what is only to be
        recorded by calls of its own, so that programs can leave them out; `tolerance` is the relative one that FMUs
        are asked for (None: what each declares); `table` has inputs over time; `also` is recorded in any case.

        Raises UsageError for values, connections, patterns or a table that do not fit the FMUs, RunError if an FMU
        does not instantiate.
        """
        self.system, self.files, self.tolerance = system, files, tolerance
        self.values: dict[str, dict[str, Value]] = {}
        self.values = self.checked_values(system)
        self.targets = checked_connections(system, files)
        recorded = recorded_names(system, files, record).union(also)
        self.inputs = inputs_of(table, files, self.targets) if table else None
        self.cursor = last_call.place.cursor if last_call.place else P.cursor()
        self.span = last_call.place.span if last_call.place else np.zeros(2)
        self.place = Place(self.inputs, self.cursor, self.span) if self.inputs else None
        self.instances: list[Instance] = []
        try:
            for component in system.components:
                self.instances.append(Instance(files[component.name], component.name))
            self.wiring = Wirer(self.instances, self.targets, recorded, apart, self.place).wire()
        except BaseException:
            self.close()
            raise
        self.number = {c.name: i for i, c in enumerate(system.components)}
        self.loop = make_loop(plain, self.wiring)

    def checked_values(self, system: System) -> dict[str, dict[str, Value]]:
        """Component -> variable -> value in the variable's type; what has been checked for the system before is not
        checked again. Raises UsageError for a value that does not fit."""
        before = {c.name: c.values for c in self.system.components}
        found = {}
        for c in system.components:
            known, old = self.values.get(c.name, {}), before.get(c.name, {})
            found[c.name] = {n: known[n] if n in known and x is old.get(n) else
                             self.files[c.name].checked(n, x, c.name) for n, x in c.values.items()}
        return found

    @cached_property
    def exchanged(self) -> list[list[Batch]]:
        """What is set and read before the start, see `initialise.order`."""
        return order(self.system, self.files, self.targets)

    @cached_property
    def step_order(self) -> list[list[str]]:
        """The components in the order of the dependencies, see `dependencies.step_order`."""
        return step_order(self.system, self.files, self.targets)

    @property
    def columns(self) -> list[Signal]:
        """What is recorded, in the order of a row."""
        return self.wiring.columns

    def row(self) -> np.ndarray:
        """The recorded signals as they are now, shape (columns,)."""
        return self.wiring.signals.take(self.wiring.recorded)

    def row_at(self, time: float, step: float) -> np.ndarray:
        """The same as the tick loop records it at `time` (s): what is marked for later than a step of `step` (s) allows
        shows what it was before."""
        w = self.wiring
        due = w.clock[w.holder[w.recorded], 0] <= time + 0.5 * step
        row: np.ndarray = np.where(due, w.signals[w.recorded], w.before[w.recorded])
        return row

    # --- life cycle -----------------------------------------------------------------------------------

    def initialise(self, start: float, stop: float | None) -> None:
        """Set values, then exchange outputs and inputs until all FMUs are ready to step. Times in s; without a stop the
        FMUs know none.

        Raises RunError if an FMU refuses, or if the values do not settle.
        """
        for instance in self.instances:
            instance.set(self.values[instance.name])
        initialise(self.exchanged, {i.name: i for i in self.instances}, self.targets, start, stop, self.tolerance,
                   self.inputs.at(start) if self.inputs else {})
        self.wiring.begin(self.instances)
        self.read_all(start)
        self.wiring.before[:] = self.wiring.signals
        self.wiring.clock[:] = start

    def read_all(self, time: float) -> None:
        """Read all outputs at `time` (s) into the signals. Raises RunError if an FMU refuses."""
        self.run(P.program(P.row(P.GET, g.number) for groups in self.wiring.outputs for g in groups), 0, 1, time, 0.0)

    def reset(self, system: System) -> None:
        """Back to before initialisation, to fly `system`: the same components and connections, other values.

        Raises UsageError for values that do not fit, RunError if an FMU refuses, or has answered Fatal before.
        """
        self.values, self.system = self.checked_values(system), system
        self.free_states()
        for instance in self.instances:
            instance.reset()

    def free_states(self) -> None:
        """Free the FMU states that programs have saved."""
        for i, (instance, row) in enumerate(zip(self.instances, self.wiring.components)):
            if self.wiring.states[i] and row[P.FREE_STATE] and instance.alive:
                instance.free_state(self.wiring.states.ctypes.data + 8 * i)
            self.wiring.states[i] = 0

    def close(self) -> None:
        """End all instances and unload their libraries."""
        if hasattr(self, "wiring"):
            self.free_states()
        for instance in self.instances:
            instance.close()
        self.instances = []

    # --- ticks ----------------------------------------------------------------------------------------

    def attempt(self, ops: np.ndarray, first: int, count: int, start: float, step: float,
                rows: np.ndarray, times: np.ndarray, decimate: int) -> int:
        """Carry out `ops` on `count` ticks from the tick `first`; the status of the call that failed, or 0.

        Tick k begins at start + k * step (s); `rows` and `times` get every `decimate`-th tick (0: none), see
        `loop_compiled.Loop.run`. Raises RunError if an FMU has answered Fatal before.
        """
        for instance in self.instances:
            instance.need_alive()
        self.span[:] = start, step
        last_call.begin()
        status = self.loop.run(ops, rows, times, self.cursor, first, count, start, step, decimate)
        last_call.end()
        if status not in (0, P.TOO_LONG, P.RESTLESS):
            self.refusing(ops)[0].answered(status)
        return status

    def run(self, ops: np.ndarray, first: int, count: int, start: float, step: float) -> None:
        """Carry out `ops` without recording. Raises RunError for a failed call."""
        self.check(self.attempt(ops, first, count, start, step, NO_ROWS, NO_TIMES, 0), ops, start, step)

    def check(self, status: int, ops: np.ndarray, start: float, step: float) -> None:
        """Raise RunError unless `status` is OK: the call where the cursor stands, with the FMU's own words.

        Raises Ended, which is a RunError, if the FMU says that it discarded a step because the simulation ends.
        """
        if status == 0:
            return
        instance, call, late = self.refusing(ops)
        time = start + (int(self.cursor[P.TICK]) + late) * step
        if status == P.TOO_LONG:
            raise RunError(f"{instance.label} shows a text longer than {P.LONGEST_TEXT - 1} bytes at t = {time:.6g} s.")
        if status == P.RESTLESS:
            raise RunError(f"{instance.label} does not come to the end of its events in the step from "
                           f"t = {time:.6g} s.")
        if status == P.DISCARD:
            self.check_end(ops, time, step)
        instance.check(status, call, time)

    def check_end(self, ops: np.ndarray, time: float, step: float) -> None:
        """Raise Ended if an FMU has discarded the step of `ops` from `time` (s) because the simulation ends."""
        instance, _, _ = self.refusing(ops)
        code, _, _, _, reach = ops[self.cursor[P.AT]].tolist()
        ended = instance.ended_at(time, time + reach * step) if code == P.STEP else None
        if ended is not None:
            why = f": {instance.reason}" if instance.messages else "."
            raise Ended(f"{instance.label} ended the simulation at t = {ended:.6g} s{why}", ended)

    def refusing(self, ops: np.ndarray) -> tuple[Instance, str, int]:
        """The instance, FMI call, and 1 if it belongs to the end of the tick, of the row where the cursor stands."""
        code, index = ops[self.cursor[P.AT], :2].tolist()
        component, call, late = self.described(code, index)
        instance = self.instances[component]
        if code == P.STEP and self.wiring.events[component, P.CALLED] in IN_EVENTS:
            call = instance.standard.PREFIX + IN_EVENTS[int(self.wiring.events[component, P.CALLED])]
        return instance, call, late

    def described(self, code: int, index: int) -> tuple[int, str, int]:
        """(component, FMI call, 1 if it belongs to the end of the tick) of a row of a program."""
        group = self.wiring.every_group[index] if code in OF_GROUPS else None
        component = group.owner if group else index
        standard = self.instances[component].standard
        call = CALLS[code].format(group.suffix if group else standard.STATE) if code in CALLS else ""
        return component, standard.PREFIX + call if call else "a call", int(code == P.GET)

    def calls(self) -> dict[tuple[int, int], tuple[str, str, int]]:
        """(code, index) of all rows that call an FMU -> (its name and file, FMI call, 1 if at the end of the tick)."""
        found = {}
        for code in CALLS:
            for index in range(len(self.wiring.every_group) if code in OF_GROUPS else len(self.instances)):
                component, call, late = self.described(code, index)
                instance = self.instances[component]
                found[code, index] = instance.label, call, late
        return found

    def cannot_save(self) -> list[str]:
        """Components that cannot save and restore their state."""
        return [i.name for i in self.instances if not i.claims("canGetAndSetFMUstate")]

    def snapshot(self) -> list[np.ndarray]:
        """Copies of what a step changes here, to be given to `put_back`; the FMUs' own states are saved by programs."""
        w = self.wiring
        return [a.copy() for a in (w.signals, w.exact, w.before, w.clock, w.texts)]

    def put_back(self, snapshot: list[np.ndarray]) -> None:
        """Undo what has changed here since `snapshot`."""
        w = self.wiring
        for place, kept in zip((w.signals, w.exact, w.before, w.clock, w.texts), snapshot):
            place[:] = kept


NO_ROWS, NO_TIMES = np.empty((0, 0)), np.empty(0)


def make_loop(plain: bool, wiring: Wiring) -> Loop:
    """The tick loop: in Python if `plain` or where there is no compiled one; the numbers are the same."""
    compiled = None if plain else loop_compiled.library()
    return loop_plain.Loop(wiring) if compiled is None else loop_compiled.Loop(wiring, compiled)


@contextmanager
def open_files(system: System) -> Iterator[dict[str, FmuFile]]:
    """The FMU file of every component, extracted once for all that use it and removed at the end.

    Raises UsageError for a file that is missing or cannot be flown, see `FmuFile.open`.
    """
    opened: dict[str, FmuFile] = {}
    try:
        for component in system.components:
            path = str(component.fmu.resolve())
            if path not in opened:
                opened[path] = FmuFile.open(component.fmu, to_fly=True)
        yield {c.name: opened[str(c.fmu.resolve())] for c in system.components}
    finally:
        for file in opened.values():
            file.close()
