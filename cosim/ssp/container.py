"""A system as one FMU: its FMUs inside FMPy's container runtime, which exchanges values as the algorithm jacobi does.

The runtime sets and reads in the order of its list of connections, once before initialisation ends and once after each
step. The list here has the order in which our master initialises, so that values at the start are the same. It is not
repeated: algebraic loops are refused. It hands values on as they are: factors and other types are refused.
"""
import json
import re
from collections.abc import Iterator, Mapping
from fnmatch import fnmatchcase
from importlib.metadata import distribution
from pathlib import Path
from typing import Any

from fmus import pack

from ..errors import UsageError, did_you_mean
from ..master.connections import checked_connections
from ..master.fmu import FmuFile
from ..master.initialise import order
from ..master.loaded import open_files
from ..master.system import Connection, System
from .container_description import RUNTIME, Port, description

PLATFORMS = {"linux64": ("x86_64-linux", ".so"), "win64": ("x86_64-windows", ".dll"),
             "darwin64": ("x86_64-darwin", ".dylib")}
KINDS = {"Real": "Float64", "Integer": "Int32", "Enumeration": "Int32", "Boolean": "Boolean", "String": "String"}


def write_container(path: Path, name: str, system: System, step: float, stop: float | None,
                    connectors: list[str] | None = None) -> list[str]:
    """Write `system` to `path` as one FMU 2.0 for co-simulation, which exchanges values every `step` (s) and can be
    stepped by multiples of that; `stop` (s) is what its default experiment suggests. The same system gives the same
    bytes.

    Its inputs and outputs are `connectors`, [NAME=]COMPONENT.VARIABLE each, * for any; None: every output, and every
    input that nothing feeds. An input that is named takes the place of the connection that feeds it. Parameters keep
    the names COMPONENT.VARIABLE.

    Returns what should be known of it, a sentence each. Raises UsageError for connectors that do not fit, and for a
    system that the runtime cannot fly as our master does.
    """
    with open_files(system) as files:
        for component, file in files.items():
            if file.description.version != "2.0":
                raise UsageError(f"{component} is FMI {file.description.version}; a container holds FMI 2.0 only.")
        targets = checked_connections(system, files)
        ports = chosen(system, files, targets, connectors)
        opened = {p.full: targets.pop(p.full) for p in ports if p.full in targets}
        ports += parameters(system, files)
        check_names(ports)
        places = {c.name: f"{i}_{re.sub(r'[^A-Za-z0-9]', '_', c.name)}" for i, c in enumerate(system.components)}
        contents = {f"resources/{places[c.name]}/{member}": data for c in system.components
                    for member, data in members(files[c.name].folder)}
        contents |= runtime(files)
        setup = configuration(system, files, places, ports, targets, step)
        guid = f"{{{pack.digest({**contents, 'setup': json.dumps(setup).encode()})[:32]}}}"
        contents["resources/container.json"] = json.dumps({**setup, "instantiationToken": guid}, indent=1).encode()
        contents["modelDescription.xml"] = description(name, guid, files, ports, step, stop)
    try:
        pack.write(path, contents)
    except OSError as error:
        raise UsageError(f"--out {path} cannot be written: {error.strerror}.") from None
    return [f"{target} is an input of the FMU now; {link.source} fed it." for target, link in opened.items()]


def chosen(system: System, files: Mapping[str, FmuFile], targets: Mapping[str, Connection],
           words: list[str] | None) -> list[Port]:
    """The inputs and outputs of the container. Raises UsageError for a word that fits nothing."""
    values = {f"{c.name}.{n}": x for c in system.components for n, x in c.values.items()}
    known = {f"{c.name}.{v.name}": (c.name, v) for c in system.components for v in files[c.name].description.variables
             if v.causality in ("input", "output")}
    free = [full for full in known if full not in targets]
    found: dict[str, Port] = {}
    for word in ["*"] if words is None else words:
        name, equals, pattern = word.rpartition("=")
        fits = [pattern] if pattern in known else [full for full in free if fnmatchcase(full, pattern)]
        if not fits and words is not None:
            raise UsageError(f"--connector {word}: {pattern} fits no output and no input that is free"
                             f"{did_you_mean(pattern, known)}")
        if (equals and not name) or (equals and pattern not in known):
            raise UsageError(f"--connector {word} is not allowed: a name stands before one COMPONENT.VARIABLE.")
        if not name.isprintable():
            raise UsageError(f"--connector {word!r} is not allowed: a name is one line of printable text.")
        for full in fits:
            found[full] = Port(name or full, *known[full], value=values.get(full))
    return list(found.values())


def parameters(system: System, files: Mapping[str, FmuFile]) -> list[Port]:
    """The parameters and calculated parameters of all components."""
    return [Port(f"{c.name}.{v.name}", c.name, v, c.values.get(v.name)) for c in system.components
            for v in files[c.name].description.variables if v.causality in ("parameter", "calculatedParameter")]


