"""One FMU, an SSP or a system file, as a system to fly."""
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from os import PathLike
from pathlib import Path

from .. import names
from ..errors import UsageError
from ..master.declared import number
from ..master.fmu import FmuFile
from ..master.system import Component, System, as_path
from ..ssp.load import load_ssp
from .system_file import read_system

ENDINGS = (".fmu", ".ssp", ".ssd", ".yaml", ".yml")
POINTS = 500  # steps of a flight of which nobody says how long they are


@dataclass(frozen=True)
class Loaded:
    """A system from a file, with what the file suggests.

    `sources` has where each component's FMU is, as results say it; `alone` is the component of a file that is one FMU,
    `variables` are its variables; `remarks` are sentences that a user should know.
    """
    path: Path
    name: str
    system: System
    sources: dict[str, str]
    algorithm: str | None = None
    tolerance: float | None = None
    alone: str | None = None
    variables: list[str] = field(default_factory=list, repr=False)
    remarks: list[str] = field(default_factory=list)


@contextmanager
def load_system(path: str | PathLike[str]) -> Iterator[Loaded]:
    """The system in an FMU, an SSP (an archive, or the .ssd file of its folder) or a system file (YAML), ready to fly
    within the context.

    Raises UsageError, one sentence, for a file that is none of these, is broken, or has what is not supported.
    """
    path = as_path(path)
    ending = path.suffix.lower()
    if ending not in ENDINGS:
        raise UsageError(f"{path} is not a system: its name must end with {', '.join(ENDINGS[:-1])} or {ENDINGS[-1]}.")
    if ending == ".fmu":
        yield load_fmu(path)
    elif ending in (".yaml", ".yml"):
        read = read_system(path)
        yield Loaded(path, read.name, read.system, {c.name: str(c.fmu) for c in read.system.components},
                     read.algorithm, read.tolerance, remarks=read.remarks)
    else:
        with load_ssp(path) as found:
            yield Loaded(path, found.name, found, {c: f"{path}/{place}" for c, place in found.sources.items()},
                         remarks=[f"the parameter {name} fits no variable and is ignored." for name in found.ignored])


def load_fmu(path: Path) -> Loaded:
    """One FMU with its default experiment. Raises UsageError for a file that cannot be flown."""
    with FmuFile.open(path) as file:
        said = file.description.experiment
        start, stop, step, tolerance = (number(said.get(key)) for key in ("startTime", "stopTime", "stepSize",
                                                                           "tolerance"))
        step = step or number((file.description.co_simulation or {}).get("fixedInternalStepSize"))
        name = names.safe(path.stem).replace(".", "_")
        system = System([Component(name, path)], (), step or None, stop, start or 0.0)
        return Loaded(path, names.safe(path.stem), system, {name: str(path)}, tolerance=tolerance or None, alone=name,
                      variables=list(file.variables))
