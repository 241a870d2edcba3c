"""One FMU file loaded through fmpy: what it declares, and an instance of it."""
import ctypes
import hashlib
import math
import shutil
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path, PurePosixPath
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

from ..errors import RunError, UsageError, did_you_mean
from ..text import printable
from . import last_call
from .declared import Variable
from .description import Description, read, usable
from .parameter_set import parameters
from .quantities import in_unit_of
from .system import Value
from .unpack import BadArchive, open_archive, read_member, safe_extract
from .xml_file import SSV, parse

OK, WARNING, DISCARD, ERROR, FATAL = range(5)
STATUS = ("OK", "Warning", "Discard", "Error", "Fatal", "Pending")
CTYPES = {"Real": ctypes.c_double, "Integer": ctypes.c_int, "Boolean": ctypes.c_int, "Enumeration": ctypes.c_int}
SUFFIX = {"Real": "Real", "Integer": "Integer", "Enumeration": "Integer", "Boolean": "Boolean"}
CALL_SUFFIX = {**SUFFIX, "String": "String"}

MESSAGES: dict[str, list[str]] = {}  # instance name -> its messages of a status worse than OK
MOST_MESSAGES = 1000


def log(_environment: Any, instance: bytes, status: int, _category: bytes, message: bytes) -> None:
    """The logger of all instances: keeps messages that are worse than OK."""
    kept = MESSAGES.setdefault(instance.decode("utf-8", "replace"), [])
    if status > OK:
        text = message.decode("utf-8", "replace")
        last_call.logged(text)
        if len(kept) < MOST_MESSAGES:
            kept.append(text)


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


def existing(path: Path) -> Path:
    """`path` itself. Raises UsageError if there is no such file."""
    if not path.is_file():
        raise UsageError(f"There is no FMU at {path}; `ahv build` writes the FMUs of this project.")
    return path


def preset(path: str | Path, name: str) -> dict[str, Value]:
    """The values of the preset `name`, an SSP parameter set that the FMU at `path` carries in its resources.

    Raises UsageError if there is no such FMU or no such preset.
    """
    path = existing(Path(path))
    try:
        with open_archive(path) as archive:
            members = {PurePosixPath(m).stem: m for m in sorted(archive.namelist())
                       if m.startswith("resources/presets/") and m.endswith(".ssv")}
        if name not in members:
            raise UsageError(f"{path.name} has no preset {name}; it has {', '.join(members) or 'none'}.")
        found = parse(read_member(path, members[name]), f"{members[name]} of {path.name}", SSV + "ParameterSet")
        description = usable(read_member(path, "modelDescription.xml"))
    except (BadArchive, ValueError) as error:
        raise UsageError(f"{path} cannot be read as an FMU: {error}.") from None
    variables = {v.name: v for v in description.variables}
    return {key: given.for_variable(v, description.unit_of(v) if v else None, key)
            for key, given in parameters(found) for v in [variables.get(key)]}


def settable(v: Variable) -> bool:
    """True if `v` may be set before initialisation (FMI 2.0 section 2.2.7)."""
    return v.variability != "constant" and (v.causality in ("parameter", "structuralParameter", "input")
                                           or v.initial in ("exact", "approx"))


