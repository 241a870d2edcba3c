"""Runs masters that others wrote where what they name is not part of the system."""
import ctypes
import os
import shutil
import sys
from functools import cache
from pathlib import Path

from fmus.native_compiler import CACHE, cc

ATOMIC = "libatomic.so.1"
STANDINS = CACHE / "peers"
UNZIP = f"""#!/bin/sh
# unzip -o FILE -d FOLDER
exec "{sys.executable}" -m zipfile -e "$2" "$4"
"""


@cache
def environment() -> dict[str, str]:
    """The environment variables for a process that imports ecospy or libcosimpy.

    ecospy needs libtbb.so.12, which PyPI's tbb puts into the `lib` folder of the virtual environment, and runs `unzip`,
    for which Python stands in where there is none. libcosimpy names libatomic.so.1 but calls nothing in it, so an
    empty library of this name does where the system has none.
    """
    STANDINS.mkdir(parents=True, exist_ok=True)
    if not shutil.which("unzip"):
        partial = STANDINS / f"{os.getpid()}.sh"
        partial.write_text(UNZIP)
        partial.chmod(0o755)
        partial.replace(STANDINS / "unzip")
    try:
        ctypes.CDLL(ATOMIC)
    except OSError:
        empty_library(STANDINS / ATOMIC)
    return {**os.environ, "PATH": before("PATH", STANDINS),
            "LD_LIBRARY_PATH": before("LD_LIBRARY_PATH", Path(sys.prefix) / "lib", STANDINS)}


def before(variable: str, *folders: Path) -> str:
    """`folders`, and what the environment variable lists already."""
    given = os.environ.get(variable)
    return os.pathsep.join([*map(str, folders), *([given] if given else [])])


def empty_library(path: Path) -> None:
    """Compile a shared library without content, unless it was before."""
    if path.exists():
        return
    partial = path.with_name(f"{os.getpid()}.so")
    partial.with_suffix(".c").touch()
    cc("-shared", f"-Wl,-soname,{path.name}", "-o", partial, partial.with_suffix(".c"))
    partial.with_suffix(".c").unlink()
    partial.replace(path)
