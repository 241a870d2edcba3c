"""Opening an archive that comes from a stranger: nothing is written outside the given folder, no size is believed.

    extract_to = Path(tempfile.mkdtemp())
    safe_extract(Path("some.fmu"), extract_to)      # raises BadArchive with one sentence

Section 2.3 (FMU Distribution) says what an FMU's archive looks like.
"""

import stat
import zipfile
import zlib
from pathlib import Path, PureWindowsPath
from typing import IO

MAX_TOTAL_BYTES = 1 << 30  # 1 GiB unpacked; no FMU that a workstation can load is larger
MAX_MEMBERS = 100_000
_CHUNK = 1 << 16


class BadArchive(Exception):
    """The archive cannot be unpacked safely; `rule` names the conformance rule that it breaks."""

    def __init__(self, rule: str, sentence: str) -> None:
        super().__init__("".join(c if c.isprintable() else "?" for c in sentence))
        self.rule = rule


def safe_extract(archive: Path, folder: Path, max_total_bytes: int = MAX_TOTAL_BYTES) -> list[str]:
    """Unpack `archive` into `folder` and return the member names; raise `BadArchive` before anything escapes.

    All members are looked at before the first byte is written. Sizes are counted while unpacking, because a header can
    claim any size. `folder` must exist; removing it, also after an exception, is the caller's business.
    """
    with _open(archive) as file:
        members = file.infolist()
        _refuse_unsafe_names(members, folder)
        _refuse_unreadable(members)
        _refuse_large_claims(members, max_total_bytes)
        budget = max_total_bytes
        for member in members:
            budget -= _unpack(file, member, folder, budget, max_total_bytes)
        return [member.filename for member in members]


def _open(archive: Path) -> zipfile.ZipFile:
    if not archive.is_file():
        raise BadArchive("archive.readable", f"there is no file '{archive}'")
    try:
        return zipfile.ZipFile(archive)
    except zipfile.BadZipFile as problem:
        with archive.open("rb") as start:
            looks_like_zip = start.read(4) == b"PK\x03\x04"
        what = "is a zip file that is truncated or damaged" if looks_like_zip else "is not a zip file"
        raise BadArchive("archive.readable", f"'{archive.name}' {what} ({str(problem).rstrip('.')})") from None
    except (OSError, ValueError, NotImplementedError) as problem:
        raise BadArchive("archive.readable", f"'{archive.name}' cannot be read as a zip file ({problem})") from None


def _refuse_unsafe_names(members: list[zipfile.ZipInfo], folder: Path) -> None:
    """No absolute path, no drive letter, no `..`, no link: every member stays inside the folder."""
    if len(members) > MAX_MEMBERS:
        sentence = f"the archive lists {len(members)} files; at most {MAX_MEMBERS} are unpacked"
        raise BadArchive("archive.size", sentence)
    for member in members:
        path = PureWindowsPath(member.orig_filename)  # knows both separators and drive letters
        outside = path.drive or path.root or ".." in path.parts or "\0" in member.orig_filename
        if outside or not (folder / member.filename).resolve().is_relative_to(folder.resolve()):
            sentence = f"the member '{_short(member.orig_filename)}' leads outside of the archive's folder"
            raise BadArchive("archive.paths", sentence)
        if stat.S_ISLNK(member.external_attr >> 16):
            raise BadArchive("archive.paths", f"the member '{_short(member.filename)}' is a symbolic link")


def _refuse_unreadable(members: list[zipfile.ZipInfo]) -> None:
    for member in members:
        if member.flag_bits & 0x1:
            raise BadArchive("archive.encrypted", f"the member '{_short(member.filename)}' is encrypted")
        if member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            sentence = (
                f"the member '{_short(member.filename)}' is compressed by method {member.compress_type}, not deflate"
            )
            raise BadArchive("archive.compression", sentence)


def _refuse_large_claims(members: list[zipfile.ZipInfo], max_total_bytes: int) -> None:
    for member in members:
        if member.file_size > max_total_bytes:
            raise _too_large(f"the member '{_short(member.filename)}' claims {member.file_size} bytes", max_total_bytes)
    total = sum(member.file_size for member in members)
    if total > max_total_bytes:
        raise _too_large(f"the members claim {total} bytes together", max_total_bytes)


def _unpack(file: zipfile.ZipFile, member: zipfile.ZipInfo, folder: Path, budget: int, allowed: int) -> int:
    """Write one member and return how many bytes it really had."""
    target = folder / member.filename
    try:
        if member.is_dir():
            target.mkdir(parents=True, exist_ok=True)
            return 0
        target.parent.mkdir(parents=True, exist_ok=True)
        with file.open(member) as source, target.open("wb") as sink:
            return _copy(source, sink, budget, allowed, member.filename)
    except (zipfile.BadZipFile, zlib.error, EOFError) as problem:
        sentence = f"the member '{_short(member.filename)}' is truncated or damaged ({str(problem) or 'end of file'})"
        raise BadArchive("archive.readable", sentence) from None
    except (OSError, ValueError, NotImplementedError, RuntimeError) as problem:
        sentence = f"the member '{_short(member.filename)}' cannot be unpacked ({problem})"
        raise BadArchive("archive.readable", sentence) from None


def _copy(source: IO[bytes], sink: IO[bytes], budget: int, allowed: int, name: str) -> int:
    written = 0
    while chunk := source.read(_CHUNK):
        written += len(chunk)
        if written > budget:
            raise _too_large(f"the members up to '{_short(name)}' unpack to more bytes", allowed)
        sink.write(chunk)
    return written


def _too_large(what: str, allowed: int) -> BadArchive:
    return BadArchive("archive.size", f"{what}; at most {allowed} bytes are unpacked")


def _short(name: str) -> str:
    return name if len(name) <= 80 else name[:77] + "..."