@dataclass
class FmuFile:
    """An extracted FMU. Use as a context manager: the extraction folder goes with it."""
    path: Path
    folder: Path
    description: Description
    sha256: str
    variables: dict[str, Variable] = field(init=False)

    def __post_init__(self) -> None:
        self.variables = {v.name: v for v in self.description.variables}

    @classmethod
    def open(cls, path: Path) -> "FmuFile":
        """Extract and read `path`.

        Raises UsageError if it is missing or no FMI 2.0 co-simulation FMU.
        """
        existing(path)
        folder = Path(tempfile.mkdtemp(prefix="ahv_"))
        try:
            safe_extract(path, folder)
            description = read(folder)
        except BadArchive as error:
            shutil.rmtree(folder, ignore_errors=True)
            raise UsageError(f"{path} cannot be opened: {error}.") from None
        except ValueError as error:
            shutil.rmtree(folder, ignore_errors=True)
            raise UsageError(f"{path} cannot be read as an FMU: {error}.") from None
        if description.version != "2.0" or description.co_simulation is None:
            shutil.rmtree(folder, ignore_errors=True)
            raise UsageError(f"{path} is FMI {description.version} or has no co-simulation interface; "
                             f"FMI 2.0 co-simulation is what runs here.")
        identifier = description.coSimulation.modelIdentifier or ""
        if not identifier.isprintable() or set(identifier) & set("/\\"):  # it names the library that is loaded
            shutil.rmtree(folder, ignore_errors=True)
            raise UsageError(f"{path} cannot be opened: its modelIdentifier '{printable(identifier)}' is no name of a "
                             f"file in the FMU.")
        return cls(path, folder, description, hashlib.sha256(path.read_bytes()).hexdigest())

    def __enter__(self) -> "FmuFile":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Remove the extracted files."""
        shutil.rmtree(self.folder, ignore_errors=True)

    def variable(self, name: str) -> Variable:
        """The variable called `name`; UsageError suggests the nearest one if there is none."""
        if name not in self.variables:
            raise UsageError(f"{self.path.name} has no variable {name}{did_you_mean(name, self.variables)}")
        return self.variables[name]

    @property
    def identifier(self) -> str:
        """modelIdentifier of the co-simulation interface, which also names the binaries."""
        return (self.description.co_simulation or {}).get("modelIdentifier", "")

    def names(self, causality: str) -> list[str]:
        """The variables of a causality, in the order of the description."""
        return [v.name for v in self.description.variables if v.causality == causality]

    def preset(self, name: str) -> dict[str, Value]:
        """The values of a preset, see `preset`."""
        return preset(self.path, name)

    def checked(self, name: str, value: Value, component: str) -> Value:
        """`value` in the type of the variable `name`; UsageError if it may not be set to that."""
        v = self.variable(name)
        full = f"{component}.{name}"
        if not settable(v):
            raise UsageError(f"{full} is an {v.causality} and cannot be set.")
        if v.type == "String":
            return str(value)
        if v.type == "Boolean":
            words = {"true": True, "1": True, "1.0": True, "false": False, "0": False, "0.0": False}
            if str(value).lower() not in words:
                raise UsageError(f"{full} = {value} is not allowed: it is true or false.")
            return words[str(value).lower()]
        if isinstance(value, str):
            value = in_unit_of(v, self.description, value, full)
        try:
            number = float(value)
        except (TypeError, ValueError):
            raise UsageError(f"{full} = {value} is not allowed: it must be a number.") from None
        low = -math.inf if v.min is None else v.min
        high = math.inf if v.max is None else v.max
        if not math.isfinite(number) or not low <= number <= high:
            unit = f" {v.unit}" if v.unit and v.unit != "1" else ""
            raise UsageError(f"{full} = {value} is not allowed: it must be between {low:g} and {high:g}{unit}.")
        if v.type == "Real":
            return number
        if number != int(number):
            raise UsageError(f"{full} = {value} is not allowed: it must be a whole number.")
        return int(number)


class Instance:
    """A running instance of an FMU: fmpy loads and instantiates it, calls go to the raw functions.

    Calls raise RunError if the FMU answers anything worse than a warning.
    """

    def __init__(self, file: FmuFile, name: str):
        self.file, self.name = file, name
        self.alive, self.stepping, self.failed = True, False, False
        self.messages = MESSAGES[name] = []
        attributes = file.description.attributes
        last_call.note(f"{name} ({file.path.name}): fmi2Instantiate")
        try:
            self.slave = FMU2Slave(guid=attributes.get("guid", ""), unzipDirectory=str(file.folder), instanceName=name,
                                   modelIdentifier=file.identifier)
            self.slave.instantiate(callbacks=CALLBACKS, loggingOn=True)
        except Exception as error:
            message = f" It said: {self.messages[-1]}" if self.messages else ""
            raise RunError(f"{name} ({file.path.name}) cannot be instantiated: {error}{message}") from error
        self.component = ctypes.c_void_p(self.slave.component)
        self.pointer = int(self.slave.component)
        self.do_step = self.function("fmi2DoStep", ctypes.c_double, ctypes.c_double, ctypes.c_int)

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
            raise RunError(f"{self.name} ({self.file.path.name}) claims {name}, and its library lacks it.") from None

    def accessor(self, verb: str, kind: str) -> Any:
        """The raw fmi2Get.../fmi2Set... function of a variable type."""
        return self.function(f"fmi2{verb}{SUFFIX[kind]}", ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p)

    def check(self, status: int, call: str, time: float | None = None) -> None:
        """Raise RunError unless `status` is OK or Warning, with the FMU's last message."""
        if status <= WARNING:
            return
        self.alive, self.failed = status != FATAL, status >= ERROR
        when = "" if time is None else f" at t = {time:.6g} s"
        reason = self.messages[-1] if self.messages else "and gave no reason"
        raise RunError(f"{self.name} ({self.file.path.name}) answered {STATUS[status]} to {call}{when}: {reason}")

    def transfer(self, verb: str, names: Iterable[str], values: Iterable[Value] | None) -> list[Any]:
        """Get or set variables of any type by name, one call per type; values in the order of `names`."""
        names = list(names)
        given = dict(zip(names, values)) if values is not None else {}
        result: dict[str, Any] = {}
        for kind in CTYPES:
            group = [n for n in names if self.file.variable(n).type == kind]
            if not group:
                continue
            references = np.array([self.file.variables[n].reference for n in group], dtype=np.uint32)
            buffer = np.zeros(len(group), dtype=np.float64 if kind == "Real" else np.int32)
            buffer[:] = [given[n] for n in group] if given else 0
            last_call.note(f"{self.name} ({self.file.path.name}): fmi2{verb}{SUFFIX[kind]}")
            status = self.accessor(verb, kind)(self.component, references.ctypes.data, len(group), buffer.ctypes.data)
            self.check(status, f"fmi2{verb}{SUFFIX[kind]}({', '.join(group[:3])}{', ...' if group[3:] else ''})")
            result.update(zip(group, (bool(x) for x in buffer) if kind == "Boolean" else buffer.tolist()))
        return [result[n] for n in names if n in result]

    def get(self, names: Iterable[str]) -> list[Any]:
        """Values of the variables called `names` (strings are left out)."""
        return self.transfer("Get", names, None)

    def get_any(self, names: list[str]) -> list[Any]:
        """Values of variables of any type, strings too."""
        texts = [n for n in names if self.file.variable(n).type == "String"]
        found = dict(zip(texts, self.slave.getString([self.file.variables[n].reference for n in texts]))
                     if texts else ())
        found = {n: x.decode("utf-8", "replace") if isinstance(x, bytes) else x for n, x in found.items()}
        numbers = [n for n in names if n not in found]
        found.update(zip(numbers, self.get(numbers)))
        return [found[n] for n in names]

    def free_state(self, place: int) -> None:
        """fmi2FreeFMUstate of the state whose pointer is at the address `place`."""
        self.function("fmi2FreeFMUstate", ctypes.c_void_p)(self.component, place)

    def set(self, values: dict[str, Value]) -> None:
        """Set variables by name; values must have been through `FmuFile.checked`."""
        strings = {n: str(x) for n, x in values.items() if self.file.variable(n).type == "String"}
        if strings:
            self.slave.setString([self.file.variables[n].reference for n in strings], list(strings.values()))
        numbers = {n: x for n, x in values.items() if n not in strings}
        self.transfer("Set", numbers, numbers.values())

    def setup(self, start: float, stop: float) -> None:
        """fmi2SetupExperiment; times in s."""
        flag = ctypes.c_int
        call = self.function("fmi2SetupExperiment", flag, ctypes.c_double, ctypes.c_double, flag, ctypes.c_double)
        self.check(call(self.component, 0, 0.0, start, 1, stop), "fmi2SetupExperiment")

    def simple(self, call: str) -> None:
        """Make a call that takes nothing but the instance, such as fmi2EnterInitializationMode."""
        last_call.note(f"{self.name} ({self.file.path.name}): {call}")
        self.check(self.function(call)(self.component), call)
        self.stepping = {"fmi2ExitInitializationMode": True, "fmi2Reset": False}.get(call, self.stepping)
        self.failed = self.failed and call != "fmi2Reset"

    def close(self) -> None:
        """Terminate where the standard allows it, and free; after Fatal no call is allowed any more."""
        if self.alive:
            if self.stepping and not self.failed:
                self.function("fmi2Terminate")(self.component)
            self.slave.fmi2FreeInstance(self.slave.component)
            if hasattr(self.slave.dll, "finalizePythonInterpreter"):
                # pythonfmu 0.7.0 does this as its library goes, after its static objects: a write to freed memory that
                # can abort the process at its end. Done before, it finds nothing to do. The interpreter stays.
                self.slave.dll.finalizePythonInterpreter()
            self.slave.freeLibrary()
        self.alive = False
