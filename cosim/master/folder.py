"""A folder of results: whose it is, and one writer at a time.

    with claimed(out, "run", "case1") as folder:             # results/run/case1 if `out` is None
        published = publish(folder, "run", record, must, extras)
"""
import json
import os
import shutil
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from pathlib import Path
from typing import IO

from ..errors import UsageError
from .interruptions import interruptions
from .publish import KINDS, OWN, REQUEST, ROWS, STAGED, Kind, move, read
from .whole_file import reason

MARK = "kind.json"


def expanded(path: Path) -> Path:
    """`path` with ~ as the home folder. Raises UsageError if there is no such home."""
    try:
        return path.expanduser()
    except RuntimeError:
        raise UsageError(f"{path} has no meaning: there is no such home folder.") from None


@contextmanager
def claimed(out: Path | None, kind: str, name: str, recover: bool = False) -> Iterator[Path]:
    """The folder `out`, else results/KIND/NAME: for this process alone, as long as the context lasts.

    Raises UsageError, one sentence, if it cannot be written to, if it holds results of another kind or files of others
    that would be replaced, if somebody writes there, or if a flight that was killed left rows (unless to `recover`).
    """
    folder = expanded(out) if out else Path("results") / kind / name
    try:
        with opened(folder, kind) as lock:
            if not locked(lock, folder / OWN / MARK):
                raise UsageError(f"Another ahv is writing to {folder} just now: wait, or give --out another folder.")
            check_owner(folder, kind)
            mark(lock, kind)
            settle(folder, kind)
            if not recover:
                tried(folder / OWN / "probe")
            rows = folder / OWN / ROWS
            if rows.exists() and not recover:
                raise UsageError(f"{folder} has rows of a flight that was killed: `ahv recover {folder}` makes results "
                                 f"of them; delete {rows} to give them up.")
            try:
                yield folder
            finally:
                leave(folder, kind)
    except Unusable as error:
        raise UsageError(f"--out {folder} cannot be written to: {error}.") from None


@contextmanager
def flown_into(out: Path | None, kind: str, name: str, streamed: bool) -> Iterator[tuple[Path, list[int]]]:
    """The folder of `claimed` for a flight and its results, and a list of the signals that came meanwhile.

    They let the writing of results end, but for a flight whose rows are `streamed`: these are on the disk already.
    """
    holding: AbstractContextManager[list[int]] = nullcontext([]) if streamed else interruptions()
    with claimed(out, kind, name) as folder, holding as interrupted:
        yield folder, interrupted


class Unusable(Exception):
    """Why a folder cannot be written to."""


@contextmanager
def opened(folder: Path, kind: str) -> Iterator[IO[bytes]]:
    """The file that marks the folder, which is made. Raises Unusable, and UsageError as `check_owner`."""
    own = folder / OWN
    try:
        check_owner(folder, kind)
        own.mkdir(parents=True, exist_ok=True)
        lock = open(own / MARK, "a+b", buffering=0)  # noqa: SIM115 (closed below)
    except OSError as error:
        raise Unusable(reason(error)) from None
    except ValueError as error:  # a NUL character
        raise Unusable(error) from None
    with lock:
        yield lock


def tried(path: Path) -> None:
    """Write a file and remove it. Raises Unusable if that cannot be done."""
    try:
        path.write_bytes(bytes(4096))
    except OSError as error:
        raise Unusable(reason(error)) from None
    finally:
        path.unlink(missing_ok=True)


def mark(lock: IO[bytes], kind: str) -> None:
    """Write down the kind of results. Raises Unusable."""
    text = json.dumps({"kind": kind}).encode() + b"\n"
    lock.seek(0)
    if lock.read() == text:
        return
    try:
        lock.truncate(0)
        lock.write(text)
    except OSError as error:
        raise Unusable(reason(error)) from None


def locked(lock: IO[bytes], path: Path) -> bool:
    """Lock the file that was opened at `path` for as long as the process lives; False if somebody else has it.

    Raises Unusable where files cannot be locked. Windows has no such locks: True.
    """
    try:
        import fcntl
    except ImportError:
        return True
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        return path.stat().st_ino == os.fstat(lock.fileno()).st_ino  # not removed since by its former owner
    except (BlockingIOError, FileNotFoundError):
        return False
    except OSError as error:
        raise Unusable(f"it cannot be locked: {reason(error)}") from None


def check_owner(folder: Path, kind: str) -> None:
    """Raises UsageError if the folder holds results of another kind, or files of others that we would replace."""
    found = kind_of(folder)
    if found not in (None, kind):
        raise UsageError(f"{folder} holds {KINDS[found].words}; give --out another folder.")
    if found is None:
        for pattern in (KINDS[kind].head, *KINDS[kind].files):
            for path in folder.glob(pattern):
                raise UsageError(f"{folder} has {path.name}, which ahv did not write; give --out another folder.")


def kind_of(folder: Path) -> str | None:
    """Which kind of results a folder holds, a key of KINDS; None if none."""
    marked = str(read(folder / OWN / MARK).get("kind"))
    if marked in KINDS and has(folder, KINDS[marked], f"{OWN}/{ROWS}", f"{OWN}/{STAGED}"):
        return marked
    for name, kind in KINDS.items():  # copied without the mark, or written by a version that had none
        head = read(folder / kind.head)
        if head.get("kind", name) == name and kind.key in head:
            return name
    return None


def has(folder: Path, kind: Kind, *more: str) -> bool:
    """Whether a folder that is marked as one of `kind` has results, or one of the files `more`."""
    return any((folder / name).exists() for name in (kind.head, *kind.signs, *more))


def settle(folder: Path, kind: str) -> None:
    """Finish what a killed process had staged, or remove it. Raises Unusable if that cannot be done."""
    own, staged = folder / OWN, folder / OWN / STAGED
    try:
        if (staged / KINDS[kind].head).exists():
            move(folder, kind)
        shutil.rmtree(staged, ignore_errors=True)
        for path in own.iterdir():
            if path.name not in (MARK, ROWS, REQUEST):
                path.unlink()
    except OSError as error:
        raise Unusable(f"{own} has what a killed process left: {reason(error)}") from None


def leave(folder: Path, kind: str) -> None:
    """Remove our mark from a folder that has no results, and the folder if it is empty."""
    own = folder / OWN
    if not has(folder, KINDS[kind]) and {p.name for p in own.iterdir()} <= {MARK, REQUEST}:
        shutil.rmtree(own, ignore_errors=True)
        with suppress(OSError):  # the user has files there
            folder.rmdir()
