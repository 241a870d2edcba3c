"""Unpacks an archive of unknown origin: nothing is written outside the given folder, and claimed sizes are not trusted.

    extract_to = Path(tempfile.mkdtemp())
    safe_extract(Path("some.fmu"), extract_to)      # raises BadArchive with one sentence

Section 2.3 (FMU Distribution) says what an FMU's archive looks like.
"""
import stat
import zipfile
import zlib
from os.path import isfile
from pathlib import Path, PureWindowsPath
from typing import IO

from ..temporary import troubles

MAX_TOTAL_BYTES = 1 << 30  # 1 GiB unpacked; no FMU that a workstation can load is larger
MAX_MEMBERS = 100_000
MAX_MEMBER_BYTES = 100_000_000  # of one that is read into memory
CHUNK_BYTES = 1 << 16


class BadArchive(Exception):
    """The archive cannot be unpacked safely; `rule` names the conformance rule that it breaks."""

    def __init__(self, rule: str, sentence: str):
        super().__init__("".join(c if c.isprintable() else "?" for c in sentence))
        self.rule = rule


def safe_extract(archive: Path, folder: Path, max_total_bytes: int = MAX_TOTAL_BYTES, needless: tuple[str, ...] = ()
                 ) -> list[str]:
    """Unpack `archive` into `folder` and return the member names; raise `BadArchive` before anything escapes.

    All members are looked at before the first byte is written. Sizes are counted while unpacking, because a header can
    claim any size. Members whose names begin with one of `needless` are not written. `folder` must exist; the caller
    removes it, also after an exception.
    """
    with open_archive(archive) as file:
        members = file.infolist()
        refuse_unsafe_names(members, folder)
        refuse_unreadable(members)
        refuse_large_claims(members, max_total_bytes)
        budget = max_total_bytes
        for member in members:
            if not member.filename.startswith(needless):
                budget -= unpack(file, member, folder, budget, max_total_bytes)
        return [member.filename for member in members]


def read_member(archive: Path, name: str, most: int = MAX_MEMBER_BYTES) -> bytes:
    """The content of one member of `archive`, without unpacking the others.

    Raises BadArchive if it is not there, cannot be read, or has more than `most` bytes.
    """
    with open_archive(archive) as file:
        try:
            member = file.getinfo(name)
        except KeyError:
            raise BadArchive("archive.readable", f"there is no member '{short(name)}'") from None
        refuse_unreadable([member])
        try:
            with file.open(member) as source:
                content = source.read(most + 1)
        except (zipfile.BadZipFile, zlib.error, EOFError, OSError, ValueError, NotImplementedError) as problem:
            sentence = f"the member '{short(name)}' is truncated or damaged ({str(problem) or 'end of file'})"
            raise BadArchive("archive.readable", sentence) from None
    if len(content) > most:
        raise too_large(f"the member '{short(name)}' has more", most)
    return content


def open_archive(archive: Path) -> zipfile.ZipFile:
    """The archive opened for reading. Raises BadArchive if it is missing or no zip file."""
    if not isfile(archive):
        raise BadArchive("archive.readable", f"there is no file '{archive}'")
    try:
        return zipfile.ZipFile(archive)
    except zipfile.BadZipFile as problem:
        what = "is a zip file that is truncated or damaged" if begins_as_zip(archive) else "is not a zip file"
        raise BadArchive("archive.readable", f"'{archive.name}' {what} ({str(problem).rstrip('.')})") from None
    except (OSError, ValueError, NotImplementedError) as problem:
        raise BadArchive("archive.readable", f"'{archive.name}' cannot be read as a zip file ({problem})") from None


def begins_as_zip(archive: Path) -> bool:
    """Whether the first bytes of the file, if they can be read, are those of a zip file."""
    try:
        with archive.open("rb") as start:
            return start.read(4) == b"PK\x03\x04"
    except OSError:
        return False


