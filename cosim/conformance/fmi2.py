"""The C functions of an FMI 2.0 shared library, called raw: every status comes back, nothing is checked here.

Runs in the child process only. Before each call its name and a counter go to a small shared file, so that the parent
knows which call crashed or hangs. Sections 2.1 and 4.2 give the signatures.
"""
import ctypes
import mmap
import os
import struct
import sys
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import suppress
from ctypes import POINTER, byref, c_char_p, c_double, c_int, c_size_t, c_uint, c_void_p
from importlib.util import find_spec
from math import nan
from pathlib import Path
from typing import Any

OK, WARNING, DISCARD, ERROR, FATAL, PENDING = range(6)
LAST_SUCCESSFUL_TIME = 2  # of fmi2StatusKind
STATUS = ("fmi2OK", "fmi2Warning", "fmi2Discard", "fmi2Error", "fmi2Fatal", "fmi2Pending")

MOST_WORDS = 300  # characters of a message that are shown
MARK_BYTES = 72  # a counter and the name of the call, see `Mark`

LOGGER = ctypes.CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p)
ALLOCATE = ctypes.CFUNCTYPE(c_void_p, c_size_t, c_size_t)
FREE = ctypes.CFUNCTYPE(None, c_void_p)
REFERENCES = POINTER(c_uint)
C_TYPES: dict[str, Any] = {"Real": c_double, "Integer": c_int, "Boolean": c_int, "String": c_char_p}

Value = float | int | str | bytes | None


class Callbacks(ctypes.Structure):
    """fmi2CallbackFunctions."""
    _fields_ = (("logger", LOGGER), ("allocateMemory", ALLOCATE), ("freeMemory", FREE), ("stepFinished", c_void_p),
                ("componentEnvironment", c_void_p))


SIGNATURES: dict[str, tuple[Any, ...]] = {
    "SetDebugLogging": (c_int, c_size_t, POINTER(c_char_p)),
    "SetupExperiment": (c_int, c_double, c_double, c_int, c_double),
    "EnterInitializationMode": (),
    "ExitInitializationMode": (),
    "Terminate": (),
    "Reset": (),
    "DoStep": (c_double, c_double, c_int),
    "GetFMUstate": (POINTER(c_void_p),),
    "SetFMUstate": (c_void_p,),
    "FreeFMUstate": (POINTER(c_void_p),),
    "SerializedFMUstateSize": (c_void_p, POINTER(c_size_t)),
    "SerializeFMUstate": (c_void_p, c_char_p, c_size_t),
    "DeSerializeFMUstate": (c_char_p, c_size_t, POINTER(c_void_p)),
    "GetDirectionalDerivative": (REFERENCES, c_size_t, REFERENCES, c_size_t, POINTER(c_double), POINTER(c_double)),
    "SetRealInputDerivatives": (REFERENCES, c_size_t, POINTER(c_int), POINTER(c_double)),
    "GetRealStatus": (c_int, POINTER(c_double)),
    "GetRealOutputDerivatives": (REFERENCES, c_size_t, POINTER(c_int), POINTER(c_double)),
}
for _type, _c_type in C_TYPES.items():
    SIGNATURES[f"Get{_type}"] = SIGNATURES[f"Set{_type}"] = (REFERENCES, c_size_t, POINTER(_c_type))


class Mark:
    """A file in shared memory that tells the current call: a counter (8 bytes) and the function's name (64 bytes)."""

    def __init__(self, file: Path):
        with file.open("r+b") as opened:
            self.memory = mmap.mmap(opened.fileno(), MARK_BYTES)
        self.count = 0

    def set(self, call: str) -> None:
        """Note the call that comes next."""
        self.count += 1
        self.memory[:] = struct.pack("<Q64s", self.count, call.encode())

    @staticmethod
    def read(file: Path) -> tuple[int, str]:
        """The counter and the name of the last call, for the parent; no name if the FMU spoilt the file."""
        try:
            count, call = struct.unpack("<Q64s", file.read_bytes()[:MARK_BYTES])
        except (OSError, struct.error):
            return 0, "a call"
        return count, call.rstrip(b"\0").decode("utf-8", "replace")


def packed_references(references: Sequence[int]) -> Any:
    """Value references as a C array."""
    return (c_uint * len(references))(*references)


def formatter() -> Callable[[Any], object]:
    """What lets a C function fill in the numbers and names of messages: fmpy's, where it is there (ctypes cannot)."""
    folders = getattr(find_spec("fmpy"), "submodule_search_locations", None)
    platform = {"nt": "win64"}.get(os.name, "darwin64" if sys.platform == "darwin" else "linux64")
    for file in Path(folders[0], "logging", platform).glob("logging.*") if folders else ():
        with suppress(OSError, AttributeError):
            return ctypes.CDLL(str(file)).addLoggerProxy  # type: ignore[no-any-return]
    return lambda _callbacks: None


