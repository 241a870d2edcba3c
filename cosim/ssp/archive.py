"""SSP archives, unpacked safely into a temporary folder."""
import shutil
import tempfile
import weakref
from pathlib import Path

from ..errors import UsageError
from ..master.unpack import BadArchive, safe_extract


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
