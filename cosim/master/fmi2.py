"""What is particular to FMI 2.0: how values are moved, how an instance is made and initialised, how it tells its end.

`fmi3` has the same names; `instance.Standard` says what they mean.
"""
import ctypes
import math
from typing import TYPE_CHECKING, Any

import fmpy
from fmpy.fmi2 import (
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
    fmi2EventInfo,
    fmi2StepFinishedTYPE,
)
from fmpy.logging import addLoggerProxy

from ..errors import RunError
from .logger import ENVIRONMENTS, log
from .program import MOST_ROUNDS, OK, REAL, TEXT, WARNING, WHOLE

if TYPE_CHECKING:
    from .instance import Instance

PREFIX, TOKEN, PLATFORM, STATE, COUNTS_VALUES = "fmi2", "guid", fmpy.platform, "FMUstate", False
DESERIALIZE = "DeSerialize"
TYPES = {"Real": ("Real", REAL), "Integer": ("Integer", WHOLE), "Enumeration": ("Integer", WHOLE),
         "Boolean": ("Boolean", WHOLE), "String": ("String", TEXT)}
LAST_SUCCESSFUL_TIME, TERMINATED = 2, 3  # fmi2StatusKind
MODEL_EXCHANGE, CO_SIMULATION = 0, 1     # fmi2Type


CALLBACKS = fmi2CallbackFunctions()  # what all instances are given
CALLBACKS.allocateMemory = fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
CALLBACKS.freeMemory = fmi2CallbackFreeMemoryTYPE(fmpy.free)
CALLBACKS.stepFinished = fmi2StepFinishedTYPE()
LOGGER = fmi2CallbackLoggerTYPE(log)


def take_messages() -> None:
    """Have the messages of all instances, formatted by FMPy's proxy. There is one in a process: who lets FMPy simulate,
    which takes it for a logger that goes with that simulation, calls this afterwards."""
    CALLBACKS.logger = LOGGER
    addLoggerProxy(ctypes.byref(CALLBACKS))


take_messages()


def instantiate(instance: "Instance") -> int | None:
    """fmi2Instantiate; where the instance is, or None."""
    callbacks = fmi2CallbackFunctions.from_buffer_copy(CALLBACKS)
    callbacks.componentEnvironment = instance.number
    ENVIRONMENTS[instance.number].callbacks = callbacks
    text, flag, pointer = ctypes.c_char_p, ctypes.c_int, ctypes.c_void_p
    make = instance.library.function("fmi2Instantiate", pointer, text, flag, text, text, pointer, flag, flag)
    kind = MODEL_EXCHANGE if instance.file.exchange else CO_SIMULATION
    made: int | None = make(instance.name.encode(), kind, instance.token.encode(),
                            (instance.file.folder / "resources").resolve().as_uri().encode(),
                            ctypes.addressof(callbacks), 0, 1)
    return made


def enter(instance: "Instance", start: float, stop: float | None, tolerance: float | None) -> None:
    """Set the experiment up, and enter Initialization Mode."""
    instance.setup(start, stop, tolerance)
    instance.simple("fmi2EnterInitializationMode")


def leave(instance: "Instance", start: float) -> None:
    """Leave Initialization Mode, ready to step; in model exchange, come to the end of the events.

    Raises RunError if the FMU ends the simulation at once, or does not come to the end of its events.
    """
    instance.simple("fmi2ExitInitializationMode")
    if not instance.file.exchange:
        return
    call, found = "fmi2NewDiscreteStates", fmi2EventInfo()
    for _ in range(MOST_ROUNDS):
        instance.check(instance.call(call, ctypes.c_void_p(ctypes.addressof(found))), call, start)
        if found.terminateSimulation:
            raise RunError(f"{instance.label} ended the simulation as it began, at t = {start:.6g} s.")
        if not found.newDiscreteStatesNeeded:
            instance.simple("fmi2EnterContinuousTimeMode")
            return
    raise RunError(f"{instance.label} does not come to the end of its events at t = {start:.6g} s.")


def ended_at(instance: "Instance", begun: float, until: float) -> float | None:
    """See `Instance.ended_at`."""
    ended, time = inquire(instance, "Boolean", TERMINATED, ctypes.c_int()), None
    if ended:
        time = inquire(instance, "Real", LAST_SUCCESSFUL_TIME, ctypes.c_double())
    if not ended or not instance.alive:
        return None
    return begun if time is None or not math.isfinite(time) else min(max(time, begun), until)


def inquire(instance: "Instance", kind: str, status: int, value: Any) -> Any:
    """fmi2Get...Status into the ctypes `value`: what it is then, or None if the FMU has no such function or refuses."""
    call = f"fmi2Get{kind}Status"
    if not instance.library.has(call):
        return None
    answer = instance.call(call, ctypes.c_int(status), ctypes.c_void_p(ctypes.addressof(value)))
    return value.value if answer in (OK, WARNING) else None
