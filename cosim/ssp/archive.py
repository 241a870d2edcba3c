"""SSP archives, unpacked safely into a temporary folder."""
from pathlib import Path

from ..errors import UsageError
from ..master.unpack import BadArchive, safe_extract
from ..temporary import Folder


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
