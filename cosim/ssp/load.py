"""An SSP file as a system that the master flies."""
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path
from typing import Self

from ..errors import UsageError, did_you_mean
from ..master.declared import Variable, number
from ..master.fmu import FmuFile
from ..master.quantities import Unit, between, conversion
from ..master.system import Component, Connection, System, Value, as_path, assign
from ..master.xml_file import SSD, parse
from ..temporary import Folder
from .archive import unpacked
from .connections import Tracer
from .parameters import bound, inside
from .structure import ElementPath, Point, Structure, called, read, shown

SSD_FILE = "SystemStructure.ssd"


@dataclass(frozen=True, init=False)
class LoadedSsp(System):
    """The system in an SSP, with the start, stop and step that the file suggests.

    Its FMUs are unpacked for as long as this object is in use, or until `close`, or the end of a `with` block.
    """
    name: str
    sources: dict[str, str]     # component -> its FMU's place in the SSP
    ignored: list[str]          # parameters that fit no variable
    folder: Folder = field(repr=False, compare=False)

    def __init__(self, components: Sequence[Component], connections: Sequence[Connection], step: float | None,
                 stop: float | None, start: float, name: str, sources: dict[str, str], ignored: list[str],
                 folder: Folder):
        super().__init__(components, connections, step, stop, start)
        assign(self, name=name, sources=sources, ignored=ignored, folder=folder)

    def close(self) -> None:
        """Remove the unpacked FMUs: the system cannot be flown any more."""
        self.folder.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def load_ssp(path: str | PathLike[str]) -> LoadedSsp:
    """The system in the SSP at `path`, ready to fly: an archive, or the .ssd file in an unpacked one.

    Raises UsageError, one sentence, for what is broken or not supported.
    """
    path = as_path(path)
    loose = path.suffix.lower() == ".ssd"
    if loose and not path.is_file():
        raise UsageError(f"There is no file {path}.")
    folder = Folder() if loose else unpacked(path)
    try:
        base = path.parent if loose else folder.path
        ssd = path if loose else folder.path / SSD_FILE
        if not ssd.is_file():
            raise UsageError(f"{path} has no {SSD_FILE}: it is not an SSP.")
        structure = read(parse(ssd.read_bytes(), path.name if loose else SSD_FILE, SSD + "SystemStructureDescription"))
        with ExitStack() as stack:
            return assembled(structure, folder, base, opened(structure, base, stack))
    except BaseException:
        folder.close()  # at once, since a traceback keeps what it has seen
        raise


def opened(structure: Structure, folder: Path, stack: ExitStack) -> dict[ElementPath, FmuFile]:
    """The FMU of every component, read for what it declares."""
    files: dict[Path, FmuFile] = {}
    found = {}
    for element in structure.components():
        path = inside(folder, element.source or "", f"The component {shown(element.path)}")
        if path not in files:
            files[path] = open_fmu(path, element.source or "")
            stack.callback(files[path].close)
        found[element.path] = files[path]
    if not found:
        raise UsageError("The system has no components.")
    return found


def open_fmu(path: Path, source: str) -> FmuFile:
    """The FMU at `path`, a temporary place; messages call it `source`. Raises UsageError."""
    try:
        return FmuFile.open(path)
    except UsageError as error:
        raise type(error)(str(error).replace(str(path), source)) from None


