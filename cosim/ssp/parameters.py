"""Parameter bindings: SSV values, through SSM mappings, to the variables they are meant for."""
from collections.abc import Callable, Iterator
from dataclasses import replace
from os.path import isfile
from pathlib import Path
from urllib.parse import unquote, urlsplit

from ..errors import UsageError
from ..master.parameter_set import Given, parameters
from ..master.unpack import BadArchive, read_member
from ..master.xml_file import SSD, SSM, SSV, Node, parse, short, valid
from .structure import Element, ElementPath, Point, Structure, converts, linear, shown

Has = Callable[[ElementPath, str], bool]


def inside(folder: Path, source: str, what: str) -> Path:
    """The file that the relative URI `source` names. Raises UsageError unless it is in the archive."""
    try:
        parts = urlsplit(source)
        path = (folder / unquote(parts.path)).resolve()
    except (ValueError, OSError):  # brackets of no address, null characters, endless names
        raise UsageError(f"{what} refers to {source!r}, which is no name of a file.") from None
    if parts.scheme or parts.netloc:
        raise UsageError(f"{what} refers to {source}, which is not inside the SSP; only files inside are read.")
    if not path.is_relative_to(folder.resolve()):
        raise UsageError(f"{what} refers to {source}, which leads outside of the SSP.")
    if not isfile(path):
        raise UsageError(f"{what} refers to {source}, which is not in the SSP.")
    return path


def document(node: Node, element: Element, folder: Path, root: str) -> Node:
    """What a ParameterBinding or ParameterMapping contains, or the file that it refers to."""
    what = f"The {short(node.tag)} of {shown(element.path)}"
    source = node.get("source")
    if source is None:
        content = node.find(f"{SSD}ParameterValues/*") if root == SSV + "ParameterSet" else node.find("*")
        if content is None:
            raise UsageError(f"{what} has neither a source nor content.")
        return valid(content, what, root)
    if node.get("sourceBase", "SSD") == "SSD":
        return parse(inside(folder, source, what).read_bytes(), source, root)
    if element.source is None:
        raise UsageError(f"{what} has its source in a component, but is not in one.")
    fmu = inside(folder, element.source, shown(element.path))
    try:
        return parse(read_member(fmu, unquote(source)), source, root)
    except BadArchive as error:
        raise UsageError(f"{what} refers to {source}, which is not in {fmu.name}: {error}.") from None


def mapped(found: list[tuple[str, Given]], mapping: Node) -> Iterator[tuple[str, Given]]:
    """The values under the names that a valid parameter mapping gives them; what it does not name is left out."""
    by_name = dict(found)
    for entry in mapping.iterfind(f"{SSM}MappingEntry"):
        source, target = entry.get("source"), entry.get("target")
        what = f"The mapping of {source} to {target}"
        factor, offset = linear(entry, what)
        if source not in by_name:
            continue
        if (factor, offset) != (1.0, 0.0) and by_name[source].kind != "Real":
            raise UsageError(f"{what} has a LinearTransformation, but a value that is {by_name[source].kind}.")
        yield target, replace(by_name[source], factor=factor, offset=offset, converts=converts(entry))


def bound(structure: Structure, folder: Path, has: Has) -> tuple[dict[Point, Given], list[str]]:
    """What the bindings of all elements set, and the names that fit nothing (SSP 1.0 wants those ignored).

    Outer elements take precedence over inner ones, later bindings over earlier ones. `has` tells whether the
    element at a path, a component, has a variable of that name.
    """
    values: dict[Point, Given] = {}
    ignored = []
    for element in sorted(structure.elements.values(), key=lambda e: -len(e.path)):
        for binding in element.bindings:
            for name, given in of_binding(binding, element, folder):
                point = resolve(structure, element.path, name, has)
                if point is None:
                    ignored.append(f"{shown(element.path)}: {name}")
                else:
                    values[point] = given
    return values, ignored


def of_binding(binding: Node, element: Element, folder: Path) -> list[tuple[str, Given]]:
    """Names and values of a binding, through its mapping if it has one. Raises UsageError for another type."""
    if binding.get("type", "application/x-ssp-parameter-set") != "application/x-ssp-parameter-set":
        raise UsageError(f"A parameter binding of {shown(element.path)} is of type {binding.get('type')}, "
                         f"which is not supported.")
    prefix = binding.get("prefix", "")
    values = parameters(document(binding, element, folder, SSV + "ParameterSet"))
    found = [(prefix + name, given) for name, given in values]
    mapping = binding.find(f"{SSD}ParameterMapping")
    if mapping is None:
        return found
    return list(mapped(found, document(mapping, element, folder, SSM + "ParameterMapping")))


def resolve(structure: Structure, path: ElementPath, name: str, has: Has) -> Point | None:
    """The variable, or the system's connector, that `name` means seen from the element at `path`."""
    element = structure.elements[path]
    if element.source is not None:
        return (path, name) if has(path, name) else None
    if name.partition("[")[0] in element.connectors or name in element.connectors:
        return path, name
    for inner in structure.elements:
        if inner and inner[:-1] == path and name.startswith(inner[-1] + "."):
            found = resolve(structure, inner, name[len(inner[-1]) + 1:], has)
            if found:
                return found
    return None
