"""Runs masters that others wrote where libraries which they name are not part of the system."""
import ctypes
import os
import sys
from functools import cache
from pathlib import Path

from fmus.native_compiler import CACHE, cc

ATOMIC = "libatomic.so.1"


@cache
def environment() -> dict[str, str]:
    """The environment variables for a process that imports ecospy or libcosimpy.

    ecospy needs libtbb.so.12, which PyPI's tbb puts into the `lib` folder of the virtual environment. libcosimpy names
    libatomic.so.1 but calls nothing in it, so an empty library of this name does where the system has none.
    """
    folders = [Path(sys.prefix) / "lib"]
    try:
        ctypes.CDLL(ATOMIC)
    except OSError:
        folders.append(empty_library(ATOMIC).parent)
    given = os.environ.get("LD_LIBRARY_PATH")
    return {**os.environ, "LD_LIBRARY_PATH": os.pathsep.join([*map(str, folders), *([given] if given else [])])}


def empty_library(name: str) -> Path:
    """A shared library without content, compiled once."""
    path = CACHE / "empty" / name
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        partial = path.with_name(f"{os.getpid()}.so")
        partial.with_suffix(".c").touch()
        cc("-shared", f"-Wl,-soname,{name}", "-o", partial, partial.with_suffix(".c"))
        partial.with_suffix(".c").unlink()
        partial.replace(path)
    return path
