"""Builds the correct FMU of these tests (fixture.c, fixture.xml) and copies of it with single defects."""

import re
import tempfile
import zipfile
from functools import cache
from pathlib import Path

import fmpy

from fmus.native_compiler import cc

HERE = Path(__file__).parent
BASE_XML = (HERE / "fixture.xml").read_text("utf-8")
C_SOURCE = (HERE / "fixture.c").read_text("utf-8")
C_DEFECTS = sorted(set(re.findall(r"BUG\(([A-Z0-9_]+)\)", C_SOURCE)) | {"UNRESOLVED"})
C_DEFECTS.remove("NAME")
BINARY = "binaries/linux64/Fixture.so"

_HEADERS = Path(fmpy.__file__).parent / "c-code"
_WORK = tempfile.TemporaryDirectory(prefix="ahv-test-check-")


@cache
def library(defect: str | None = None, extra: tuple[str, ...] = ()) -> bytes:
    """The shared library, with one defect or none; `extra` are further compiler options."""
    folder = Path(tempfile.mkdtemp(dir=_WORK.name))
    lines = [f"#define DEFECT_{name} {int(name == defect)}" for name in C_DEFECTS]
    if defect is not None and defect not in C_DEFECTS:
        raise ValueError(f"fixture.c has no defect '{defect}'; it has {', '.join(C_DEFECTS)}")
    (folder / "defect.h").write_text("\n".join(lines) + "\n")
    target = folder / "Fixture.so"
    options = ["-shared", "-fPIC", "-O0", "-w", "-fno-sanitize=undefined", f"-I{folder}", f"-I{_HEADERS}", *extra]
    cc(*options, HERE / "fixture.c", "-o", target, "-lm")
    return target.read_bytes()


def members(xml: str = BASE_XML, defect: str | None = None) -> dict[str, bytes]:
    """The archive's members; the binary has the name that the description asks for."""
    named = re.search(r'<CoSimulation modelIdentifier="([^"]*)"', xml)
    binary = BINARY.replace("Fixture", named.group(1) if named else "Fixture")
    return {"modelDescription.xml": xml.encode("utf-8"), binary: library(defect)}


def write(file: Path, content: dict[str, bytes], compression: int = zipfile.ZIP_DEFLATED) -> Path:
    """Write an archive."""
    with zipfile.ZipFile(file, "w", compression) as archive:
        for name, data in content.items():
            archive.writestr(name, data)
    return file


def swapped(old: str, new: str, xml: str = BASE_XML) -> str:
    """The description with one piece of text replaced; the piece must occur exactly once."""
    if xml.count(old) != 1:
        raise ValueError(f"'{old}' occurs {xml.count(old)} times in fixture.xml")
    return xml.replace(old, new)
