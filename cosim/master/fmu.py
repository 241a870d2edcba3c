"""One FMU file: what it declares."""
import hashlib
import math
from dataclasses import dataclass, field
from os.path import isfile
from pathlib import Path, PurePosixPath

from ..errors import UsageError, did_you_mean
from ..temporary import Folder
from ..text import printable
from .declared import Variable
from .description import Description, read, usable
from .parameter_set import parameters
from .quantities import in_unit_of
from .system import Value
from .unpack import BadArchive, open_archive, read_member, safe_extract
from .xml_file import SSV, parse

CALL_SUFFIX = {"Real": "Real", "Integer": "Integer", "Enumeration": "Integer", "Boolean": "Boolean", "String": "String"}
WHOLES = -2 ** 31, 2 ** 31 - 1  # what an fmi2Integer can be


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


@dataclass
class FmuFile:
    """An extracted FMU. Use as a context manager: the extraction folder goes with it.

    `corrupted` is set when an instance answers Fatal: no function of any of its instances may be called then.
    """
    path: Path
    extracted: Folder
    description: Description
    sha256: str
    variables: dict[str, Variable] = field(init=False)
    corrupted: bool = False

    def __post_init__(self) -> None:
        self.variables = {v.name: v for v in self.description.variables}

    @classmethod
    def open(cls, path: Path) -> "FmuFile":
        """Extract and read `path`.

        Raises UsageError if it is missing or no FMI 2.0 co-simulation FMU.
        """
        existing(path)
        folder = Folder()
        try:
            safe_extract(path, folder.path)
            description = read(folder.path)
            if description.version != "2.0" or description.co_simulation is None:
                raise UsageError(f"{path} is FMI {description.version} or has no co-simulation interface; "
                                 f"FMI 2.0 co-simulation is what runs here.")
            identifier = description.co_simulation.get("modelIdentifier", "")
            if not identifier.isprintable() or set(identifier) & set("/\\"):  # it names the library that is loaded
                raise UsageError(f"{path} cannot be opened: its modelIdentifier '{printable(identifier)}' is no name "
                                 f"of a file in the FMU.")
            return cls(path, folder, description, hashlib.sha256(path.read_bytes()).hexdigest())
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
            return text(str(value), full)
        if v.type == "Boolean":
            words = {"true": True, "1": True, "1.0": True, "false": False, "0": False, "0.0": False}
            if str(value).lower() not in words:
                raise UsageError(f"{full} = {value} is not allowed: it is true or false.")
            return words[str(value).lower()]
        if isinstance(value, str):
            value = in_unit_of(v, self.description, value, full)
        try:
            number = float(value)
        except (TypeError, ValueError, OverflowError):
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
        if not WHOLES[0] <= number <= WHOLES[1]:
            raise UsageError(f"{full} = {value} is not allowed: it must be between {WHOLES[0]} and {WHOLES[1]}.")
        return int(number)
