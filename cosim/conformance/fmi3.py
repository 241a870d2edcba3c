"""The C functions of an FMI 3.0 shared library for co-simulation, called as `fmi2` calls those of FMI 2.0.

Runs in the child process only. The calls keep their names of FMI 2.0 where both versions have them, so that one probe
serves both. Event mode and early return are not used unless asked for. Sections 2.2, 2.3 and 4.2 give the signatures.
"""
import ctypes
from collections import Counter
from collections.abc import Sequence
from ctypes import POINTER, byref, c_bool, c_char_p, c_double, c_int, c_size_t, c_ubyte, c_uint, c_void_p
from math import isfinite, nan
from pathlib import Path
from typing import Any

from .fmi2 import OK, REFERENCES, WARNING, Instance, Library, Mark, Value

LOGGER = ctypes.CFUNCTYPE(None, c_void_p, c_int, c_char_p, c_char_p)
TYPES: dict[str, Any] = {"Float64": c_double, "Float32": ctypes.c_float, "Boolean": c_ubyte, "String": c_char_p}
for _bits in (8, 16, 32, 64):
    TYPES[f"Int{_bits}"] = getattr(ctypes, f"c_int{_bits}")
    TYPES[f"UInt{_bits}"] = getattr(ctypes, f"c_uint{_bits}")
FLAG = POINTER(c_bool)

SIGNATURES: dict[str, tuple[Any, ...]] = {
    "SetDebugLogging": (c_bool, c_size_t, POINTER(c_char_p)),
    "EnterInitializationMode": (c_bool, c_double, c_double, c_bool, c_double),
    "ExitInitializationMode": (),
    "EnterConfigurationMode": (),
    "ExitConfigurationMode": (),
    "EnterEventMode": (),
    "EnterStepMode": (),
    "UpdateDiscreteStates": (FLAG, FLAG, FLAG, FLAG, FLAG, POINTER(c_double)),
    "Terminate": (),
    "Reset": (),
    "DoStep": (c_double, c_double, c_bool, FLAG, FLAG, FLAG, POINTER(c_double)),
    "GetFMUState": (POINTER(c_void_p),),
    "SetFMUState": (c_void_p,),
    "FreeFMUState": (POINTER(c_void_p),),
    "SerializedFMUStateSize": (c_void_p, POINTER(c_size_t)),
    "SerializeFMUState": (c_void_p, c_char_p, c_size_t),
    "DeserializeFMUState": (c_char_p, c_size_t, POINTER(c_void_p)),
    "GetDirectionalDerivative": (REFERENCES, c_size_t, REFERENCES, c_size_t, POINTER(c_double), c_size_t,
                                 POINTER(c_double), c_size_t),
    "GetOutputDerivatives": (REFERENCES, c_size_t, POINTER(ctypes.c_int32), POINTER(c_double), c_size_t),
}
for _type, _c_type in TYPES.items():
    SIGNATURES[f"Get{_type}"] = SIGNATURES[f"Set{_type}"] = (REFERENCES, c_size_t, POINTER(_c_type), c_size_t)
SIGNATURES["GetBinary"] = SIGNATURES["SetBinary"] = (REFERENCES, c_size_t, POINTER(c_size_t), POINTER(c_void_p),
                                                     c_size_t)


class Library3(Library):
    """A loaded shared library of FMI 3.0; `counts` has the number of values of each value reference of an array."""
    prefix = "fmi3"
    types = TYPES
    signatures = SIGNATURES

    def __init__(self, file: Path, mark: Mark, counts: dict[int, int]):
        super().__init__(file, mark)
        self.counts = counts
        self.logger3 = LOGGER(lambda environment, status, category, message: self.take_message(
            environment, self.names.get(environment or 0, self.names.get(self.made, "")).encode(), status, category,
            message))

    def instantiate(self, name: str, guid: str, resources: str, logging_on: bool = False,
                    event_mode: bool = False) -> "Instance3 | None":
        """fmi3InstantiateCoSimulation (2.3.1); None when the FMU returned a null pointer."""
        self.made = number = self.made + 1
        messages = self.messages[number] = Counter()
        self.names[number] = name
        self.words = ""
        self.mark.set("fmi3InstantiateCoSimulation")
        function = self.dll.fmi3InstantiateCoSimulation
        function.restype = c_void_p
        function.argtypes = (c_char_p, c_char_p, c_char_p, c_bool, c_bool, c_bool, c_bool, REFERENCES, c_size_t,
                             c_void_p, LOGGER, c_void_p)
        component = function(name.encode(), guid.encode(), resources.encode(), False, logging_on, event_mode, False,
                             None, 0, number, self.logger3, None)
        return Instance3(self, component, messages, number, event_mode) if component else None