def refuse_unsafe_names(members: list[zipfile.ZipInfo], folder: Path) -> None:
    """Raises BadArchive for an absolute path, a drive letter, `..` or a link: every member stays inside `folder`."""
    if len(members) > MAX_MEMBERS:
        sentence = f"the archive lists {len(members)} files; at most {MAX_MEMBERS} are unpacked"
        raise BadArchive("archive.size", sentence)
    for member in members:
        path = PureWindowsPath(member.orig_filename)  # knows both separators and drive letters
        outside = path.drive or path.root or ".." in path.parts or "\0" in member.orig_filename
        if outside or not (folder / member.filename).resolve().is_relative_to(folder.resolve()):
            sentence = f"the member '{short(member.orig_filename)}' leads outside of the archive's folder"
            raise BadArchive("archive.paths", sentence)
        if stat.S_ISLNK(member.external_attr >> 16):
            raise BadArchive("archive.paths", f"the member '{short(member.filename)}' is a symbolic link")


def refuse_unreadable(members: list[zipfile.ZipInfo]) -> None:
    """Raises BadArchive for a member that is encrypted, or compressed other than by deflate."""
    for member in members:
        if member.flag_bits & 0x1:
            raise BadArchive("archive.encrypted", f"the member '{short(member.filename)}' is encrypted")
        if member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            raise BadArchive("archive.compression", f"the member '{short(member.filename)}' is compressed by method "
                                                    f"{member.compress_type}, not deflate")


def refuse_large_claims(members: list[zipfile.ZipInfo], max_total_bytes: int) -> None:
    """Raises BadArchive if the members claim more than `max_total_bytes`."""
    for member in members:
        if member.file_size > max_total_bytes:
            raise too_large(f"the member '{short(member.filename)}' claims {member.file_size} bytes", max_total_bytes)
    total = sum(member.file_size for member in members)
    if total > max_total_bytes:
        raise too_large(f"the members claim {total} bytes together", max_total_bytes)


def unpack(file: zipfile.ZipFile, member: zipfile.ZipInfo, folder: Path, budget: int, allowed: int) -> int:
    """Write one member below `folder`; the number of bytes it really had.

    Raises BadArchive if it is damaged, or has more than `budget` bytes; NoTemporaryFolder if `folder` does not take it.
    """
    target = folder / member.filename
    try:
        with troubles(folder):
            return written(file, member, target, budget, allowed)
    except (zipfile.BadZipFile, zlib.error, EOFError) as problem:
        sentence = f"the member '{short(member.filename)}' is truncated or damaged ({str(problem) or 'end of file'})"
        raise BadArchive("archive.readable", sentence) from None
    except (OSError, ValueError, NotImplementedError, RuntimeError) as problem:
        sentence = f"the member '{short(member.filename)}' cannot be unpacked ({problem})"
        raise BadArchive("archive.readable", sentence) from None


def written(file: zipfile.ZipFile, member: zipfile.ZipInfo, target: Path, budget: int, allowed: int) -> int:
    """Write one member to `target`; see `unpack`."""
    if member.is_dir():
        target.mkdir(parents=True, exist_ok=True)
        return 0
    target.parent.mkdir(parents=True, exist_ok=True)
    with file.open(member) as source, target.open("wb") as sink:
        return copy(source, sink, budget, allowed, member.filename)


def copy(source: IO[bytes], sink: IO[bytes], budget: int, allowed: int, name: str) -> int:
    """Copy to the end; the number of bytes. Raises BadArchive after more than `budget` of them."""
    written = 0
    while chunk := source.read(CHUNK_BYTES):
        written += len(chunk)
        if written > budget:
            raise too_large(f"the members up to '{short(name)}' unpack to more bytes", allowed)
        sink.write(chunk)
    return written


def too_large(what: str, allowed: int) -> BadArchive:
    """The error for an archive that unpacks to more than `allowed` bytes."""
    return BadArchive("archive.size", f"{what}; at most {allowed} bytes are unpacked")


def short(name: str) -> str:
    """`name` in at most 80 characters."""
    return name if len(name) <= 80 else name[:77] + "..."
