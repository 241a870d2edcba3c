"""A system as a YAML file: components, connections, parameters, experiment. `docs/systems.md` says it in words.

    components:
      tank: Tank.fmu
      controller: {fmu: Controller.fmu, set: {gain: 2.0}}
    connections:
      - tank.level -> controller.level
      - {from: controller.valve, to: tank.valve, factor: 0.01}
    experiment: {stop: 100, step: 0.01}
"""
import re
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from math import isfinite
from os.path import isfile
from pathlib import Path
from typing import Annotated, Any

from pydantic import AfterValidator, BeforeValidator, Field, ValidationInfo

from .. import names
from ..errors import UsageError, did_you_mean
from ..fields import Finite, Positive, Strict
from ..master.algorithms import method
from ..master.connections import checked_connections
from ..master.fly import tick_count
from ..master.fmu import FmuFile
from ..master.quantities import between, conversion
from ..master.system import Component, Connection, System, Value
from ..yaml_file import Source

WIRE = re.compile(r"\s*(\S.*?)\s*->\s*(\S.*?)\s*")


def value(given: Any) -> Any:
    """A value to set. Raises ValueError for what is none."""
    if not isinstance(given, bool | int | float | str) or (isinstance(given, float) and not isfinite(given)):
        raise ValueError(f"a number, a truth value or a text is wanted, not {given!r}")
    return given


def part(given: Any) -> Any:
    """A component may be the path of its FMU alone. Raises ValueError for what is none."""
    if isinstance(given, str):
        return {"fmu": given}
    if not isinstance(given, dict):
        raise ValueError(f"the path of an FMU, or fields such as fmu and set, are wanted, not {given!r}")
    return given


def wire(given: Any) -> Any:
    """A connection may be `a.y -> b.u` or [a.y, b.u]. Raises ValueError for what is none."""
    if isinstance(given, str):
        found = WIRE.fullmatch(given)
        if found is None or "->" in found[2]:
            raise ValueError(f"a connection is written COMPONENT.OUTPUT -> COMPONENT.INPUT, not {given!r}")
        return {"from": found[1], "to": found[2]}
    if isinstance(given, list):
        if len(given) != 2 or not all(isinstance(end, str) for end in given):
            raise ValueError(f"a list has the two ends of a connection, [COMPONENT.OUTPUT, COMPONENT.INPUT], not "
                             f"{given!r}")
        return {"from": given[0], "to": given[1]}
    if not isinstance(given, dict):
        raise ValueError(f"a connection is written COMPONENT.OUTPUT -> COMPONENT.INPUT, not {given!r}")
    return given


def fields(given: Any, info: ValidationInfo) -> Any:
    """Raises ValueError unless it is a mapping; an empty field counts as an empty one."""
    if given is None:
        return {}
    if not isinstance(given, dict):
        raise ValueError(f"{info.field_name} has fields with values, not {given!r}")
    return given


Given = Annotated[Any, BeforeValidator(value)]
Values = Annotated[dict[str, Given], BeforeValidator(fields)]


class Part(Strict):
    """A component."""
    fmu: str = Field(min_length=1, description="beside the system file, or an absolute path")
    preset: str | None = Field(default=None, description="a set of parameters that the FMU carries")
    set: Values = Field(default={}, description="variable -> value")


class Wire(Strict):
    """to = factor * from + offset. Without factor and offset, units are converted."""
    source: str = Field(alias="from")
    target: str = Field(alias="to")
    factor: Finite | None = None
    offset: Finite | None = None


class Run(Strict):
    """The experiment, times in s."""
    start: Finite = 0.0
    stop: Finite | None = None
    step: Positive | None = None
    tolerance: Positive | None = None
    algorithm: str | None = None


class SystemFile(Strict):
    """What a system file may say."""
    name: Annotated[str, AfterValidator(names.checked)] | None = None
    components: Annotated[dict[str, Annotated[Part, BeforeValidator(part)]], Field(min_length=1),
                          BeforeValidator(fields)]
    connections: list[Annotated[Wire, BeforeValidator(wire)]] = Field(default=[])
    parameters: Values = Field(default={}, description="component.variable -> value")
    experiment: Annotated[Run, BeforeValidator(fields)] = Run()


@dataclass(frozen=True)
class Read:
    """A system file that was read; `remarks` are sentences that a user should know."""
    name: str
    system: System
    algorithm: str | None
    tolerance: float | None
    remarks: list[str]


def is_system_file(path: str | Path) -> bool:
    """Whether the file at `path` is a YAML file that says of which components a system is made."""
    path = Path(path)
    if path.suffix.lower() not in (".yaml", ".yml") or not isfile(path):
        return False
    data = Source(path, "system file").data
    return isinstance(data, dict) and "components" in data


