"""A running instance of an FMU: fmpy loads and instantiates it, calls go to the raw functions."""
import ctypes
import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import count
from typing import Any

import fmpy
import numpy as np
from fmpy.fmi2 import (
    FMU2Slave,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
    fmi2StepFinishedTYPE,
)
from fmpy.logging import addLoggerProxy

from ..errors import RunError, UsageError
from . import last_call
from .fmu import CALL_SUFFIX, FmuFile
from .system import Value

OK, WARNING, DISCARD, ERROR, FATAL = range(5)
STATUS = ("OK", "Warning", "Discard", "Error", "Fatal", "Pending")
LAST_SUCCESSFUL_TIME, TERMINATED = 2, 3  # fmi2StatusKind
MOST_MESSAGES = 1000
SIZE, ADDRESS = ctypes.c_size_t, ctypes.c_void_p


@dataclass
class Environment:
    """What the logger is told of an instance by its componentEnvironment: whose messages these are."""
    name: bytes
    callbacks: fmi2CallbackFunctions
    messages: list[str] = field(default_factory=list)  # those of a status other than OK


ENVIRONMENTS: dict[int, Environment] = {}  # componentEnvironment -> the instance's; one that cannot be freed stays
NUMBERS = count(1)


def log(environment: int | None, instance: bytes | None, status: int, _category: bytes, message: bytes | None) -> None:
    """The logger of all instances: keeps messages of a status other than OK."""
    if status == OK:
        return
    text = (message or b"").decode("utf-8", "replace")
    last_call.logged(text)
    mine = ENVIRONMENTS.get(environment or 0)
    if mine is None:  # the FMU hands on something else: its name has to do
        mine = next((e for e in reversed(ENVIRONMENTS.values()) if e.name == instance), None)
    if mine and len(mine.messages) < MOST_MESSAGES:
        mine.messages.append(text)


def make_callbacks() -> fmi2CallbackFunctions:
    """The callbacks that all instances are given."""
    callbacks = fmi2CallbackFunctions()
    callbacks.logger = fmi2CallbackLoggerTYPE(log)
    callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
    callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(fmpy.free)
    callbacks.stepFinished = fmi2StepFinishedTYPE()
    addLoggerProxy(ctypes.byref(callbacks))  # formats printf-style messages; there is one per process
    return callbacks


CALLBACKS = make_callbacks()
ONLY_ONE: dict[str, str] = {}  # GUID of an FMU that allows one instance in a process -> the name of that instance


