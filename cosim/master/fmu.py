"""One FMU file: what it declares."""
import hashlib
import math
import re
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from functools import cached_property
from os.path import isfile
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np

from ..errors import UsageError, did_you_mean
from ..temporary import Folder
from ..text import printable
from .declared import NUMERIC, Variable, is_true
from .description import Description, read, usable
from .parameter_set import parameters
from .program import DTYPES
from .quantities import in_unit_of
from .standards import standard
from .system import Value
from .unpack import BadArchive, open_archive, read_member, safe_extract
from .xml_file import SSV, parse

VERSIONS = re.compile(r"2\.0|3\.\d+(\.\d+)?")


def existing(path: Path) -> Path:
    """`path` itself. Raises UsageError if there is no such file."""
    if not isfile(path):
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


def text(value: str, name: str) -> str:
    """`value` itself. Raises UsageError, calling it `name`, if it cannot be handed on as a C string of UTF-8."""
    if "\0" in value or any("\ud800" <= c <= "\udfff" for c in value):
        raise UsageError(f"{name} = {value!r} is not allowed: it must be UTF-8 text without null characters.")
    return value


def limits(version: str, kind: str) -> tuple[float, float]:
    """The least and the greatest value of a number of this type in this version of FMI."""
    dtype: Any = DTYPES[standard(version).TYPES[kind][1]]
    if np.issubdtype(dtype, np.floating):
        return float(np.finfo(dtype).min), float(np.finfo(dtype).max)
    return int(np.iinfo(dtype).min), int(np.iinfo(dtype).max)


def unflyable(description: Description, exchange: bool = False) -> str:
    """Why an FMU cannot be flown here, a sentence without its subject and full stop; empty if it can. With `exchange`,
    why its equations cannot be read."""
    version, kind = description.version, "model-exchange" if exchange else "co-simulation"
    served = f"{kind} FMUs of FMI 2.0 and 3.0 are what {'is read' if exchange else 'runs'} here"
    if not VERSIONS.fullmatch(version):
        return f"is FMI {version}; {served}"
    if (description.model_exchange if exchange else description.co_simulation) is None:
        return f"is FMI {version} without {kind.replace('model-e', 'model e')}; {served}"
    clock = next((v for v in description.variables if v.type == "Clock" and v.causality == "input"), None)
    return f"needs its clock {clock.name} to tick; input clocks are not served here" if clock else ""


NEEDLESS = ("sources/", "documentation/")  # of an archive, for who flies it: half of all files of a native FMU


