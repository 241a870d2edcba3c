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
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .interruptions import HELD, interruptions
from .whole_file import reason, synced

OWN, STAGED, ROWS, REQUEST = ".ahv", "staged", "rows.arrows", "request.json"
Fill = Callable[[Path], None]  # writes files into a folder


@dataclass(frozen=True)
class Kind:
    """One kind of results."""
    words: str
    head: str
    key: str                 # in every head of ours
    files: tuple[str, ...]   # patterns of what is beside the head
    signs: tuple[str, ...] = ()  # of these files each says that the folder, if so marked, is ours without a head


KINDS = {
    "run": Kind("a run", "run.json", "controller", ("signals.parquet", "signals.csv", "figures", "report.html")),
    "simulate": Kind("a simulation", "run.json", "system", (
        "signals.parquet", "signals.csv", "figures", "report.html")),
    "compare": Kind("a comparison", "compare.json", "controllers", ("compare_*.png", "report.html", "runs")),
    "campaign": Kind("a campaign", "campaign.json", "dispersions", (
        "campaign.yaml", "parts", "receipt.json", "runs.parquet", "signals.parquet", "errors.parquet", "report.html",
        "report.json", "figures"), ("receipt.json", "parts/.campaign")),
    "fit": Kind("a fit", "fit.json", "correlation", ("fit.parquet", "fit*.png", "inputs_*.csv")),
    "tune": Kind("a tuning", "tune.json", "budget", ()),
}


@dataclass(frozen=True)
class Published:
    """Where the results are, and which could not be written, in one sentence (empty: all are there)."""
    folder: Path
    trouble: str


def publish(folder: Path, kind: str, record: dict[str, Any], must: Fill, extras: Sequence[Fill] = (),
            less: Fill | None = None, rows: Path | None = None, interrupted: int = 0) -> Published:
    """Replace the results in `folder` by what `must` and `extras` write, and a head with `record`.

    Where there is no room for all, the last extras are left out. Where there is none for `must`, the results go to a
    temporary folder, and the former ones stay; without room there, `less` writes as much as fits. Signals that ask for
    an end wait until all is in place; extras that have not begun are left out.

    `rows` is the file that `must` reads, if it does. It goes when all is in place. Where this fails it stays, so there
    is nothing to fall back to, and a signal ends the writing. `interrupted` is the signal that came before, or 0: then
    there are no extras.
    """
    def put(place: Path, fill: Fill, **more: str) -> str:
        left_out = stage(place, kind, {**record, **more}, fill, extras, signals)
        with held():
            move(place, kind)
            if rows:
                forget(rows.parent.parent)
        return left_out

    with ExitStack() as stack:
        signals = ([interrupted] if interrupted else []) if rows else stack.enter_context(held())
        try:
            left_out = put(folder, must)
            only = " and ".join(files(folder, kind))
            return Published(folder, f"{folder}: {left_out}: only {only} could be written." if left_out else "")
        except OSError as error:
            why = f"{folder}: {reason(error)}"
        if rows:
            return Published(folder, f"{why}. The rows flown so far are kept: make room or choose another folder with "
                                     f"--out, then `ahv recover {rows.parent.parent}`.")
        with suppress(OSError), temporary() as place:
            put(place, must)
            return Published(place, f"{why}: the results are in {place} instead.")
        if less:
            with suppress(OSError):
                put(folder, less, left_out="the later rows")
                return Published(folder, f"{why}: only the first rows could be written.")
    return Published(folder, f"{why}, and {tempfile.gettempdir()} has no room either: nothing was written.")


@contextmanager
def temporary() -> Iterator[Path]:
    """A new temporary folder, which is removed after an exception. Raises OSError."""
    place = Path(tempfile.mkdtemp(prefix="ahv_kept_"))
    try:
        yield place
    except BaseException:
        shutil.rmtree(place, ignore_errors=True)
        raise


def files(folder: Path, kind: str) -> list[str]:
    """The head of the results in `folder`, and the files that it names."""
    head = KINDS[kind].head
    return [*read(folder / head).get("files", {}), head]


def stage(place: Path, kind: str, record: dict[str, Any], must: Fill, extras: Sequence[Fill], signals: list[int]
          ) -> str:
    """Write everything into the staging folder of `place`, the head last; why extras were left out, or an empty text.

    Once there is an entry in `signals`, no further extra is begun. Raises OSError if the rest cannot be written;
    nothing is left then.
    """
    staged, head, why = place / OWN / STAGED, KINDS[kind].head, ""
    record = {"kind": kind, **record, "out": str(place)}
    shutil.rmtree(staged, ignore_errors=True)
    try:
        staged.mkdir(parents=True)
        must(staged)
        needed = below(staged)
        try:
            why = add(staged, extras, signals)
            write_head(staged, head, record)
        except OSError as error:
            why = reason(error)
            remove(below(staged) - needed)
            write_head(staged, head, record)
    except BaseException:
        shutil.rmtree(staged, ignore_errors=True)
        raise
    return why


def add(staged: Path, extras: Sequence[Fill], signals: list[int]) -> str:
    """Let each extra write its files; why not all did, or an empty text. The first that finds no room leaves nothing,
    and none follows; those before it stay."""
    for extra in extras:
        if signals:
            return "interrupted"
        before = below(staged)
        try:
            extra(staged)
        except OSError as error:
            remove(below(staged) - before)
            return reason(error)
    return ""


def remove(paths: set[Path]) -> None:
    """Remove files."""
    for path in paths:
        path.unlink()


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
        named = read(former).get("files")
        names = named if isinstance(named, dict) else KINDS[kind].files  # former versions named none
        for name in set(names) - set(read(staged / head.name)["files"]):
            if fits(name, kind) and (folder / name).is_file():
                (folder / name).unlink()
    forget(folder)
    for path in sorted(below(staged) - {staged / head.name}):
        target = folder / path.relative_to(staged)
        target.parent.mkdir(parents=True, exist_ok=True)
        path.replace(target)
    synced(folder)
    (staged / head.name).replace(head)
    synced(folder)
    former.unlink(missing_ok=True)
    shutil.rmtree(staged, ignore_errors=True)


def forget(folder: Path) -> None:
    """Remove the rows of a stream, of which there are results now."""
    for name in (ROWS, REQUEST):
        (folder / OWN / name).unlink(missing_ok=True)


def fits(name: str, kind: str) -> bool:
    """Whether a head may name this file as one of its kind's: never a path that leads elsewhere."""
    path = Path(name)
    return (len(path.parts) in (1, 2, 3) and ".." not in path.parts and not path.is_absolute()
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
    """Signals that ask for an end wait until the end of the outermost context, and do then what they would have done;
    meanwhile they are entries of a list."""
    within = bool(HELD)
    with interruptions() as caught:
        yield caught
    if caught and not within:
        signal.raise_signal(caught[0])