class Instance:
    """An instance of an FMU.

    Calls raise RunError if the FMU answers anything worse than a warning, and after it has answered Fatal.
    """

    def __init__(self, file: FmuFile, name: str):
        """Load the library and instantiate.

        Raises RunError if that fails, UsageError if the FMU allows one instance in a process and there is one.
        """
        self.file, self.name = file, name
        self.open, self.stepping, self.failed = False, False, False
        self.only_one, guid = self.claims("canBeInstantiatedOnlyOncePerProcess"), self.guid
        if self.only_one and guid in ONLY_ONE:
            raise UsageError(f"{self.label} cannot be instantiated beside {ONLY_ONE[guid]}: the FMU allows only one "
                             f"instance in a process (canBeInstantiatedOnlyOncePerProcess).")
        self.number = next(NUMBERS)
        callbacks = fmi2CallbackFunctions.from_buffer_copy(CALLBACKS)
        callbacks.componentEnvironment = self.number
        self.messages = ENVIRONMENTS.setdefault(self.number, Environment(name.encode(), callbacks)).messages
        last_call.begin(f"{self.label}: fmi2Instantiate")
        try:
            self.slave = FMU2Slave(guid=guid, unzipDirectory=str(file.folder), instanceName=name,
                                   modelIdentifier=file.identifier)
            self.slave.instantiate(callbacks=callbacks, loggingOn=True)
        except Exception as error:
            message = f" It said: {self.messages[-1]}" if self.messages else ""
            ENVIRONMENTS.pop(self.number)
            raise RunError(f"{self.label} cannot be instantiated: {error}{message}") from error
        finally:
            last_call.end()
        self.open = True
        if self.only_one:
            ONLY_ONE[guid] = name
        self.component = ctypes.c_void_p(self.slave.component)
        self.pointer = int(self.slave.component)
        self.do_step = self.function("fmi2DoStep", ctypes.c_double, ctypes.c_double, ctypes.c_int)

    @property
    def label(self) -> str:
        """What messages call it."""
        return f"{self.name} ({self.file.path.name})"

    @property
    def alive(self) -> bool:
        """Whether its functions may be called: it is not closed, and no instance of the FMU has answered Fatal."""
        return self.open and not self.file.corrupted

    def need_alive(self) -> None:
        """Raises RunError if no call is allowed any more."""
        if not self.alive:
            raise RunError(f"{self.label} cannot be used any more: "
                           f"{'the FMU has answered Fatal' if self.file.corrupted else 'it is closed'}.")

    # --- raw calls ------------------------------------------------------------------------------------

    @property
    def guid(self) -> str:
        """What the FMU calls itself."""
        return self.file.description.attributes.get("guid", "")

    def claims(self, flag: str) -> bool:
        """Whether the FMU claims a capability of co-simulation (FMI 2.0 section 4.3.1)."""
        return self.file.description.claims(flag)

    def function(self, name: str, *argument_types: Any) -> Any:
        """A C function of the library that takes the instance first and returns a status."""
        function = self.slave.dll[name]
        function.argtypes = [ctypes.c_void_p, *argument_types]
        function.restype = ctypes.c_int
        return function

    def address(self, name: str) -> int:
        """Where the function called `name` is. Raises RunError if the FMU's library has none."""
        try:
            return ctypes.cast(self.slave.dll[name], ctypes.c_void_p).value or 0
        except AttributeError:
            raise RunError(f"{self.label} claims {name}, and its library lacks it.") from None

    def call(self, name: str, *arguments: Any) -> int:
        """Call the function `name` with ctypes values; its status.

        Raises RunError if no call is allowed any more.
        """
        self.need_alive()
        last_call.begin(f"{self.label}: {name}")
        status = int(self.function(name, *map(type, arguments))(self.component, *arguments))
        last_call.end()
        self.answered(status)
        return status

    def answered(self, status: int) -> None:
        """Remember what a status forbids: after Fatal everything, after Error to terminate."""
        self.file.corrupted |= status == FATAL
        self.failed |= status not in (OK, WARNING, DISCARD)

    def check(self, status: int, call: str, time: float | None = None) -> None:
        """Raise RunError unless `status` is OK or Warning, with the FMU's last message."""
        if status in (OK, WARNING):
            return
        self.answered(status)
        answer = STATUS[status] if 0 <= status < len(STATUS) else f"the unknown status {status}"
        when = "" if time is None else f" at t = {time:.6g} s"
        raise RunError(f"{self.label} answered {answer} to {call}{when}: {self.reason}")

    @property
    def reason(self) -> str:
        """Its last message."""
        return self.messages[-1] if self.messages else "and gave no reason"

    # --- values ---------------------------------------------------------------------------------------

    def transfer(self, verb: str, names: list[str], values: Iterable[Value] | None) -> list[Any]:
        """Get or set variables of any type by name, one call per type; values in the order of `names`."""
        given = dict(zip(names, values)) if values is not None else {}
        result: dict[str, Any] = {}
        for kind, suffix in CALL_SUFFIX.items():
            group = [n for n in names if self.file.variable(n).type == kind]
            if not group:
                continue
            references = np.array([self.file.variables[n].reference for n in group], dtype=np.uint32)
            buffer = np.zeros(len(group), dtype={"Real": np.float64, "String": np.uintp}.get(kind, np.int32))
            if kind == "String" and given:
                texts = [ctypes.c_char_p(str(given[n]).encode()) for n in group]  # alive until the call has returned
                buffer[:] = [ctypes.cast(t, ctypes.c_void_p).value or 0 for t in texts]
            elif given:
                buffer[:] = [given[n] for n in group]
            call = f"fmi2{verb}{suffix}"
            status = self.call(call, ADDRESS(references.ctypes.data), SIZE(len(group)), ADDRESS(buffer.ctypes.data))
            self.check(status, f"{call}({', '.join(group[:3])}{', ...' if group[3:] else ''})")
            result.update(zip(group, shown(kind, buffer.tolist())))
        return [result[n] for n in names]

    def get(self, names: Iterable[str]) -> list[Any]:
        """Values of the variables called `names`."""
        return self.transfer("Get", list(names), None)

    def set(self, values: dict[str, Value]) -> None:
        """Set variables by name; values must have been through `FmuFile.checked`."""
        self.transfer("Set", list(values), values.values())

    # --- life cycle -----------------------------------------------------------------------------------

    def setup(self, start: float, stop: float) -> None:
        """fmi2SetupExperiment; times in s."""
        real, flag = ctypes.c_double, ctypes.c_int
        status = self.call("fmi2SetupExperiment", flag(0), real(0.0), real(start), flag(1), real(stop))
        self.check(status, "fmi2SetupExperiment")

    def simple(self, call: str) -> None:
        """Make a call that takes nothing but the instance, such as fmi2EnterInitializationMode."""
        self.check(self.call(call), call)
        self.stepping = {"fmi2ExitInitializationMode": True, "fmi2Reset": False}.get(call, self.stepping)
        self.failed = self.failed and call != "fmi2Reset"

    def ended_at(self, begun: float, until: float) -> float | None:
        """The time (s) at which the FMU ended the simulation in a step that it discarded, from `begun` to `until`.

        None if it did not, or does not say.
        """
        ended, time = self.inquire("Boolean", TERMINATED, ctypes.c_int()), None
        if ended:
            time = self.inquire("Real", LAST_SUCCESSFUL_TIME, ctypes.c_double())
        if not ended or not self.alive:
            return None
        return begun if time is None or not math.isfinite(time) else min(max(time, begun), until)

    def inquire(self, kind: str, status: int, value: Any) -> Any:
        """fmi2Get...Status into the ctypes `value`: what it is then, or None if the FMU refuses."""
        answer = self.call(f"fmi2Get{kind}Status", ctypes.c_int(status), ADDRESS(ctypes.addressof(value)))
        return value.value if answer in (OK, WARNING) else None

    def free_state(self, place: int) -> None:
        """fmi2FreeFMUstate of the state whose pointer is at the address `place`."""
        self.call("fmi2FreeFMUstate", ADDRESS(place))

    def close(self) -> None:
        """Terminate where the standard allows it, and free; after Fatal no call is allowed any more."""
        if self.alive and self.stepping and not self.failed:
            self.call("fmi2Terminate")
        if self.alive:
            last_call.begin(f"{self.label}: fmi2FreeInstance")
            self.slave.fmi2FreeInstance(self.slave.component)
            if hasattr(self.slave.dll, "finalizePythonInterpreter"):
                # pythonfmu 0.7.0 does this as its library goes, after its static objects: a write to freed memory that
                # can abort the process at its end. Done before, it finds nothing to do. The interpreter stays.
                self.slave.dll.finalizePythonInterpreter()
            self.slave.freeLibrary()
            last_call.end()
            ENVIRONMENTS.pop(self.number)
        if self.open and self.only_one:
            ONLY_ONE.pop(self.guid)
        self.open = False


def shown(kind: str, values: list[Any]) -> list[Any]:
    """What fmi2Get... has left in a buffer, in the variable's type; a null pointer is an empty text."""
    if kind == "Boolean":
        return [bool(x) for x in values]
    if kind == "String":
        return [ctypes.string_at(x).decode("utf-8", "replace") if x else "" for x in values]
    return values
