"""Single defects of the archive, its binaries and its other files: the rule that each breaks, and how to make it."""

import stat
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from check_fixture import BASE_XML, BINARY, library, members, swapped, write

Content = dict[str, bytes]


class Defect(NamedTuple):
    rule: str
    what: str
    build: Callable[[Path], Path]


def _with(rule: str, what: str, more: Content) -> Defect:
    """Further members."""
    return Defect(rule, what, lambda file: write(file, members() | more))


def _changed(rule: str, what: str, change: Callable[[Content], Content]) -> Defect:
    return Defect(rule, what, lambda file: write(file, change(members())))


def _raw(rule: str, what: str, change: Callable[[bytes], bytes]) -> Defect:
    """Change the bytes of the finished file."""

    def build(file: Path) -> Path:
        file.write_bytes(change(write(file, members()).read_bytes()))
        return file

    return Defect(rule, what, build)


def _without(name: str) -> Callable[[Content], Content]:
    return lambda content: {key: data for key, data in content.items() if key != name}


def _moved(old: str, new: str) -> Callable[[Content], Content]:
    return lambda content: {new if key == old else key: data for key, data in content.items()}


def _binary(data: Callable[[bytes], bytes]) -> Callable[[Content], Content]:
    return lambda content: content | {BINARY: data(content[BINARY])}


def _described(xml: str) -> Callable[[Content], Content]:
    return lambda content: content | {"modelDescription.xml": xml.encode()}


def _link(file: Path) -> Path:
    write(file, members())
    info = zipfile.ZipInfo("resources/link")
    info.external_attr = (stat.S_IFLNK | 0o777) << 16
    with zipfile.ZipFile(file, "a") as archive:
        archive.writestr(info, "/etc/passwd")
    return file


def _encrypted(data: bytes) -> bytes:
    """Set the flag of encryption in the first entry of the central directory."""
    at = data.index(b"PK\x01\x02") + 8
    return data[:at] + struct.pack("<H", 1) + data[at + 2 :]


def _claiming(size: int) -> Callable[[bytes], bytes]:
    """Let the central directory claim an unpacked size."""

    def change(data: bytes) -> bytes:
        at = data.index(b"PK\x01\x02") + 24
        return data[:at] + struct.pack("<I", size) + data[at + 4 :]

    return change


def _damaged(data: bytes) -> bytes:
    """Overwrite compressed bytes of the last member."""
    return data[:-2000].replace(data[-4000:-3900], b"\xff" * 100) + data[-2000:]


def _other_machine(data: bytes) -> bytes:
    return data[:18] + struct.pack("<H", 0xB7) + data[20:]


def _prefixed(_: bytes) -> bytes:
    return library(None, ("-DPREFIXED",))


def _without_state(_: bytes) -> bytes:
    return library(None, ("-DNO_STATE_FUNCTIONS",))


_BOMB = "<!DOCTYPE b [" + "".join(
    f'<!ENTITY {chr(97 + i)} "{f"&{chr(96 + i)};" * 10 if i else "lol"}">' for i in range(12)
)
_NO_STATE_XML = BASE_XML.replace('canGetAndSetFMUstate="true" canSerializeFMUstate="true"', "")
_LISTED = '"true"><SourceFiles><File name="no.c"/></SourceFiles></CoSimulation>\n  <UnitDefinitions>'
_SOURCES_XML = swapped('"true"/>\n  <UnitDefinitions>', _LISTED)

DEFECTS = (
    # Show 6 of issue 4: what a stranger may send
    Defect("archive.readable", "not a zip file", lambda file: (file.write_text("Dear master"), file)[1]),
    Defect("archive.readable", "an empty file", lambda file: (file.write_bytes(b""), file)[1]),
    _raw("archive.readable", "truncated in the middle", lambda data: data[: len(data) // 2]),
    _raw("archive.readable", "damaged compressed bytes", _damaged),
    _with("archive.paths", "a path with ..", {"../../outside.txt": b"x"}),
    _with("archive.paths", "an absolute path", {"/outside.txt": b"x"}),
    _with("archive.paths", "a Windows drive", {"C:\\outside.txt": b"x"}),
    _with("archive.paths", "a path with .. and backslashes", {"..\\outside.txt": b"x"}),
    Defect("archive.paths", "a symbolic link", _link),
    _raw("archive.size", "a header that claims 2 GB", _claiming(2_147_483_647)),
    _raw("archive.encrypted", "an encrypted member", _encrypted),
    Defect("archive.compression", "bzip2", lambda file: write(file, members(), zipfile.ZIP_BZIP2)),
    _changed("archive.model-description", "no modelDescription.xml", _without("modelDescription.xml")),
    _changed("archive.model-description", "in a folder", _moved("modelDescription.xml", "f/modelDescription.xml")),
    _changed("archive.model-description", "in lower case", _moved("modelDescription.xml", "modeldescription.xml")),
    _changed("xml.entities", "an entity bomb", _described(BASE_XML.replace("?>", "?>" + _BOMB + "]>", 1))),
    _changed(
        "xml.entities",
        "an external entity",
        _described(BASE_XML.replace("?>", '?><!DOCTYPE b [<!ENTITY e SYSTEM "file:///etc/passwd">]>', 1)),
    ),
    _changed(
        "xml.entities",
        "an external document type",
        _described(BASE_XML.replace("?>", '?><!DOCTYPE b SYSTEM "http://127.0.0.1:9/b.dtd">', 1)),
    ),
    _changed("binary.present", "no binaries", _without(BINARY)),
    # 2.3: names, layout, binaries, sources
    Defect("archive.extension", "a .zip", lambda file: write(file.with_suffix(".zip"), members())),
    _with("archive.backslash", "a backslash in a path", {"resources\\table.txt": b"x"}),
    _with("archive.unique", "two names that differ in case", {"resources/A.txt": b"x", "resources/a.txt": b"y"}),
    _with("archive.entries", "a folder of its own", {"stuff/a.txt": b"x"}),
    _with("archive.model-png", "a picture that is none", {"model.png": b"<svg/>"}),
    _with("archive.documentation", "documentation without index.html", {"documentation/a.txt": b"x"}),
    _changed("binary.name", "a binary of another name", _moved(BINARY, "binaries/linux64/other.so")),
    _with("binary.platform", "a platform of another name", {"binaries/amiga/Fixture.library": b"x"}),
    _changed("binary.format", "a text file as binary", _binary(lambda _: b"This is a library.")),
    _changed("binary.format", "a truncated binary", _binary(lambda data: data[:1000])),
    _changed("binary.format", "a binary for another processor", _binary(_other_machine)),
    _with("binary.format", "a Linux library for Windows", {"binaries/win64/Fixture.dll": library()}),
    _changed("binary.exports", "a function with a prefix", _binary(_prefixed)),
    _changed("binary.exports", "no functions for the state", _binary(_without_state)),
    _changed(
        "binary.exports-all",
        "no functions for the state, unclaimed",
        lambda content: _binary(_without_state)(_described(_NO_STATE_XML)(content)),
    ),
    _changed("source.listed", "a listed source file is missing", _described(_SOURCES_XML)),
    Defect("source.unique", "a source file listed twice", lambda file: write(
        file, members(_SOURCES_XML.replace('<File name="no.c"/>', 2 * '<File name="all.c"/>'))
        | {"sources/all.c": b"int a;"})),
    _with("source.list", "sources without a list", {"sources/all.c": b"int main(void) { return 0; }"}),
)