def read_system(path: Path) -> Read:
    """The system in the YAML file at `path`.

    Raises UsageError with file, line and field for what is wrong with the file or does not fit the FMUs.
    """
    source = Source(path, "system file")
    if not isinstance(source.data, dict):
        source.fail((), f"a system file has fields such as components, not {source.data!r}")
    spec = source.load(SystemFile)
    with ExitStack() as stack:
        files, components = {}, []
        for name, declared in spec.components.items():
            with source.at("components", name):
                if "." in names.named("component", name):
                    raise UsageError(f"the component name {name} must not have a dot")
            with source.at("components", name, "fmu"):
                files[name] = stack.enter_context(FmuFile.open(path.parent / declared.fmu))
            components.append(Component(name, path.parent / declared.fmu, values(source, spec, name, files[name])))
        for full in spec.parameters:
            with source.at("parameters", full):
                component, dot, _ = full.partition(".")
                if component not in files or not dot:
                    raise UsageError(f"a parameter is named COMPONENT.VARIABLE, and there is no component "
                                     f"{component}{did_you_mean(component, files)}")
        links, remarks = wired(source, spec, files)
    run = spec.experiment
    with source.at("experiment", "algorithm"):
        if run.algorithm is not None:
            method(run.algorithm)
    with source.at("experiment", "stop"):
        if run.stop is not None and (run.step is not None or run.stop <= run.start):
            tick_count(run.step or 1.0, run.stop, run.start)
    system = System(components, links, run.step, run.stop, run.start)
    return Read(spec.name or names.safe(path.stem), system, run.algorithm, run.tolerance, remarks)


def values(source: Source, spec: SystemFile, name: str, file: FmuFile) -> dict[str, Value]:
    """What the file sets of a component: `parameters` over `set` over the preset."""
    declared, found = spec.components[name], {}
    if declared.preset is not None:
        with source.at("components", name, "preset"):
            found.update(file.preset(declared.preset))
    for variable, given in declared.set.items():
        with source.at("components", name, "set", variable):
            found[variable] = file.checked(variable, given, name)
    for full, given in spec.parameters.items():
        component, _, variable = full.partition(".")
        if component == name:
            with source.at("parameters", full):
                found[variable] = file.checked(variable, given, name)
    return found


def wired(source: Source, spec: SystemFile, files: Mapping[str, FmuFile]) -> tuple[list[Connection], list[str]]:
    """The connections, and what should be known of them."""
    links, remarks, fed = [], [], set()
    for i, declared in enumerate(spec.connections):
        with source.at("connections", i):
            for end in (declared.source, declared.target):
                component, dot, _ = end.partition(".")
                if not dot:
                    raise UsageError(f"{end} is not of the form COMPONENT.VARIABLE")
                if component not in files:
                    raise UsageError(f"there is no component {component}{did_you_mean(component, files)}")
            link, remark = converted(declared, files)
            for target in checked_connections(System((), [link]), dict(files)):
                if target in fed:
                    raise UsageError(f"{target} has more than one connection")
                fed.add(target)
            links.append(link)
            remarks += remark
    return links, remarks


def converted(declared: Wire, files: Mapping[str, FmuFile]) -> tuple[Connection, list[str]]:
    """A connection with the factor and offset of its units, unless the file has a factor or an offset of its own.

    Raises UsageError for units between which there is no conversion.
    """
    if declared.factor is not None or declared.offset is not None:
        return Connection(declared.source, declared.target, 1.0 if declared.factor is None else declared.factor,
                          declared.offset or 0.0), []
    link = Connection(declared.source, declared.target)
    ends = [(files[component], files[component].variables.get(variable))
            for component, _, variable in (end.partition(".") for end in (link.source, link.target))]
    (_, output), (_, given) = ends
    one, other = (file.description.unit_of(v) if v else None for file, v in ends)
    if output is None or given is None or one is None or other is None or given.family != "Real":
        return link, []  # what does not fit is told by the check of connections
    change = conversion(one, other, output.relative or given.relative)
    if change is None:
        raise UsageError(f"{link.source} -> {link.target} cannot convert {' to '.join(between(one, other))}; "
                         f"a factor or an offset of its own says what is meant")
    if change == (1.0, 0.0):
        return link, []
    words = f" and offset {change[1]:.6g}" if change[1] else ""
    return (Connection(link.source, link.target, *change),
            [f"{link.source} -> {link.target} converts {one.name} to {other.name}: factor {change[0]:.6g}"
             f"{words}."])
