"""A running instance of an FMU: its library loaded, calls go to the raw functions."""
import ctypes
from collections.abc import Iterable
from typing import Any

import fmpy
import numpy as np

from ..errors import RunError, UsageError
from . import last_call
from .fmu import FmuFile
from .library import Library
from .logger import ENVIRONMENTS, NUMBERS, Environment
from .program import DISCARD, DTYPES, FATAL, OK, WARNING
from .python_modules import make_way
from .standards import standard
from .system import Value

STATUS = ("OK", "Warning", "Discard", "Error", "Fatal", "Pending")
SIZE, ADDRESS = ctypes.c_size_t, ctypes.c_void_p
Alike = tuple[str, int, list[str], np.ndarray, list[str]]  # suffix, kind, names, references, types
ONLY_ONE: dict[str, str] = {}  # token of an FMU that allows one instance in a process -> the name of that instance


class Instance:
    """An instance of an FMU.

    Calls raise RunError if the FMU answers anything worse than a warning, and after it has answered Fatal.
    """

    def __init__(self, file: FmuFile, name: str):
        """Load the library and instantiate.

        Raises RunError if that fails, UsageError if the FMU allows one instance in a process and there is one.
        """
        self.file, self.name = file, name
        self.standard = standard(file.description.version)
        self.open, self.stepping, self.failed, self.uses_events = False, False, False, False
        self.events: np.ndarray | None = None        # its row of `wiring.events`
        self.given: dict[str, Value] = {}            # elements of arrays that have been set
        self.moved: dict[tuple[str, ...], list[Alike]] = {}
        self.only_one, self.token = self.claims("canBeInstantiatedOnlyOncePerProcess"), self.said(self.standard.TOKEN)
        if self.only_one and self.token in ONLY_ONE:
            raise UsageError(f"{self.label} cannot be instantiated beside {ONLY_ONE[self.token]}: the FMU allows only "
                             f"one instance in a process (canBeInstantiatedOnlyOncePerProcess).")
        self.number = next(NUMBERS)
        self.messages = ENVIRONMENTS.setdefault(self.number, Environment(name.encode())).messages
        make_way(file.folder)
        last_call.begin(f"{self.label}: {self.standard.PREFIX}Instantiate")
        try:
            self.library = Library(file.folder.resolve() / "binaries" / self.standard.PLATFORM
                                   / f"{file.identifier}{fmpy.sharedLibraryExtension}")
            made = self.standard.instantiate(self)
            if not made:
                raise OSError("Failed to instantiate model")
        except (OSError, AttributeError) as error:
            message = f" It said: {self.messages[-1]}" if self.messages else ""
            ENVIRONMENTS.pop(self.number)
            raise RunError(f"{self.label} cannot be instantiated: {error}{message}") from error
        finally:
            last_call.end()
        self.open = True
        if self.only_one:
            ONLY_ONE[self.token] = name
        self.component, self.pointer = ctypes.c_void_p(made), made

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

    def said(self, attribute: str) -> str:
        """An attribute of the FMU's description; empty if it has none."""
        return self.file.description.attributes.get(attribute, "")

    def claims(self, flag: str) -> bool:
        """Whether the FMU claims a capability, see `FmuFile.claims`."""
        return self.file.claims(flag)

    def function(self, name: str, *argument_types: Any) -> Any:
        """A C function of the library that takes the instance first and returns a status.

        Raises RunError if the FMU's library has none.
        """
        try:
            return self.library.function(name, ctypes.c_int, ctypes.c_void_p, *argument_types)
        except AttributeError:
            raise RunError(f"{self.label} has no {name} in its library.") from None

    def address(self, name: str) -> int:
        """Where the function is that the standard calls `name` after its prefix, such as DoStep.

        Raises RunError if the FMU's library has none.
        """
        name = self.standard.PREFIX + name
        try:
            return self.library.address(name)
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
        """Get or set variables of any type by name, one call per type; values in the order of `names`.

        Arrays move as a whole: elements that are not given are set to what they were set to last, or start with.
        """
        given = dict(zip(names, values)) if values is not None else {}
        if self.file.arrays:
            self.given.update((n, x) for n, x in given.items() if self.file.variables[n].array)
        result: dict[str, Any] = {}
        for suffix, kind, group, references, types in self.alike(names):
            buffer = np.zeros(len(group), DTYPES[kind])
            wanted = [given[n] if n in given else self.held(n) for n in group] if values is not None else []
            if values is not None and suffix == "String":
                texts = [ctypes.c_char_p(str(x).encode()) for x in wanted]  # alive until the call has returned
                buffer[:] = [ctypes.cast(t, ctypes.c_void_p).value or 0 for t in texts]
            elif values is not None:
                buffer = np.array(wanted, DTYPES[kind])
            call = f"{self.standard.PREFIX}{verb}{suffix}"
            arguments = ADDRESS(references.ctypes.data), SIZE(len(references)), ADDRESS(buffer.ctypes.data)
            status = self.call(call, *arguments, *([SIZE(len(group))] if self.standard.COUNTS_VALUES else []))
            self.check(status, f"{call}({', '.join(group[:3])}{', ...' if group[3:] else ''})")
            result.update(zip(group, shown(suffix, buffer.tolist(), types)))
        return [result[n] for n in names]

    def alike(self, names: list[str]) -> list[Alike]:
        """What one call each moves of the variables called `names`. Kept: runs and loops move the same again."""
        if (key := tuple(names)) not in self.moved:
            groups: dict[tuple[str, int] | None, list[str]] = {}
            for name in names:
                groups.setdefault(self.standard.TYPES.get(self.file.variable(name).type), []).append(name)
            self.moved[key] = [
                (suffix, kind, group, np.array(self.file.references(group), np.uint32),
                 [self.file.variables[n].type for n in group])
                for suffix, kind in dict.fromkeys(self.standard.TYPES.values()) if (suffix, kind) in groups
                for group in [self.file.together(groups[suffix, kind])]]
        return self.moved[key]

    def held(self, name: str) -> Value:
        """What an element of an array was set to last, or starts with."""
        return self.given.get(name, self.file.start(name))

    def get(self, names: Iterable[str]) -> list[Any]:
        """Values of the variables called `names`."""
        return self.transfer("Get", list(names), None)

    def set(self, values: dict[str, Value]) -> None:
        """Set variables by name; values must have been through `FmuFile.checked`."""
        self.transfer("Set", list(values), values.values())

    # --- life cycle -----------------------------------------------------------------------------------

    def enter(self, start: float, stop: float | None, tolerance: float | None = None) -> None:
        """From instantiated into Initialization Mode; times in s, without a stop if there is none; a relative
        tolerance if there is one."""
        self.standard.enter(self, start, stop, tolerance)

    def leave(self, start: float) -> None:
        """From Initialization Mode at `start` (s) to ready to step, in model exchange to Continuous-Time Mode."""
        self.standard.leave(self, start)

    def reset(self) -> None:
        """Back to instantiated."""
        self.simple(f"{self.standard.PREFIX}Reset")
        self.messages.clear()
        self.given.clear()

    def setup(self, start: float, stop: float | None, tolerance: float | None = None) -> None:
        """fmi2SetupExperiment; times in s."""
        real, flag = ctypes.c_double, ctypes.c_int
        status = self.call("fmi2SetupExperiment", flag(tolerance is not None), real(tolerance or 0.0), real(start),
                           flag(stop is not None), real(stop or 0.0))
        self.check(status, "fmi2SetupExperiment")

    def simple(self, call: str) -> None:
        """Make a call that takes nothing but the instance, such as fmi2EnterInitializationMode."""
        self.check(self.call(call), call)
        self.stepping = {"ExitInitializationMode": True, "Reset": False}.get(call[4:], self.stepping)
        self.failed = self.failed and not call.endswith("Reset")

    def ended_at(self, begun: float, until: float) -> float | None:
        """The time (s) at which the FMU ended the simulation in a step that it discarded, from `begun` to `until`.

        None if it did not, or does not say.
        """
        return self.standard.ended_at(self, begun, until)

    def free_state(self, place: int) -> None:
        """Free the state whose pointer is at the address `place`."""
        self.call(f"{self.standard.PREFIX}Free{self.standard.STATE}", ADDRESS(place))

    def saved(self) -> bytes:
        """The whole state of the FMU, to be given to `restore` of another instance of the same FMU.

        Raises RunError if the FMU refuses, or does not claim canSerializeFMUstate.
        """
        place, size = self.place_of_state(), SIZE()
        self.state_call("Get", place)
        try:
            self.state_call("Serialized", ctypes.c_void_p.from_address(place.value or 0), address_of(size), end="Size")
            found = ctypes.create_string_buffer(size.value)
            self.state_call("Serialize", ctypes.c_void_p.from_address(place.value or 0), address_of(found), size)
        finally:
            self.state_call("Free", place)
        return found.raw

    def restore(self, state: bytes) -> None:
        """Be in a state that `saved` has given.

        Raises RunError if the FMU refuses, or does not claim canSerializeFMUstate.
        """
        place, given = self.place_of_state(), ctypes.create_string_buffer(state, len(state))
        self.state_call(self.standard.DESERIALIZE, address_of(given), SIZE(len(state)), place)
        try:
            self.state_call("Set", ctypes.c_void_p.from_address(place.value or 0))
        finally:
            self.state_call("Free", place)

    def place_of_state(self) -> ctypes.c_void_p:
        """Where the pointer to a state is to be put. Raises RunError if states cannot be serialised."""
        if not self.claims("canSerializeFMUstate"):
            raise RunError(f"{self.label} cannot save its state: it does not claim can"
                           f"Serialize{self.standard.STATE}.")
        self.state = ctypes.c_void_p()
        return address_of(self.state)

    def state_call(self, verb: str, *arguments: Any, end: str = "") -> None:
        """Make a call about states, such as fmi2GetFMUstate."""
        call = f"{self.standard.PREFIX}{verb}{self.standard.STATE}{end}"
        self.check(self.call(call, *arguments), call)

    def close(self) -> None:
        """Terminate where the standard allows it, and free; after Fatal no call is allowed any more."""
        prefix = self.standard.PREFIX
        if self.alive and self.stepping and not self.failed:
            self.call(f"{prefix}Terminate")
        if self.alive:
            last_call.begin(f"{self.label}: {prefix}FreeInstance")
            self.library.function(f"{prefix}FreeInstance", None, ctypes.c_void_p)(self.component)
            if self.library.has("finalizePythonInterpreter"):
                # pythonfmu 0.7.0 does this as its library goes, after its static objects: a write to freed memory that
                # can abort the process at its end. Done before, it finds nothing to do. The interpreter stays.
                self.library.function("finalizePythonInterpreter", None)()
            self.library.free()
            last_call.end()
            ENVIRONMENTS.pop(self.number)
        if self.open and self.only_one:
            ONLY_ONE.pop(self.token)
        self.open = False


def address_of(value: Any) -> ctypes.c_void_p:
    """Where a ctypes value is."""
    return ctypes.c_void_p(ctypes.addressof(value))


def shown(suffix: str, values: list[Any], types: list[str]) -> list[Any]:
    """What fmi2Get... has left in a buffer, in the variables' types; a null pointer is an empty text."""
    if suffix == "String":
        return [ctypes.string_at(x).decode("utf-8", "replace") if x else "" for x in values]
    return [bool(x) if kind == "Boolean" else x for x, kind in zip(values, types)]
