"""SSP archives: unpacked safely into a temporary folder, and written so that equal contents give equal bytes."""
import shutil
import tempfile
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ..errors import UsageError
from ..master.unpack import BadArchive, safe_extract
from ..master.whole_file import whole


@contextmanager
def unpacked(path: Path) -> Iterator[Path]:
    """The folder that `path` is unpacked to, for as long as the context lasts.

    Raises UsageError if it is no zip archive, or if its paths or sizes are not safe.
    """
    folder = Path(tempfile.mkdtemp(prefix="ahv_ssp_"))
    try:
        try:
            safe_extract(path, folder)
        except BadArchive as error:
            raise UsageError(f"{path} cannot be opened: {error}.") from None
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


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
