"""Temporary folders that do not stay: each goes when it is closed or unused, at the end of the program, and after a
program that was killed when the next one starts.

    folder = Folder()
    with troubles(folder.path):        # a full disk is no fault of what is written there
        (folder.path / "some.txt").write_text("...")
    folder.close()

A lock on the folder tells that its program lives. It is the kernel's, so that it ends with the program; a process that
the program forked holds it, too.
"""
import contextlib
import errno
import os
import re
import secrets
import shutil
import tempfile
import weakref
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Self

from .errors import UsageError

PREFIX = "ahv-temporary-"
NAME = re.compile(PREFIX + "[0-9a-f]{16}")
FULL = (errno.ENOSPC, errno.EDQUOT)
OURS = (*FULL, errno.EACCES, errno.EPERM, errno.EROFS, errno.EIO)  # about the place, not about a name or a content


class NoTemporaryFolder(UsageError):
    """The folder for temporary files is full or cannot be written to. No file that was to be unpacked is to blame."""


class Folder:
    """A new folder, `path`. It also works as a context manager. Raises NoTemporaryFolder if it cannot be made."""

    def __init__(self) -> None:
        parent = place()
        sweep(parent)
        self.path = parent / f"{PREFIX}{secrets.token_hex(8)}"
        lock: list[int] = []
        self.close = weakref.finalize(self, remove, self.path, lock, os.getpid())  # before there is anything to remove
        try:
            unlocked(self.path).mkdir(0o700)
            lock.extend(locked(unlocked(self.path)))
            unlocked(self.path).rename(self.path)
        except OSError as error:
            raise trouble(error, parent) from None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def unlocked(path: Path) -> Path:
    """What the folder `path` is called until it is locked, so that no other program takes it for one of the dead."""
    return path.with_name(f".{path.name}")


def place() -> Path:
    """Where temporary folders are made. This is TMPDIR if it is set: another folder is not taken without a word.

    Raises NoTemporaryFolder if the system has no such folder.
    """
    try:
        return Path(os.path.abspath(tempfile.tempdir or os.environ.get("TMPDIR") or tempfile.gettempdir()))
    except FileNotFoundError as error:
        sentence = f"There is no folder for temporary files: {error.strerror}. Name one with TMPDIR."
        raise NoTemporaryFolder(sentence) from None


@contextlib.contextmanager
def troubles(folder: Path) -> Iterator[None]:
    """Around what writes below `folder`: raises NoTemporaryFolder where an OSError says that this place refuses."""
    try:
        yield
    except OSError as error:
        if error.errno not in OURS:
            raise
        raise trouble(error, folder) from None


def trouble(error: OSError, folder: Path) -> NoTemporaryFolder:
    """What to raise instead of an `error` in writing below `folder`."""
    name = next((path.parent for path in (*reversed(folder.parents), folder) if NAME.fullmatch(path.name)), folder)
    what = "is full" if error.errno in FULL else f"cannot be written to: {error.strerror}"
    return NoTemporaryFolder(f"TMPDIR {name} {what}.")


def remove(path: Path, lock: list[int], owner: int) -> None:
    """Remove a folder of the process `owner`. A signal's exception that comes meanwhile leaves nothing behind."""
    if os.getpid() != owner:  # a fork has a copy of the object, and the folder is not its own
        return
    try:
        empty(path)
    except BaseException:
        empty(path)
        raise
    finally:
        while lock:
            os.close(lock.pop())


def empty(path: Path) -> None:
    """Remove a folder, whatever its state."""
    shutil.rmtree(path, ignore_errors=True)
    shutil.rmtree(unlocked(path), ignore_errors=True)


def locked(path: Path) -> list[int]:
    """The descriptor that holds a lock on the folder `path`; empty where there are no locks.

    Raises OSError if there is no such folder, BlockingIOError if a process has it locked.
    """
    try:
        import fcntl
    except ImportError:  # Windows
        return []
    descriptor = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        os.close(descriptor)
        if error.errno in (errno.ENOSYS, errno.ENOTSUP, errno.ENOLCK, errno.EINVAL):
            return []
        raise
    return [descriptor]


@cache
def sweep(parent: Path) -> None:
    """Remove the folders that killed programs of this user have left in `parent`; once in a process."""
    for path in parent.glob(f"{PREFIX}*") if hasattr(os, "getuid") else ():
        with contextlib.suppress(OSError):
            lock = locked(path) if NAME.fullmatch(path.name) and path.lstat().st_uid == os.getuid() else []
            if lock:
                remove(path, lock, os.getpid())