class Instance3(Instance):
    """One instance; see `fmi2.Instance`. `told` is what fmi3DoStep said beside its status."""
    library: Library3

    def __init__(self, library: Library3, component: int, messages: Counter[tuple[int, str]], number: int,
                 event_mode: bool):
        super().__init__(library, component, None, messages, number)
        self.event_mode = event_mode
        self.experiment: tuple[float, float | None] = 0.0, None
        self.event_needed = self.ends = self.early = False
        self.reached = self.until = nan

    def call(self, name: str, *arguments: Any) -> int:
        """Call fmi3`name`; its status."""
        if name == "EnterInitializationMode":
            start, stop = self.experiment
            arguments = False, 0.0, start, stop is not None, stop or 0.0
        name = name.replace("FMUstate", "FMUState").replace("DeSerialize", "Deserialize")
        return super().call(name, *arguments)

    def setup(self, start: float, stop: float | None = None) -> int:
        """Keep what fmi3EnterInitializationMode is told; times in s."""
        self.experiment = start, stop
        return OK

    def step(self, time: float, size: float) -> int:
        """fmi3DoStep from `time` over `size`, in s; its status."""
        flags = [c_bool(False) for _ in range(3)]
        reached = c_double(nan)
        status = self.call("DoStep", time, size, False, *map(byref, flags), byref(reached))
        self.event_needed, self.ends, self.early = (flag.value for flag in flags)
        self.reached, self.until, self.size = reached.value, time + size, size
        return status

    def complaints(self) -> list[tuple[str, str, str]]:
        """(rule, found, expected) of what the last step said and must not say."""
        found = []
        if self.event_needed and not self.event_mode:
            found.append(("dynamic.event-unasked", "eventHandlingNeeded, with eventModeUsed fmi3False",
                          "events handled inside the step"))
        if self.early:
            found.append(("dynamic.event-unasked", "earlyReturn, with earlyReturnAllowed fmi3False",
                          "the whole step"))
        elif not isfinite(self.reached) or abs(self.reached - self.until) > self.size:
            found.append(("dynamic.last-time", "lastSuccessfulTime is not set, or more than a step off",
                          "the time at the end of the step"))
        return found

    def update_discrete_states(self) -> tuple[int, bool]:
        """fmi3UpdateDiscreteStates; its status, and whether another round is needed."""
        flags = [c_bool(False) for _ in range(5)]
        status = self.call("UpdateDiscreteStates", *map(byref, flags), byref(c_double()))
        return status, flags[0].value

    # --- values ---------------------------------------------------------------------------------------

    def count(self, references: Sequence[int]) -> int:
        """How many values the variables have together."""
        return sum(self.library.counts.get(reference, 1) for reference in references)

    def get(self, base: str, references: Sequence[int]) -> tuple[int, list[Value]]:
        """fmi3GetFloat64, fmi3GetInt32, ... by `base`; its status, and the values, those of an array one by one.

        Binaries come back as hexadecimal text.
        """
        count = self.count(references)
        packed = (c_uint * len(references))(*references)
        if base == "Binary":
            return self.get_binary(packed, len(references), count)
        values = (TYPES[base] * count)()
        status = self.call(f"Get{base}", packed, len(references), values, count)
        return status, list(values)

    def get_binary(self, references: Any, n: int, count: int) -> tuple[int, list[Value]]:
        """fmi3GetBinary; its status, and the values as hexadecimal text."""
        sizes, values = (c_size_t * count)(), (c_void_p * count)()
        status = self.call("GetBinary", references, n, sizes, values, count)
        if status > WARNING:
            return status, [""] * count
        return status, [ctypes.string_at(value, size).hex() if value else "" for value, size in zip(values, sizes)]

    def get_packed(self, base: str, references: Any, count: int) -> tuple[int, bytes | list[Value]]:
        """The same of packed references: its status, and the bytes of the values; for texts the values."""
        if base == "Binary":
            return self.get_binary(references, len(references), count)
        values = (TYPES[base] * count)()
        status = self.call(f"Get{base}", references, len(references), values, count)
        return status, list(values) if base == "String" else bytes(values)

    def set(self, base: str, references: Sequence[int], values: Sequence[Value]) -> int:
        """fmi3SetFloat64, fmi3SetInt32, ... by `base`; its status. One value for an array fills it."""
        count = self.count(references)
        if len(values) != count:
            values = [value for reference, value in zip(references, values)
                      for _ in range(self.library.counts.get(reference, 1))]
        packed = (c_uint * len(references))(*references)
        if base == "Binary":
            data = [bytes.fromhex(value.decode() if isinstance(value, bytes) else str(value)) for value in values]
            pointers = (c_void_p * count)(*(ctypes.cast(c_char_p(one), c_void_p) for one in data))
            return self.call("SetBinary", packed, len(references), (c_size_t * count)(*map(len, data)), pointers, count)
        return self.call(f"Set{base}", packed, len(references), (TYPES[base] * count)(*values), count)

    def directional(self, unknown: int, known: int) -> tuple[int, float]:
        """The derivative of one variable with respect to one other (2.2.12.1)."""
        into, seeds = self.count([unknown]), self.count([known])
        result, seed = (c_double * into)(), (c_double * seeds)(*[1.0] * seeds)
        one = (c_uint * 1)(unknown), 1, (c_uint * 1)(known), 1
        return self.call("GetDirectionalDerivative", *one, seed, seeds, result, into), result[0]

    def output_derivative(self, reference: int) -> int:
        """fmi3GetOutputDerivatives of one output, first order; its status."""
        count = self.count([reference])
        return self.call("GetOutputDerivatives", (c_uint * 1)(reference), 1, (ctypes.c_int32 * 1)(1),
                         (c_double * count)(), count)

    def set_debug_logging(self, on: bool, categories: Sequence[str]) -> int:
        """fmi3SetDebugLogging; its status."""
        names = (c_char_p * len(categories))(*(name.encode() for name in categories)) if categories else None
        return self.call("SetDebugLogging", on, len(categories), names)