class Library:
    """A loaded shared library."""
    prefix = "fmi2"
    types = C_TYPES
    signatures = SIGNATURES

    def __init__(self, file: Path, mark: Mark):
        self.mark = mark
        self.is_corrupt = False  # after fmi2Fatal no function of any instance may be called (2.1.3)
        mark.set("loading the library")
        self.dll = ctypes.CDLL(str(file))
        libc = ctypes.CDLL("msvcrt") if os.name == "nt" else ctypes.CDLL(None)
        self.allocate = ALLOCATE(("calloc", libc))  # type: ignore[arg-type]
        self.free_memory = FREE(("free", libc))  # type: ignore[arg-type]
        self.messages: dict[int, Counter[tuple[int, str]]] = {}  # by instance
        self.made = self.lived = 0  # how many instances were asked for, and how many there were
        self.names: dict[int, str] = {}  # of instances
        self.strange: dict[str, str] = {}  # environment, name: what the logger got instead of the instance's own
        self.words = ""  # the last message of a problem
        self.logger = LOGGER(self.take_message)  # one for all instances: it must outlive each of them
        self.format_messages = formatter()

    def take_message(self, environment: int | None, name: bytes | None, status: int, category: bytes | None,
                     message: bytes | None) -> None:
        """Count a message of the instance `environment`; without one, of the last that was made."""
        number = environment or 0
        if number not in self.messages:
            self.strange["environment"] = "a null pointer" if environment is None else "another pointer"
            number = self.made
        if (told := (name or b"").decode("utf-8", "replace")) != self.names.get(number, told):
            self.strange["name"] = f"'{told}'"
        self.messages.setdefault(number, Counter())[status, (category or b"").decode("utf-8", "replace")] += 1
        if status != OK and message:
            self.words = " ".join(message.decode("utf-8", "replace").split())[:MOST_WORDS]

    def unpacked(self, base: str, packed: bytes | list[Value]) -> list[Value]:
        """What `Instance.get_packed` gave, as values."""
        if isinstance(packed, list):
            return packed
        return list((self.types[base] * (len(packed) // ctypes.sizeof(self.types[base]))).from_buffer_copy(packed))

    def text(self, name: str) -> str:
        """What fmi2GetVersion or fmi2GetTypesPlatform returns; `name` without the prefix."""
        self.mark.set(f"{self.prefix}{name}")
        function = getattr(self.dll, f"{self.prefix}{name}")
        function.restype = c_char_p
        return (function() or b"").decode("utf-8", "replace")

    def instantiate(self, name: str, guid: str, resources: str, logging_on: bool = False) -> "Instance | None":
        """fmi2Instantiate (2.1.5); None when the FMU returned a null pointer."""
        self.made = number = self.made + 1
        messages = self.messages[number] = Counter()
        self.names[number] = name
        self.words = ""
        callbacks = Callbacks(self.logger, self.allocate, self.free_memory, None, number)
        self.format_messages(byref(callbacks))
        self.mark.set("fmi2Instantiate")
        function = self.dll.fmi2Instantiate
        function.restype = c_void_p
        function.argtypes = (c_char_p, c_int, c_char_p, c_char_p, POINTER(Callbacks), c_int, c_int)
        component = function(name.encode(), 1, guid.encode(), resources.encode(), byref(callbacks), 0, int(logging_on))
        self.lived += component is not None
        return Instance(self, component, callbacks, messages, number) if component else None

    def free(self, component: int | None) -> None:
        """fmi2FreeInstance (2.1.5), also of a null pointer."""
        self.mark.set(f"{self.prefix}FreeInstance")
        function = getattr(self.dll, f"{self.prefix}FreeInstance")
        function.restype, function.argtypes = None, (c_void_p,)
        function(component)

    def call(self, component: int, name: str, *arguments: Any) -> int:
        """Call the function `name`, without its prefix, for an instance; its status."""
        self.mark.set(f"{self.prefix}{name}")
        function = getattr(self.dll, f"{self.prefix}{name}")
        function.restype, function.argtypes = c_int, (c_void_p, *self.signatures[name])
        status = int(function(component, *arguments))
        self.is_corrupt |= status == FATAL
        return status


class Instance:
    """One instance: `call("Terminate")` and the like return the status; `messages` counts what it logged."""

    def __init__(self, library: Library, component: int, callbacks: Any, messages: Counter[tuple[int, str]],
                 number: int):
        self.library, self.component, self.callbacks, self.number = library, component, callbacks, number
        self.messages = messages

    def call(self, name: str, *arguments: Any) -> int:
        """Call fmi2`name`; its status."""
        return self.library.call(self.component, name, *arguments)

    def free(self) -> None:
        """fmi2FreeInstance, unless no call is allowed any more."""
        if not self.library.is_corrupt:
            self.library.free(self.component)
        self.library.messages.pop(self.number, None)
        self.library.names.pop(self.number, None)

    def setup(self, start: float, stop: float | None = None) -> int:
        """fmi2SetupExperiment; its status. Times in s."""
        return self.call("SetupExperiment", 0, 0.0, start, int(stop is not None), stop or 0.0)

    def step(self, time: float, size: float) -> int:
        """fmi2DoStep from `time` over `size`, in s; its status."""
        return self.call("DoStep", time, size, 0)

    def get(self, base: str, references: Sequence[int]) -> tuple[int, list[Value]]:
        """fmi2GetReal, fmi2GetInteger, ... by `base`; its status, and the values.

        Strings come back as bytes, or None for a null pointer.
        """
        values = (C_TYPES[base] * len(references))()
        status = self.call(f"Get{base}", (c_uint * len(references))(*references), len(references), values)
        return status, list(values)

    def get_packed(self, base: str, references: Any, count: int) -> tuple[int, bytes | list[Value]]:
        """The same of packed references: its status, and the bytes of the values; for strings the values."""
        values = (C_TYPES[base] * count)()
        status = self.call(f"Get{base}", references, count, values)
        return status, list(values) if base == "String" else bytes(values)

    def set(self, base: str, references: Sequence[int], values: Sequence[Value]) -> int:
        """fmi2SetReal, fmi2SetInteger, ... by `base`; its status."""
        packed = (C_TYPES[base] * len(values))(*values)
        return self.call(f"Set{base}", (c_uint * len(references))(*references), len(references), packed)

    def get_state(self) -> tuple[int, c_void_p]:
        """fmi2GetFMUstate; its status, and the state."""
        state = c_void_p()
        return self.call("GetFMUstate", byref(state)), state

    def set_state(self, state: c_void_p) -> int:
        """fmi2SetFMUstate; its status."""
        return self.call("SetFMUstate", state)

    def free_state(self, state: c_void_p) -> int:
        """fmi2FreeFMUstate; its status."""
        return self.call("FreeFMUstate", byref(state))

    def serialize(self, state: c_void_p) -> tuple[int, bytes]:
        """fmi2SerializeFMUstate; its status, and the bytes."""
        size = c_size_t()
        status = self.call("SerializedFMUstateSize", state, byref(size))
        if status > WARNING:
            return status, b""
        buffer = ctypes.create_string_buffer(size.value)
        return self.call("SerializeFMUstate", state, buffer, size.value), buffer.raw

    def deserialize(self, data: bytes) -> tuple[int, c_void_p]:
        """fmi2DeSerializeFMUstate; its status, and the state."""
        state = c_void_p()
        return self.call("DeSerializeFMUstate", data, len(data), byref(state)), state

    def directional(self, unknown: int, known: int) -> tuple[int, float]:
        """The derivative of one variable with respect to one other (2.1.9)."""
        result = (c_double * 1)()
        one = (c_uint * 1)(unknown), 1, (c_uint * 1)(known), 1
        return self.call("GetDirectionalDerivative", *one, (c_double * 1)(1.0), result), result[0]

    def input_derivative(self, reference: int, value: float) -> int:
        """fmi2SetRealInputDerivatives of one input, first order; its status."""
        return self.call("SetRealInputDerivatives", (c_uint * 1)(reference), 1, (c_int * 1)(1), (c_double * 1)(value))

    def output_derivative(self, reference: int) -> int:
        """fmi2GetRealOutputDerivatives of one output, first order; its status."""
        return self.call("GetRealOutputDerivatives", (c_uint * 1)(reference), 1, (c_int * 1)(1), (c_double * 1)())

    def last_successful_time(self) -> tuple[int, float]:
        """fmi2GetRealStatus of fmi2LastSuccessfulTime; its status, and the time (s)."""
        time = c_double(nan)
        return self.call("GetRealStatus", LAST_SUCCESSFUL_TIME, byref(time)), time.value

    def set_debug_logging(self, on: bool, categories: Sequence[str]) -> int:
        """fmi2SetDebugLogging; its status."""
        names = (c_char_p * len(categories))(*(name.encode() for name in categories))
        return self.call("SetDebugLogging", int(on), len(categories), names)
