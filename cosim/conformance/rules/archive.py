"""FMU distribution (FMI 2.0: section 2.3, 3.0: 2.5): the archive's layout, binaries, sources and documentation."""
from collections.abc import Iterator
from pathlib import Path

from ..binary import BadBinary, Library, read_library
from ..repeats import repeated
from ..rule import static
from ..subject import Fault, Fmu
from ..versions import FMI3

SOURCE_SUFFIXES = {".c", ".cc", ".cpp", ".cxx"}


def platform_folders(fmu: Fmu) -> list[Path]:
    """The folders below binaries/."""
    folder = fmu.folder / "binaries"
    return sorted(path for path in folder.iterdir() if path.is_dir()) if folder.is_dir() else []


def has_sources(fmu: Fmu) -> bool:
    """Whether sources/ holds C or C++ files."""
    return any(path.suffix.lower() in SOURCE_SUFFIXES for path in (fmu.folder / "sources").glob("**/*"))


@static("archive.extension")
def extension(fmu: Fmu) -> Iterator[Fault]:
    if fmu.path.suffix.lower() != ".fmu":
        yield Fault(fmu.path.name, f"extension '{fmu.path.suffix}'", "extension '.fmu'")


@static("archive.backslash")
def backslash(fmu: Fmu) -> Iterator[Fault]:
    for name in fmu.members:
        if "\\" in name:
            yield Fault(name, "a backslash in the path", "'/' as separator")
            return


@static("archive.unique")
def unique_members(fmu: Fmu) -> Iterator[Fault]:
    for name, count in repeated(name.lower() for name in fmu.members):
        yield Fault(name, f"{count} members of this name", "one (some file systems ignore case)")


@static("archive.entries")
def entries(fmu: Fmu) -> Iterator[Fault]:
    tops = {name.replace("\\", "/").split("/")[0] for name in fmu.members}
    for name in sorted(tops - fmu.version.entries):
        yield Fault(name, "an entry that the specification does not name", "resources/ for whatever the FMU needs")


@static("archive.model-png")
def model_png(fmu: Fmu) -> Iterator[Fault]:
    file = fmu.folder / "model.png"
    if file.is_file() and not file.read_bytes().startswith(b"\x89PNG\r\n\x1a\n"):
        yield Fault("model.png", "a file that does not begin like a PNG image", "a PNG image")


@static("archive.documentation")
def documentation(fmu: Fmu) -> Iterator[Fault]:
    folder = fmu.folder / "documentation"
    if folder.is_dir() and not any((folder / page).is_file() for page in ("index.html", "_main.html")):
        yield Fault("documentation", "no index.html", "documentation/index.html")


@static("binary.present")
def binary_present(fmu: Fmu) -> Iterator[Fault]:
    files = [path for folder in platform_folders(fmu) for path in folder.iterdir()]
    if not files and not has_sources(fmu):
        yield Fault("binaries", "neither binaries nor sources", "a shared library, or sources to compile")


@static("binary.platform")
def binary_platform(fmu: Fmu) -> Iterator[Fault]:
    # FMI 2.0 has no names for Arm; those of FMI 3.0 are what importers can look for.
    known = {*fmu.version.platforms, *(name for name in FMI3.platforms if name.startswith("aarch64-"))}
    for folder in platform_folders(fmu):
        if folder.name not in known:
            yield Fault(f"binaries/{folder.name}", "a name that few tools look for", ", ".join(fmu.version.platforms))


@static("binary.name")
def binary_name(fmu: Fmu) -> Iterator[Fault]:
    for folder in platform_folders(fmu):
        known = fmu.version.platforms.get(folder.name)
        there = sorted(path.name for path in folder.iterdir())
        if known and fmu.identifier and there and f"{fmu.identifier}{known[0]}" not in there:
            expected = f"binaries/{folder.name}/{fmu.identifier}{known[0]}"
            yield Fault(f"binaries/{folder.name}", f"only {', '.join(there)}", expected)


def libraries(fmu: Fmu) -> Iterator[tuple[str, Library | BadBinary]]:
    """(platform, the library or what is wrong with it) of each binary in its place."""
    for folder in platform_folders(fmu):
        known = fmu.version.platforms.get(folder.name)
        file = fmu.library(folder.name, known[0]) if known else None
        if file:
            try:
                yield folder.name, read_library(file)
            except BadBinary as problem:
                yield folder.name, problem


@static("binary.format")
def binary_format(fmu: Fmu) -> Iterator[Fault]:
    for platform, library in libraries(fmu):
        _, system, machines = fmu.version.platforms[platform]
        expected = f"a shared library for {system}, {' or '.join(sorted(machines))}"
        if isinstance(library, BadBinary):
            yield Fault(f"binaries/{platform}", f"not a usable library: {library}", expected)
        elif library.system != system or not library.machines & machines:
            yield Fault(f"binaries/{platform}", f"a library for {made_for(library)}", expected)


def made_for(library: Library) -> str:
    """System and processors of a library as text."""
    return f"{library.system}, {' and '.join(sorted(library.machines))}"


def function_names(fmu: Fmu, claimed: bool) -> list[str]:
    """The functions that the FMU must export, or those that it need not have because of what it does not claim."""
    names = (fmu.version.always if claimed else fmu.version.others).split()
    for flag, functions in fmu.version.by_flag.items():
        is_claimed = (fmu.description.co_simulation or {}).get(flag, "false").strip() not in ("false", "0")
        if is_claimed == claimed:
            names += functions.split()
    return [f"{fmu.version.prefix}{name}" for name in names]


def not_exported(fmu: Fmu, functions: list[str]) -> Iterator[Fault]:
    """A fault for each library that lacks some of `functions`."""
    for platform, library in libraries(fmu):
        if isinstance(library, BadBinary) or fmu.description.co_simulation is None:
            continue
        missing = [name for name in functions if name not in library.exports]
        prefixed = [name for name in missing if f"{fmu.identifier}_{name}" in library.exports]
        hint = f" (it exports {fmu.identifier}_{prefixed[0]})" if prefixed else ""
        if missing:
            found = f"without {', '.join(missing)}{hint}"
            yield Fault(f"binaries/{platform}", found, f"{len(functions)} functions of {fmu.version.prefix}Functions.h")


@static("binary.exports")
def binary_exports(fmu: Fmu) -> Iterator[Fault]:
    yield from not_exported(fmu, function_names(fmu, claimed=True))


@static("binary.exports-all")
def binary_exports_all(fmu: Fmu) -> Iterator[Fault]:
    yield from not_exported(fmu, function_names(fmu, claimed=False))


@static("source.listed")
def source_listed(fmu: Fmu) -> Iterator[Fault]:
    for file in fmu.description.root.iterfind("CoSimulation/SourceFiles/File"):
        name = file.get("name", "")
        if f"sources/{name}" not in fmu.members:
            yield Fault(f"sources/{name}", "listed in SourceFiles, not in the archive", "the file")


@static("source.unique")
def source_unique(fmu: Fmu) -> Iterator[Fault]:
    for listed in fmu.description.root.iterfind("*/SourceFiles"):
        for name, count in repeated(file.get("name", "") for file in listed.iterfind("File")):
            yield Fault(f"sources/{name}", f"listed {count} times", "once")


@static("source.list")
def source_list(fmu: Fmu) -> Iterator[Fault]:
    if has_sources(fmu) and fmu.description.root.find("*/SourceFiles/File") is None:
        yield Fault("sources", "source files without SourceFiles in modelDescription.xml", "<SourceFiles>")
