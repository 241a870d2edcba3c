"""Files that appear whole or not at all."""
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ..errors import RunError


def reason(error: OSError) -> str:
    """What the system says, without what libraries put around it."""
    return os.strerror(error.errno) if error.errno else str(error)


def synced(path: Path) -> None:
    """Have the file or folder at `path` on the disk, so that a power cut does not take it. Raises OSError."""
    handle = os.open(path, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


@contextmanager
def replacing(path: Path, partial: Path) -> Iterator[Path]:
    """`partial`, beside `path`, to write to: it takes the place of `path` at the end and is removed after an exception.

    Raises OSError if that is not possible.
    """
    try:
        yield partial
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """As `replacing`, with a name of its own, and on the disk before it takes the place of `path`.

    Raises RunError, one sentence, if it cannot be written: the disk is full, for example. `path` is then as before.
    """
    try:
        with replacing(path, path.with_name(f".{path.name}.partial")) as partial:
            yield partial
            synced(partial)
    except OSError as error:
        raise RunError(f"{path} cannot be written: {reason(error)}.") from None
