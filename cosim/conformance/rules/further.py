"""The other XML files of FMI 3.0: terminals and icons (2.4.9), build descriptions (2.4.10), layered standards (2.6)."""
import re
from collections.abc import Iterator

from lxml import etree

from ...master.declared import number
from ..reading import further_file
from ..repeats import repeated
from ..rule import static
from ..subject import Fault, Fmu
from .archive import has_sources
from .header import interfaces

TERMINALS = ("terminalsAndIcons/terminalsAndIcons.xml", "fmi3/fmi3TerminalsAndIcons.xsd")
BUILD = ("sources/buildDescription.xml", "fmi3/fmi3BuildDescription.xsd")
MANIFEST = "{http://fmi-standard.org/fmi-ls-manifest}"
DOMAIN = re.compile(r"[A-Za-z0-9_-]+(\.[A-Za-z0-9_-]+)+")
NAMED = ("plug", "bus")  # matching rules by memberName
PNG = b"\x89PNG\r\n\x1a\n"


def judged(fmu: Fmu, file: tuple[str, str]) -> Iterator[Fault]:
    """What the schema says of a further XML file, and whether it is of the FMU's own version."""
    root, faults = further_file(fmu, *file)
    yield from faults
    version = fmu.description.version
    if root is not None and (root.get("fmiVersion") or "").strip() != version:
        yield Fault(file[0], f"fmiVersion '{root.get('fmiVersion')}'", f"'{version}', as in modelDescription.xml")


@static("terminals.schema")
def terminals_schema(fmu: Fmu) -> Iterator[Fault]:
    yield from judged(fmu, TERMINALS)


def terminals(fmu: Fmu) -> list[etree._Element]:
    """All terminals, nested ones too."""
    root, _ = further_file(fmu, *TERMINALS)
    return [] if root is None else list(root.iter("Terminal"))


@static("terminals.variable")
def terminals_variable(fmu: Fmu) -> Iterator[Fault]:
    known = {v.name for v in [*fmu.description.variables, *fmu.description.aliases]}
    for terminal in terminals(fmu):
        for member in terminal.iterchildren("TerminalMemberVariable", "TerminalStreamMemberVariable"):
            for attribute in ("variableName", "inStreamVariableName", "outStreamVariableName"):
                name = member.get(attribute)
                if name is not None and name not in known:
                    yield Fault(str(terminal.get("name")), f"{attribute} '{name}'", "the name of a variable")


@static("terminals.unique")
def terminals_unique(fmu: Fmu) -> Iterator[Fault]:
    root, _ = further_file(fmu, *TERMINALS)
    for parent in [] if root is None else root.iter("Terminals", "Terminal"):
        for name, count in repeated(str(child.get("name")) for child in parent.iterchildren("Terminal")):
            yield Fault(name, f"{count} terminals of this name side by side", "one")
        members = [child.get("memberName") for child in parent.iterchildren("TerminalMemberVariable")]
        for name, count in repeated(m for m in members if m) if parent.get("matchingRule") in NAMED else ():
            yield Fault(f"{parent.get('name')}: {name}", f"{count} members of this name", "one")


@static("terminals.member-name")
def terminals_member_name(fmu: Fmu) -> Iterator[Fault]:
    for terminal in terminals(fmu):
        for member in terminal.iterchildren("TerminalMemberVariable"):
            if terminal.get("matchingRule") in NAMED and not member.get("memberName"):
                yield Fault(f"{terminal.get('name')}: {member.get('variableName')}",
                            f"no memberName, with matchingRule '{terminal.get('matchingRule')}'", "a memberName")


@static("terminals.icon")
def terminals_icon(fmu: Fmu) -> Iterator[Fault]:
    root, _ = further_file(fmu, *TERMINALS)
    icons = [] if root is None or root.find("GraphicalRepresentation/Icon") is None else ["icon"]
    icons += [str(drawn.get("iconBaseName")) for terminal in terminals(fmu)
              for drawn in terminal.iterchildren("TerminalGraphicalRepresentation") if drawn.get("iconBaseName")]
    folder = fmu.folder / "terminalsAndIcons"
    if not icons and f"{folder.name}/icon.svg" in fmu.members:
        icons.append("icon")
    for name in dict.fromkeys(icons):
        member = f"{folder.name}/{name.removeprefix('./')}.png"
        if member not in fmu.members:
            yield Fault(member, "not in the archive", "a PNG image")
        elif not (fmu.folder / member).read_bytes().startswith(PNG):
            yield Fault(member, "a file that does not begin like a PNG image", "a PNG image")


