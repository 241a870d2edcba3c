"""SSP archives: unpacked safely into a temporary folder, and written so that equal contents give equal bytes."""
import shutil
import tempfile
import weakref
import zipfile
from pathlib import Path

from ..errors import UsageError
from ..master.unpack import BadArchive, safe_extract
from ..master.whole_file import whole


class Folder:
    """A temporary folder that is removed when this object is closed or unused, and at the end of the program."""

    def __init__(self) -> None:
        self.path = Path(tempfile.mkdtemp(prefix="ahv_ssp_"))
        self.close = weakref.finalize(self, shutil.rmtree, self.path, ignore_errors=True)


def unpacked(path: Path) -> Folder:
    """The folder that `path` is unpacked to.

    Raises UsageError if it is no zip archive, or if its paths or sizes are not safe.
    """
    folder = Folder()
    try:
        safe_extract(path, folder.path)
    except BadArchive as error:
        folder.close()
        raise UsageError(f"{path} cannot be opened: {error}.") from None
    return folder


def write(path: Path, files: dict[str, bytes]) -> None:
    """Write `files`, name -> content, as a zip archive at `path`: sorted and without dates, so always the same bytes.

    Raises UsageError if `path` cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with whole(path) as partial, zipfile.ZipFile(partial, "w", zipfile.ZIP_DEFLATED) as archive:
            for name in sorted(files):
                entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
                entry.compress_type = zipfile.ZIP_DEFLATED
                entry.external_attr = 0o644 << 16
                archive.writestr(entry, files[name])
    except OSError as error:
        raise UsageError(f"--out {path} cannot be written: {error.strerror}.") from None
