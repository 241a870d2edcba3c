"""Compiles loop.c with ziglang. `python -m cosim.master.compile_loop` does it for all PLATFORMS, which a wheel carries.

A library's name has a hash of all that decides on its content: one that does not fit this code is never loaded.
"""
import hashlib
import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import fmpy
from platformdirs import user_cache_path

from ..temporary import Folder
from . import program
from .whole_file import replacing

SOURCE = Path(__file__).with_name("loop.c")
BUILT = Path(__file__).with_name("built")  # of a checkout and of a wheel
CHECKOUT = Path(__file__).parents[2] / "requirements" / "flying.txt"  # some wheels leave a pyproject.toml beside us
PLATFORMS = {  # as FMI 3.0 calls them -> zig's target, the ending of a library
    "x86_64-linux": ("x86_64-linux-gnu.2.17", ".so"), "aarch64-linux": ("aarch64-linux-gnu.2.17", ".so"),
    "x86_64-windows": ("x86_64-windows-gnu", ".dll"),
    "x86_64-darwin": ("x86_64-macos", ".dylib"), "aarch64-darwin": ("aarch64-macos", ".dylib")}
# The same floating point as Python's. Nothing of C's library is used, so one file serves every system of a platform.
FLAGS = ["-std=c99", "-O3", "-ffp-contract=off", "-fno-strict-aliasing", "-fno-builtin", "-fvisibility=hidden", "-fPIC",
         "-g0", "-shared", "-s", "-nostdlib", "-Wl,--no-entry"]


def source() -> bytes:
    """loop.c behind the constants of `program`."""
    constants = {n: x for n, x in vars(program).items() if n.isupper() and isinstance(x, int | float)}
    return "".join(f"#define {n} {x!r}\n" for n, x in constants.items()).encode() + SOURCE.read_bytes()


def name(platform: str) -> str:
    """The name of the library for one of PLATFORMS."""
    key = repr((PLATFORMS[platform], FLAGS)).encode() + source()
    return f"loop-{hashlib.sha256(key).hexdigest()[:16]}-{platform}{PLATFORMS[platform][1]}"


def folders() -> list[Path]:
    """Where libraries are looked for. New ones go into the last: the user's cache where this is no checkout."""
    return [BUILT] if CHECKOUT.is_file() else [BUILT, user_cache_path("ahv", appauthor=False)]


def compile_to(path: Path, platform: str) -> None:
    """Compile the library for one of PLATFORMS. Raises OSError if it cannot be written,
    subprocess.CalledProcessError if zig fails."""
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f".{path.name}.{os.getpid()}")  # other processes may do the same
    with Folder() as temporary:
        folder = temporary.path
        (folder / "loop.c").write_bytes(source())
        caches = {"ZIG_GLOBAL_CACHE_DIR": str(folder), "ZIG_LOCAL_CACHE_DIR": str(folder)}
        zig = [sys.executable, "-m", "ziglang", "cc", "-target", PLATFORMS[platform][0]]
        subprocess.run([*zig, *FLAGS, "loop.c", "-o", "library"], cwd=folder, env={**os.environ, **caches}, check=True,
                       capture_output=True)
        with replacing(path, partial):
            partial.write_bytes(dateless((folder / "library").read_bytes()))


def dateless(content: bytes) -> bytes:
    """A library without the date that one for Windows has."""
    if not content.startswith(b"MZ"):
        return content
    header = int.from_bytes(content[0x3c:0x40], "little")
    return content[:header + 8] + bytes(4) + content[header + 12:]


def library() -> Path | None:
    """The library for this machine, compiled now if it is nowhere; None if that is not possible."""
    if fmpy.platform_tuple not in PLATFORMS:
        return None
    file = name(fmpy.platform_tuple)
    for folder in folders():
        if (path := folder / file).is_file():
            return path
    if find_spec("ziglang") is None:
        return None
    compile_to(path, fmpy.platform_tuple)
    return path


def everywhere() -> list[Path]:
    """The libraries for all PLATFORMS, in the folder that wheels carry; others are removed. Raises what `compile_to`
    raises."""
    wanted = {platform: BUILT / name(platform) for platform in PLATFORMS}
    for old in {*BUILT.glob("loop-*")} - {*wanted.values()}:
        old.unlink()
    for platform, path in wanted.items():
        if not path.is_file():
            compile_to(path, platform)
    return [*wanted.values()]


if __name__ == "__main__":
    print(*everywhere(), sep="\n")
