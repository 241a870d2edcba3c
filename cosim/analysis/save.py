"""What a linearisation found, in a file: JSON, or matrices for MATLAB, Octave and scipy."""
import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import UsageError
from ..master.whole_file import whole

LONGEST_NAME = 31  # of a field of a .mat file


@contextmanager
def save(path: Path | None) -> Iterator[Callable[[dict[str, Any]], None]]:
    """Gives a function that writes what was found to `path`, .mat or .json; without a path it writes nothing.

    Raises UsageError, before anything is computed, for a file of another kind or in no folder; RunError, when it is
    written, for a disk that is full.
    """
    if path and path.suffix not in (".mat", ".json"):
        raise UsageError(f"--out {path} is not allowed: the file's name must end in .mat or .json.")
    if path and (path.is_dir() or not path.absolute().parent.is_dir()):
        raise UsageError(f"--out {path} is not a file in a folder that exists.")

    def keep(found: dict[str, Any]) -> None:
        if path is None:
            return
        with whole(path) as partial:
            if path.suffix == ".json":
                partial.write_text(json.dumps(found, indent=1) + "\n")
            else:
                from scipy.io import savemat  # slow to import

                savemat(str(partial), fields(found), appendmat=False, long_field_names=True, oned_as="column")

    yield keep


def fields(found: dict[str, Any]) -> dict[str, Any]:
    """The same as structures of arrays: roots as complex vectors, names as cells, what is None left out."""
    result: dict[str, Any] = {}
    for key, value in found.items():
        name = "".join(c if c.isascii() and c.isalnum() else "_" for c in key)
        name = unused((name if name[:1].isalpha() else f"x{name}")[:2 * LONGEST_NAME], result)
        if isinstance(value, dict):
            result[name] = fields(value)
        elif isinstance(value, list) and all(isinstance(one, dict) for one in value):
            result[name] = np.array([complex(one["real"], one["imag"]) for one in value])
        elif isinstance(value, list) and all(isinstance(one, str) for one in value):
            result[name] = np.array(value, dtype=object)
        elif value is not None:
            result[name] = np.array(value) if isinstance(value, list) else value
    return result


def unused(name: str, taken: dict[str, Any]) -> str:
    """`name`, or with a number at its end if something of that name is taken, such as b.c after b_c."""
    found, n = name, 1
    while found in taken:
        n += 1
        found = f"{name[:2 * LONGEST_NAME - len(str(n)) - 1]}_{n}"
    return found