def check_names(ports: list[Port]) -> None:
    """Raises UsageError for two ports of one name."""
    names: dict[str, str] = {}
    for port in ports:
        other = names.setdefault(port.name, port.full)
        if other != port.full:
            raise UsageError(f"Two connectors are called {port.name}: {other} and {port.full}.")


def members(folder: Path) -> Iterator[tuple[str, bytes]]:
    """The files of an extracted FMU: path, content."""
    for path in folder.rglob("*"):
        if path.is_file():
            yield path.relative_to(folder).as_posix(), path.read_bytes()


def runtime(files: Mapping[str, FmuFile]) -> dict[str, bytes]:
    """The runtime's libraries, for the platforms that all FMUs have, and its licence.

    Raises UsageError where they have none in common.
    """
    import fmpy

    folder = Path(fmpy.__file__).parent / RUNTIME / "binaries"
    platforms = [p for p in PLATFORMS if all((f.folder / "binaries" / p).is_dir() for f in files.values())]
    if not platforms:
        raise UsageError(f"The FMUs have no platform in common of {', '.join(PLATFORMS)}.")
    found = {}
    for platform in platforms:
        place, suffix = PLATFORMS[platform]
        found[f"binaries/{platform}/{RUNTIME}{suffix}"] = (folder / place / f"{RUNTIME}{suffix}").read_bytes()
    licence = next((f for f in distribution("fmpy").files or [] if f.name.startswith("LICENSE")), None)
    return {**found, **({"documentation/licenses/fmpy.txt": Path(str(licence.locate())).read_bytes()}
                        if licence else {})}


def configuration(system: System, files: Mapping[str, FmuFile], places: Mapping[str, str], ports: list[Port],
                  targets: Mapping[str, Connection], step: float) -> dict[str, Any]:
    """What the runtime reads from container.json, but for its token; the variables are in the order of `ports`."""
    from fmpy.container_fmu import __version__

    number = {c.name: i for i, c in enumerate(system.components)}
    shown = {port.full for port in ports}
    silent = [Port("", c.name, files[c.name].variable(name), value) for c in system.components  # set all the same
              for name, value in c.values.items() if f"{c.name}.{name}" not in shown]
    variables: list[dict[str, Any]] = []
    for port in [*ports, *silent]:
        v = port.variable
        start = {} if port.value is None else {"start": [port.start(files)]}
        variables.append({"variableType": KINDS[v.type], **start, "mappings": [
            {"component": number[port.component], "valueReference": v.reference}]})
    return {"containerVersion": __version__, "fixedStepSize": float(step), "parallelDoStep": False,
            "components": [{"fmiMajorVersion": "2", "name": name, "modelIdentifier": files[name].identifier,
                            "path": places[name], "instantiationToken": files[name].description.attributes["guid"]}
                           for name in number],
            "variables": variables, "connections": list(exchanges(system, files, targets, number))}


def exchanges(system: System, files: Mapping[str, FmuFile], targets: Mapping[str, Connection],
              number: Mapping[str, int]) -> Iterator[dict[str, Any]]:
    """The connections in the order of initialisation, together what is read from one component and set in another.

    Raises UsageError for an algebraic loop, and for a connection that changes what it carries.
    """
    for batches in order(system, files, targets):
        if len(batches) > 1:
            loop = ", ".join(name for batch in batches for name in batch)
            raise UsageError(f"The container cannot settle the algebraic loop of {loop} at the start.")
        links = [targets[name] for name in batches[0] if name in targets]
        groups: dict[tuple[str, str, str], list[tuple[int | None, int | None]]] = {}
        for link in links:
            source, target = link.source.partition("."), link.target.partition(".")
            start, end = files[source[0]].variable(source[2]), files[target[0]].variable(target[2])
            if (link.factor, link.offset) != (1.0, 0.0):
                raise UsageError(f"The container cannot convert {link.source} for {link.target}: it hands values on "
                                 f"as they are, and this connection has factor {link.factor:g}, offset "
                                 f"{link.offset:g}.")
            if KINDS[start.type] != KINDS[end.type]:
                raise UsageError(f"The container cannot connect {link.source} ({start.type}) to {link.target} "
                                 f"({end.type}).")
            groups.setdefault((source[0], target[0], KINDS[start.type]), []).append((start.reference, end.reference))
        for (source_name, target_name, kind), pairs in groups.items():
            yield {"variableType": kind, "srcComponent": number[source_name], "dstComponent": number[target_name],
                   "srcValueReferences": [a for a, _ in pairs], "dstValueReferences": [b for _, b in pairs],
                   "size": len(pairs)}
