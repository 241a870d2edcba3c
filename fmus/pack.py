"""Archives (FMU, SSP) as mappings of paths to bytes, written the same way every time."""
import errno
import hashlib
import os
import zipfile
from pathlib import Path


def digest(files: dict[str, bytes]) -> str:
    """SHA-256 over names and contents."""
    sha = hashlib.sha256()
    for name in sorted(files):
        sha.update(name.encode() + b"\0" + hashlib.sha256(files[name]).digest())
    return sha.hexdigest()


def write(path: Path, files: dict[str, bytes]) -> None:
    """Write `files` as a zip archive at `path`: sorted, dateless, byte for byte reproducible; whole or not at all.

    Raises OSError if `path` cannot be written.
    """
    if not path.name:  # "/", or ""
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f"{path.name}.{os.getpid()}")
    try:
        with zipfile.ZipFile(partial, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
            for name in sorted(files):
                entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
                entry.compress_type = zipfile.ZIP_DEFLATED
                entry.external_attr = 0o644 << 16
                archive.writestr(entry, files[name])
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)
