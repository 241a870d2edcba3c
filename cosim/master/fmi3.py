"""What is particular to FMI 3.0: how values are moved, how an instance is made and initialised, how it tells its end.

An FMU that has an event mode uses it: it may return early from a step at an event, its discrete states are updated
then, and discrete inputs are given in event mode. Clocks are not served, see `fmu.unflyable`.
"""
import ctypes
from typing import TYPE_CHECKING

import fmpy

from ..errors import RunError
from .logger import log
from .program import (
    END_BYTE,
    FLAGS,
    FLOAT,
    INT8,
    INT16,
    INT64,
    MOST_ROUNDS,
    REACHED,
    REAL,
    TEXT,
    UINT8,
    UINT16,
    UINT32,
    UINT64,
    WHOLE,
)

if TYPE_CHECKING:
    from .instance import Instance

PREFIX, TOKEN, PLATFORM, STATE = "fmi3", "instantiationToken", fmpy.platform_tuple, "FMUState"
COUNTS_VALUES = True  # fmi3Get... and fmi3Set... are told the number of values beside that of the references
DESERIALIZE = "Deserialize"
TYPES = {"Float64": ("Float64", REAL), "Float32": ("Float32", FLOAT), "Int8": ("Int8", INT8), "UInt8": ("UInt8", UINT8),
         "Int16": ("Int16", INT16), "UInt16": ("UInt16", UINT16), "Int32": ("Int32", WHOLE),
         "UInt32": ("UInt32", UINT32), "Int64": ("Int64", INT64), "UInt64": ("UInt64", UINT64),
         "Enumeration": ("Int64", INT64), "Boolean": ("Boolean", UINT8), "String": ("String", TEXT)}
TEXT_TYPE, FLAG, POINTER, REAL_TYPE = ctypes.c_char_p, ctypes.c_bool, ctypes.c_void_p, ctypes.c_double
LOGGER = ctypes.CFUNCTYPE(None, POINTER, ctypes.c_int, TEXT_TYPE, TEXT_TYPE)(
    lambda environment, status, category, message: log(environment, None, status, category, message))


def instantiate(instance: "Instance") -> int | None:
    """fmi3InstantiateCoSimulation, or ...ModelExchange; where the instance is, or None.

    With event mode if the FMU has one; without if it does not come with it, since some claim what they lack.
    """
    resources = f"{instance.file.folder.resolve() / 'resources'}/"
    visible, logging, early_return = False, True, True
    words = instance.name.encode(), instance.token.encode(), resources.encode()
    if instance.file.exchange:
        instance.uses_events = True
        begin = instance.library.function("fmi3InstantiateModelExchange", POINTER, *[TEXT_TYPE] * 3, *[FLAG] * 2,
                                          POINTER, type(LOGGER))
        begun: int | None = begin(*words, visible, logging, instance.number, LOGGER)
        return begun
    make = instance.library.function("fmi3InstantiateCoSimulation", POINTER, *[TEXT_TYPE] * 3, *[FLAG] * 4, POINTER,
                                     ctypes.c_size_t, POINTER, type(LOGGER), POINTER)
    for uses_events in (True, False) if instance.claims("hasEventMode") else (False,):
        instance.messages.clear()
        made: int | None = make(*words, visible, logging, uses_events, early_return, None, 0, instance.number, LOGGER,
                                None)
        if made:
            instance.uses_events = uses_events
            return made
    return None


def enter(instance: "Instance", start: float, stop: float | None, tolerance: float | None) -> None:
    """Enter Initialization Mode."""
    call = "fmi3EnterInitializationMode"
    instance.check(instance.call(call, FLAG(tolerance is not None), REAL_TYPE(tolerance or 0.0), REAL_TYPE(start),
                                 FLAG(stop is not None), REAL_TYPE(stop or 0.0)), call)


def leave(instance: "Instance", start: float) -> None:
    """Leave Initialization Mode, ready to step; in model exchange, to Continuous-Time Mode.

    Raises RunError if the FMU ends the simulation at once, or does not come to the end of its events.
    """
    instance.simple("fmi3ExitInitializationMode")
    if not instance.uses_events:
        return
    flags, time = (FLAG * 5)(), REAL_TYPE()  # again, end of the simulation, ...
    places = [*(POINTER(ctypes.addressof(flags) + i) for i in range(5)), POINTER(ctypes.addressof(time))]
    call = "fmi3UpdateDiscreteStates"
    for _ in range(MOST_ROUNDS):
        instance.check(instance.call(call, *places), call, start)
        if flags[1]:
            raise RunError(f"{instance.label} ended the simulation as it began, at t = {start:.6g} s.")
        if not flags[0]:
            instance.simple(f"fmi3Enter{'ContinuousTimeMode' if instance.file.exchange else 'StepMode'}")
            return
    raise RunError(f"{instance.label} does not come to the end of its events at t = {start:.6g} s.")


def ended_at(instance: "Instance", begun: float, until: float) -> float | None:
    """See `Instance.ended_at`: fmi3DoStep and fmi3UpdateDiscreteStates have told it."""
    if instance.events is None:
        return None
    ended = instance.events.view("u1")[8 * FLAGS + END_BYTE]
    time = float(instance.events.view(float)[REACHED])
    instance.events[FLAGS] = 0
    if not ended:
        return None
    return min(max(time, begun), until) if time == time else begun