@dataclass
class FmuFile:
    """An extracted FMU. Use as a context manager: the extraction folder goes with it.

    `corrupted` is set when an instance answers Fatal: no function of any of its instances may be called then.
    """
    path: Path
    extracted: Folder
    description: Description
    sha256: str
    scalars: list[Variable] = field(init=False)         # in the description's order, arrays as their elements
    variables: dict[str, Variable] = field(init=False)  # those and, of FMI 3.0, the aliases, by name
    arrays: dict[str, list[str]] = field(init=False)    # of FMI 3.0: the names of their elements, in order
    listed: dict[str, list[str]] = field(init=False)    # causality -> the names of its variables
    corrupted: bool = False
    exchange: bool = False  # its model-exchange interface is used, not co-simulation

    def __post_init__(self) -> None:
        self.scalars = [v for one in self.description.variables for v in one.elements()]
        self.variables = {v.name: v for v in self.scalars}
        for alias in self.description.aliases:
            self.variables.update((v.name, v) for v in alias.elements() if v.name not in self.variables)
        self.listed = {}
        for v in self.scalars:
            self.listed.setdefault(v.causality, []).append(v.name)
        self.arrays = {}
        for v in self.variables.values():
            if v.array:
                self.arrays.setdefault(v.array, []).append(v.name)

    @classmethod
    def open(cls, path: Path, exchange: bool = False, to_fly: bool = False) -> "FmuFile":
        """Extract and read `path`, for co-simulation or for model exchange; `to_fly` leaves out what no binary reads.

        Raises UsageError if it is missing, no such FMU of FMI 2.0 or 3.0, or needs clocks.
        """
        existing(path)
        folder = Folder()
        try:
            safe_extract(path, folder.path, needless=NEEDLESS if to_fly else ())
            description = read(folder.path)
            if reason := unflyable(description, exchange):
                raise UsageError(f"{path} {reason}.")
            found = cls(path, folder, description, hashlib.sha256(path.read_bytes()).hexdigest(), exchange=exchange)
            found.check_identifier()
            return found
        except BadArchive as error:
            folder.close()
            raise UsageError(f"{path} cannot be opened: {error}.") from None
        except ValueError as error:
            folder.close()
            raise UsageError(f"{path} cannot be read as an FMU: {error}.") from None
        except BaseException:
            folder.close()
            raise

    def __enter__(self) -> "FmuFile":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Remove the extracted files."""
        self.extracted.close()

    @property
    def folder(self) -> Path:
        """Where it is extracted."""
        return self.extracted.path

    def variable(self, name: str) -> Variable:
        """The variable called `name`; UsageError suggests the nearest one if there is none."""
        if name in self.arrays:
            first, *_, last = *self.arrays[name], self.arrays[name][-1]
            raise UsageError(f"{self.path.name} has the array {name}: name one of its elements, {first} to {last}.")
        if name not in self.variables:
            raise UsageError(f"{self.path.name} has no variable {name}{did_you_mean(name, self.variables)}")
        return self.variables[name]

    @property
    def identifier(self) -> str:
        """modelIdentifier of the interface that is used, which also names the binaries."""
        used = self.description.model_exchange if self.exchange else self.description.co_simulation
        return (used or {}).get("modelIdentifier", "")

    def check_identifier(self) -> None:
        """Raise UsageError if the identifier, which names the library that is loaded, is no name of a file."""
        name = self.identifier
        if not name.isprintable() or set(name) & set("/\\"):
            raise UsageError(f"{self.path} cannot be opened: its modelIdentifier '{printable(name)}' is no name of a "
                             f"file in the FMU.")

    def for_exchange(self) -> "FmuFile":
        """The same file with its model-exchange interface in use. Raises UsageError as `open` does."""
        if reason := unflyable(self.description, exchange=True):
            raise UsageError(f"{self.path} {reason}.")
        found = replace(self, exchange=True)
        found.check_identifier()
        return found

    def claims(self, flag: str) -> bool:
        """Whether the interface that is used claims a capability (FMI 2.0 section 4.3.1), by its name in FMI 2.0."""
        return self.description.claims(flag, self.exchange)

    def names(self, causality: str) -> list[str]:
        """The variables of a causality, in the order of the description, arrays as their elements."""
        return [*self.listed.get(causality, ())]

    @cached_property
    def parameters(self) -> list[str]:
        """The parameters of any kind that are numbers or truth values."""
        return [n for causality in ("structuralParameter", "parameter", "calculatedParameter")
                for n in self.names(causality) if self.variables[n].family in NUMERIC]

    def together(self, names: Iterable[str]) -> list[str]:
        """`names` with all elements of the arrays that they are in, which one call moves: each array's in a row."""
        found: dict[str, None] = {}
        for name in names:
            found.update(dict.fromkeys(self.arrays.get(self.variables[name].array, [name])))
        return list(found)

    def references(self, names: Iterable[str]) -> list[int]:
        """The value references of `names`, which have whole arrays in a row; one of each array."""
        return [v.reference or 0 for v in map(self.variables.__getitem__, names) if v.place == 0]

    def start(self, name: str) -> Value:
        """The start value of a variable in its type; 0, false or an empty text without a sensible one."""
        v = self.variables[name]
        if v.family == "String":
            return v.start or ""
        if v.family == "Boolean":
            return is_true(v.start)
        try:
            return float(v.start or 0.0) if v.family == "Real" else int(v.start or 0)
        except ValueError:
            return 0

    def preset(self, name: str) -> dict[str, Value]:
        """The values of a preset, see `preset`."""
        return preset(self.path, name)

    def checked(self, name: str, value: Value, component: str) -> Value:
        """`value` in the type of the variable `name`; UsageError if it may not be set to that."""
        v = self.variable(name)
        full = f"{component}.{name}"
        if not settable(v):
            raise UsageError(f"{full} is an {v.causality} and cannot be set.")
        if v.family in ("Binary", "Clock"):
            raise UsageError(f"{full} is a {v.family}, which cannot be set here.")
        if v.causality == "structuralParameter":
            raise UsageError(f"{full} is a structural parameter: sizes are flown as the FMU declares them.")
        if v.family == "String":
            return text(str(value), full)
        if v.family == "Boolean":
            words = {"true": True, "1": True, "1.0": True, "false": False, "0": False, "0.0": False}
            if str(value).lower() not in words:
                raise UsageError(f"{full} = {value} is not allowed: it is true or false.")
            return words[str(value).lower()]
        if isinstance(value, str):
            value = in_unit_of(v, self.description, value, full)
        if isinstance(value, str) and v.family != "Real" and re.fullmatch(r"[+-]?\d{1,30}", value.strip()):
            value = int(value)  # all its digits, which a float may not have
        try:
            size = float(value)
        except (TypeError, ValueError, OverflowError):
            raise UsageError(f"{full} = {value} is not allowed: it must be a number.") from None
        low = -math.inf if v.min is None else v.min
        high = math.inf if v.max is None else v.max
        if not math.isfinite(size) or not low <= size <= high:
            unit = f" {v.unit}" if v.unit and v.unit != "1" else ""
            raise UsageError(f"{full} = {value} is not allowed: it must be between {low:g} and {high:g}{unit}.")
        least, most = limits(self.description.version, v.type)
        if v.family == "Real":
            if not least <= size <= most:
                raise UsageError(f"{full} = {value} is not allowed: it must be between {least:g} and {most:g}.")
            return size
        whole = value if isinstance(value, int) else int(size)
        if not isinstance(value, int) and size != whole:
            raise UsageError(f"{full} = {value} is not allowed: it must be a whole number.")
        if not least <= whole <= most:
            raise UsageError(f"{full} = {value} is not allowed: it must be between {least} and {most}.")
        return int(whole)
