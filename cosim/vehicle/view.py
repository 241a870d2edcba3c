"""Several runs in one page: what `ahv view` does."""
from collections.abc import Sequence
from pathlib import Path

from ..errors import UsageError
from ..master.whole_file import whole
from ..pages.flown import Flown
from ..pages.folder import named, results
from ..pages.write import page
from .look import PANELS, looked_at

MOST = 24


def view(folders: Sequence[Path], out: Path, command: str = "") -> Path:
    """Write a page with the flights of all `folders` over each other to the file `out`, which is given back.

    Raises UsageError for folders that have no flights, RunError where the file cannot be written.
    """
    found = {path: flown for folder in folders for path, flown in results(folder).items()}
    if len(found) > MOST:
        raise UsageError(f"{len(found)} flights are too many for one page: it shows {MOST} at most.")
    flown = [looked_at(name, flight, record) if record.get("kind") == "run" else Flown(name, flight, record)
             for name, (flight, record) in zip(named(list(found)), found.values())]
    ours = any(record.get("kind") == "run" for _, record in found.values())
    out.parent.mkdir(parents=True, exist_ok=True)
    text = page(" and ".join(one.name for one in flown) if len(flown) < 4 else f"{len(flown)} flights", flown,
                PANELS if ours else (), command)
    with whole(out) as partial:
        partial.write_text(text, encoding="utf-8")
    return out