@static("terminals.area")
def terminals_area(fmu: Fmu) -> Iterator[Fault]:
    root, _ = further_file(fmu, *TERMINALS)
    drawn = ("CoordinateSystem", "Icon", "TerminalGraphicalRepresentation")
    for element in [] if root is None else root.iter(*drawn):
        corners = [number(element.get(name)) for name in ("x1", "y1", "x2", "y2")]
        if any(corner is None for corner in corners):
            continue  # the defaults, or the schema's finding
        x1, y1, x2, y2 = (corner or 0.0 for corner in corners)
        owner = element.getparent()
        where = f"{owner.get('name') if owner is not None and owner.tag == 'Terminal' else ''} {element.tag}".strip()
        if x1 == x2 or y1 == y2:
            yield Fault(where, f"from ({x1:g}, {y1:g}) to ({x2:g}, {y2:g})", "an area above zero")
        elif element.tag == "CoordinateSystem" and (x1 > x2 or y1 > y2):
            yield Fault(where, f"from ({x1:g}, {y1:g}) to ({x2:g}, {y2:g})", "from lower left to upper right")


@static("build.schema")
def build_schema(fmu: Fmu) -> Iterator[Fault]:
    yield from judged(fmu, BUILD)


@static("build.present")
def build_present(fmu: Fmu) -> Iterator[Fault]:
    if has_sources(fmu) and BUILD[0] not in fmu.members:
        yield Fault("sources", "source files without buildDescription.xml", BUILD[0])


def configurations(fmu: Fmu) -> list[etree._Element]:
    """The build configurations."""
    root, _ = further_file(fmu, *BUILD)
    return [] if root is None else root.findall("BuildConfiguration")


@static("build.identifier")
def build_identifier(fmu: Fmu) -> Iterator[Fault]:
    known = {(fmu.description.attributes_at(tag) or {}).get("modelIdentifier") for tag in interfaces(fmu)} - {None}
    for name in {str(one.get("modelIdentifier")) for one in configurations(fmu)} - known:
        yield Fault("buildDescription.xml", f"modelIdentifier '{name}'", " or ".join(sorted(map(repr, known))))
    free = [str(one.get("modelIdentifier")) for one in configurations(fmu) if one.get("platform") is None]
    for name, count in repeated(free):
        yield Fault("buildDescription.xml", f"{count} configurations of '{name}' without platform", "at most one")


@static("build.files")
def build_files(fmu: Fmu) -> Iterator[Fault]:
    for listed in (files for one in configurations(fmu) for files in one.iterfind("SourceFileSet")):
        names = [str(file.get("name")) for file in listed.iterfind("SourceFile")]
        for name, count in repeated(names):
            yield Fault(f"sources/{name}", f"listed {count} times in a SourceFileSet", "once")
        for name in dict.fromkeys(names):
            if not (fmu.folder / "sources" / name).is_file() or f"sources/{name}" not in fmu.members:
                yield Fault(f"sources/{name}", "listed in buildDescription.xml, not in the archive", "the file")


@static("layered.manifest")
def layered_manifest(fmu: Fmu) -> Iterator[Fault]:
    for member in dict.fromkeys(fmu.members):
        if not re.fullmatch(r"extra/[^/]+/fmi-ls-manifest\.xml", member):
            continue
        root, faults = further_file(fmu, member, "fmi3/fmi3LayeredStandardManifest.xsd")
        if root is None:
            yield from faults
        else:
            for word in ("fmi-ls-name", "fmi-ls-version", "fmi-ls-description"):
                if not root.get(f"{MANIFEST}{word}"):
                    yield Fault(member, f"no {word} in the namespace {MANIFEST[1:-1]}", f"{word}=...")


@static("layered.folder")
def layered_folder(fmu: Fmu) -> Iterator[Fault]:
    for name in sorted({name.split("/")[1] for name in fmu.members if re.match(r"extra/[^/]+/", name)}):
        if not DOMAIN.fullmatch(name):
            yield Fault(f"extra/{name}", "no reversed domain name", "such as extra/org.example.what")