def assembled(structure: Structure, folder: Folder, base: Path, files: dict[ElementPath, FmuFile]) -> LoadedSsp:
    """The system of a structure whose FMUs are open; its files are below `base`.

    Raises UsageError for connectors, connections or values that do not fit the FMUs.
    """
    check_connectors(structure, files)

    def unit_of(point: Point) -> Unit | None:
        path, name = point
        connector = structure.elements[path].connectors.get(name)
        if connector and connector.unit:
            return connector.unit
        variable = variable_at(point)
        return files[path].description.unit_of(variable) if variable else None

    def variable_at(point: Point) -> Variable | None:
        path, name = point
        return files[path].variables.get(name) if path in files else None

    def relative(point: Point) -> bool:
        variable = variable_at(point)
        return variable is not None and variable.relative

    values, ignored = bound(structure, base, lambda path, name: name in files[path].variables)
    tracer = Tracer(structure, unit_of, relative)
    connections, components, sources = [], [], {}
    for element in structure.components():
        path, file = element.path, files[element.path]
        direct = {name: given for (owner, name), given in values.items() if owner == path}
        start = {n: given.for_variable(file.variables[n], unit_of((path, n)), called((path, n)))
                 for n, given in direct.items()}
        for name in (c for c in element.connectors if (path, c) in tracer.incoming):
            traced = tracer.at((path, name))
            origin = traced.origin
            if origin[0] in files:  # of arrays, the master connects each element
                connections.append(Connection(f"{flat(origin[0])}.{origin[1]}", f"{flat(path)}.{name}",
                                              traced.factor, traced.offset))
            else:
                for given, element_of in arrays_of(file, name, origin[1]):
                    fed = (origin[0], element_of)
                    if fed in values:
                        value = values[fed].for_variable(file.variables[given], unit_of(origin), called(origin))
                        start[given] = through(value, traced.factor, traced.offset)
        checked = {name: file.checked(name, value, flat(path)) for name, value in start.items()}
        components.append(Component(flat(path), file.path, checked))
        sources[flat(path)] = element.source or ""
    check_names(components)
    return LoadedSsp(components, connections, structure.step or min(declared(files, "stepSize"), default=None),
                     structure.stop or max(declared(files, "stopTime"), default=None), structure.start or 0.0,
                     structure.name, sources, ignored, folder)


def arrays_of(file: FmuFile, name: str, origin: str) -> list[tuple[str, str]]:
    """The variables of the connector `name`, each with the name of what feeds it from the connector `origin`: of an
    array, those of the same indices."""
    return [(n, origin + n.removeprefix(name)) for n in file.arrays.get(name, [name])]


def flat(path: ElementPath) -> str:
    """The name of a component in the master, which has no dots."""
    return "/".join(path).replace(".", "/")


def check_names(components: list[Component]) -> None:
    """Raises UsageError if two components have the same name in the master."""
    names = [c.name for c in components]
    for name in names:
        if names.count(name) > 1:
            raise UsageError(f"Two components are called {name} once nested systems and dots are written with /.")


def through(value: Value, factor: float, offset: float) -> Value:
    """A value through a connection's linear transformation."""
    return value if (factor, offset) == (1.0, 0.0) else factor * float(value) + offset


def check_connectors(structure: Structure, files: dict[ElementPath, FmuFile]) -> None:
    """Every connector of a component is a variable of its FMU, of the type and unit that the SSD says."""
    for element in structure.components():
        file = files[element.path]
        for name, connector in element.connectors.items():
            if name in file.arrays:
                continue
            if name not in file.variables:
                raise UsageError(f"{shown(element.path)} has a connector {name}, but {file.path.name} has no such "
                                 f"variable{did_you_mean(name, file.variables)}")
            variable = file.variables[name]
            if connector.type not in (None, variable.family):
                raise UsageError(f"{called((element.path, name))} is {connector.type} in {SSD_FILE} and "
                                 f"{variable.type} in {file.path.name}.")
            own = file.description.unit_of(variable)
            if own and connector.unit and conversion(own, connector.unit, variable.relative) != (1.0, 0.0):
                here, there = between(connector.unit, own)
                raise UsageError(f"{called((element.path, name))} is in {here} in {SSD_FILE} and in {there} in "
                                 f"{file.path.name}.")


def declared(files: dict[ElementPath, FmuFile], attribute: str) -> list[float]:
    """What the FMUs' default experiments say about `attribute`."""
    found = (number(file.description.experiment.get(attribute)) for file in files.values())
    return [x for x in found if x]
