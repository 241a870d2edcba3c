"""Results that appear together or not at all, in a folder that `folder.claimed` has claimed.

What is not for readers is below `.ahv/` in the folder:

    kind.json       whose folder it is; locked while somebody writes
    staged/         files that wait to appear
    rows.arrows     rows of a flight with --stream, and request.json, what was asked for; both until it has ended

Each kind of results has a head, the file that says what the others are. It is the first to go and the last to come, and
names the SHA-256 of the others: whoever sees it sees its own files. A staged head means that all is staged: whoever
claims the folder after a kill can finish.
"""
import hashlib
import json
import shutil
import signal
import tempfile
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import RunError
from .whole_file import full, reason, synced

OWN, STAGED, ROWS, REQUEST = ".ahv", "staged", "rows.arrows", "request.json"
ASKING = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
Fill = Callable[[Path], None]  # writes files into a folder


@dataclass(frozen=True)
class Kind:
    """One kind of results."""
    words: str
    head: str
    key: str                 # in every head of ours
    files: tuple[str, ...]   # patterns of what is beside the head


KINDS = {
    "run": Kind("a run", "run.json", "controller", ("signals.parquet", "signals.csv", "figures")),
    "simulate": Kind("a simulation", "run.json", "system", ("signals.parquet", "signals.csv")),
    "compare": Kind("a comparison", "compare.json", "controllers", ("compare_*.png",)),
    "campaign": Kind("a campaign", "campaign.json", "dispersions", (
        "campaign.yaml", "parts", "runs.parquet", "signals.parquet", "errors.parquet", "report.html", "report.json",
        "figures")),
    "tune": Kind("a tuning", "tune.json", "budget", ()),
}


@dataclass(frozen=True)
class Published:
    """Where the files are, and what did not fit, in one sentence (empty: everything did)."""
    folder: Path
    trouble: str


def publish(folder: Path, kind: str, record: dict[str, Any], must: Fill, extras: Sequence[Fill] = (),
            streamed: bool = False) -> Published:
    """Replace the results in `folder` by what `must` and `extras` write, and a head with `record`.

    Where there is no room for all, extras are left out. Where there is none for the others, they go to a temporary
    folder, and the former results stay. Signals that ask for an end wait until all is in place; extras that have not
    begun are left out.

    `streamed` means that the rows are on the disk already, and stay where this fails. Then there is no temporary
    folder, and a signal ends the writing.

    Raises RunError, one sentence, if there is no room anywhere.
    """
    why = ""
    with ExitStack() as stack:
        signals = [] if streamed else stack.enter_context(held())
        for target in (folder,) if streamed else (folder, Path(tempfile.gettempdir())):
            try:
                place = folder if target is folder else Path(tempfile.mkdtemp(prefix="ahv_kept_"))
                left_out = stage(place, kind, record, must, extras, signals)
                with held():
                    move(place, kind)
            except OSError as error:
                if not full(error):
                    raise RunError(f"{target} cannot be written to: {reason(error)}.") from None
                why = why or reason(error)
                continue
            if target is not folder:
                return Published(place, f"{folder}: {why}: the results are in {place} instead.")
            return Published(place, f"{folder}: {left_out}: there is {', '.join(files(place, kind))}, no more."
                             if left_out else "")
    if streamed:
        raise RunError(f"{folder}: {why}. The rows flown so far are kept: make room, then `ahv recover {folder}`.")
    raise RunError(f"{folder}: {why}. There is no room in {tempfile.gettempdir()} either: the results are lost.")


def files(folder: Path, kind: str) -> list[str]:
    """The head of the results in `folder`, and the files that it names."""
    head = KINDS[kind].head
    return [*read(folder / head).get("files", {}), head]


def stage(place: Path, kind: str, record: dict[str, Any], must: Fill, extras: Sequence[Fill], signals: list[int]
          ) -> str:
    """Write everything into the staging folder of `place`, the head last; why extras were left out, or an empty text.

    Once there is an entry in `signals`, no further extra is begun. Raises OSError if there is no room for the rest;
    nothing is left then.
    """
    staged, head, why = place / OWN / STAGED, KINDS[kind].head, ""
    record = {"kind": kind, **record, "out": str(place)}
    shutil.rmtree(staged, ignore_errors=True)
    try:
        staged.mkdir(parents=True)
        must(staged)
        kept = below(staged)
        try:
            for extra in extras:
                if signals:
                    why = "interrupted"
                    break
                extra(staged)
            write_head(staged, head, record)
        except OSError as error:
            if not full(error):
                raise
            why = reason(error)
            for path in below(staged) - kept:
                path.unlink()
            write_head(staged, head, record)
    except BaseException:
        shutil.rmtree(staged, ignore_errors=True)
        raise
    return why


def below(folder: Path) -> set[Path]:
    """All files in a folder and its folders."""
    return {path for path in folder.rglob("*") if path.is_file()}


def write_head(staged: Path, head: str, record: dict[str, Any]) -> None:
    """Write the head, once all other files are on the disk. Raises OSError."""
    hashes = {}
    for path in sorted(below(staged)):
        synced(path)
        with open(path, "rb") as file:
            hashes[path.relative_to(staged).as_posix()] = hashlib.file_digest(file, "sha256").hexdigest()
    partial = staged.with_name(f"{head}.partial")
    try:
        partial.write_text(json.dumps({**record, "files": hashes}, indent=2) + "\n")
        synced(partial)
        partial.replace(staged / head)
        synced(staged)
    finally:
        partial.unlink(missing_ok=True)


def move(folder: Path, kind: str) -> None:
    """Let what is staged take the place of the former results. After a kill at any moment it can be done again."""
    own, head = folder / OWN, folder / KINDS[kind].head
    staged, former = own / STAGED, own / "former.json"
    if head.exists():
        head.replace(former)
        synced(folder)
    if former.exists():
        for name in read(former).get("files", KINDS[kind].files):
            if fits(name, kind) and (folder / name).is_file():
                (folder / name).unlink()
    for name in (ROWS, REQUEST):
        (own / name).unlink(missing_ok=True)
    for path in sorted(below(staged) - {staged / head.name}):
        target = folder / path.relative_to(staged)
        target.parent.mkdir(exist_ok=True)
        path.replace(target)
    synced(folder)
    (staged / head.name).replace(head)
    synced(folder)
    former.unlink(missing_ok=True)
    shutil.rmtree(staged, ignore_errors=True)


def fits(name: Any, kind: str) -> bool:
    """Whether a head may name this file as one of its kind's: never a path that leads elsewhere."""
    path = Path(name) if isinstance(name, str) else Path()
    return (len(path.parts) in (1, 2) and ".." not in path.parts and not path.is_absolute()
            and any(Path(path.parts[0]).match(pattern) for pattern in KINDS[kind].files))


def read(path: Path) -> dict[str, Any]:
    """The JSON object in a file; an empty one if there is none."""
    try:
        found = json.loads(path.read_bytes())
    except (OSError, ValueError, RecursionError):
        return {}
    return found if isinstance(found, dict) else {}


@contextmanager
def held() -> Iterator[list[int]]:
    """Signals that ask for an end wait until the end of the context; meanwhile they are entries of a list."""
    caught: list[int] = []
    if threading.current_thread() is not threading.main_thread():
        yield caught
        return
    before = {s: signal.signal(s, lambda number, _: caught.append(number)) for s in ASKING}
    try:
        yield caught
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        if caught:
            signal.raise_signal(caught[0])
