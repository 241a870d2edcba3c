"""Shared libraries for every platform, made on this machine by ziglang's C compiler."""
import hashlib
import os
import struct
import subprocess
import sys
import tempfile
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from .pack import digest
from .places import written

CACHE = written() / ".cache"
ZIG_CACHE = written() / ".zig-cache"
WINDOWS = Path(__file__).parent / "wrapper" / "windows"
LINUX = "x86_64-linux-gnu.2.17"  # of 2012: any Linux in use has at least this C library

# The same floating point everywhere, and the same as Python's: no contraction, no fast mathematics.
# Not in pairs of two numbers either: packing them costs more than it saves in long straight code.
COMPILE = ["-std=c99", "-O2", "-ffp-contract=off", "-fno-math-errno", "-fno-slp-vectorize", "-fvisibility=hidden",
           "-fPIC", "-g0"]
LINK = ["-shared", "-s"]


def compiler_version() -> str:
    """The C compiler's version. Raises RuntimeError where it is not installed."""
    try:
        return version("ziglang")
    except PackageNotFoundError:
        raise ModuleNotFoundError("The native flavour needs a C compiler for all platforms: pip install ziglang",
                                  name="ziglang") from None


def cc(*arguments: str | Path, target: str = LINUX) -> str:
    """Run the C compiler with `arguments`; returns what it printed. Raises RuntimeError as `zig` does."""
    return zig(Path(), "cc", "-target", target, *map(str, arguments))


def zig(folder: Path, *arguments: str) -> str:
    """Run zig in `folder`, where all names are relative: no path of this machine gets into a library.

    Returns what it printed. Raises RuntimeError with what it said where it fails.
    """
    caches = {"ZIG_GLOBAL_CACHE_DIR": str(ZIG_CACHE), "ZIG_LOCAL_CACHE_DIR": str(ZIG_CACHE)}
    done = subprocess.run([sys.executable, "-m", "ziglang", *arguments], cwd=folder, env={**os.environ, **caches},
                          capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"zig {' '.join(arguments)} failed:\n{done.stderr}")
    return done.stdout


def make(name: str, target: str, folder: Path) -> None:
    """Compile all.c in `folder` to the library `name` for the platform `target`. Raises RuntimeError as `zig` does."""
    cc = ["cc", "-target", target]
    if "windows" not in target:
        zig(folder, *cc, *COMPILE, *LINK, "-o", name, "all.c", "-lm")
        return
    # Zig would first build MinGW's run-time library for a minute, of which nothing is needed.
    for file in WINDOWS.iterdir():
        (folder / file.name).write_bytes(file.read_bytes())
    zig(folder, "dlltool", "-m", "i386:x86-64", "-d", "ucrt.def", "-l", "ucrt.lib")
    zig(folder, *cc, *COMPILE, "-c", "all.c", "-o", "all.obj")
    zig(folder, *cc, *COMPILE, "-c", "runtime.c", "-o", "runtime.obj")
    zig(folder, *cc, *LINK, "-nostdlib", "-Wl,--no-entry", "-o", name, "all.obj", "runtime.obj", "ucrt.lib",
        "-rtlib=compiler-rt")
    (folder / name).write_bytes(dateless((folder / name).read_bytes()))


def dateless(dll: bytes) -> bytes:
    """`dll` without its date, which zig's linker has no option to leave out."""
    header = int.from_bytes(dll[0x3c:0x40], "little")
    return dll[:header + 8] + bytes(4) + dll[header + 12:]


def universal(*libraries: bytes) -> bytes:
    """One Mach-O file for several processors, of one library for each."""
    page = 1 << 14
    at, table, body = page, b"", b""
    for content in libraries:
        processor = content[7:3:-1] + content[11:7:-1]  # type and subtype, little-endian there and big-endian here
        table += processor + struct.pack(">III", at, len(content), 14)
        body += content + bytes(-len(content) % page)
        at = page + len(body)
    head = struct.pack(">II", 0xcafebabe, len(libraries)) + table
    return head + bytes(page - len(head)) + body


def libraries(wanted: list[tuple[str, str]], sources: dict[str, bytes]) -> list[bytes]:
    """`library` for each (name, target), compiled on all cores. Raises RuntimeError as `library` does."""
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(lambda each: library(each[0], each[1], sources), wanted))


def library(name: str, target: str, sources: dict[str, bytes]) -> bytes:
    """The shared library `name` for `target` made of all.c among `sources`; from the cache if it was made before.

    Raises RuntimeError where the compiler is missing or fails.
    """
    recipe = Path(__file__).read_bytes() + b"".join(path.read_bytes() for path in sorted(WINDOWS.iterdir()))
    key = repr((compiler_version(), name, target, recipe, digest(sources)))

    def made(folder: Path) -> bytes:
        for path, content in sources.items():
            Path(folder, path).write_bytes(content)
        make(name, target, folder)
        return Path(folder, name).read_bytes()
    return cached(key, made)


def cached(key: str, make: Callable[[Path], bytes]) -> bytes:
    """What `make` gives in an empty folder; from the cache if it was made before with the same `key`, which has to say
    all that it depends on. Raises what `make` raises."""
    kept = CACHE / hashlib.sha256(key.encode()).hexdigest()
    if not kept.exists():
        CACHE.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory() as folder:
            content = make(Path(folder))
        partial = kept.with_name(f"{kept.name}.{os.getpid()}")
        partial.write_bytes(content)
        partial.replace(kept)
    return kept.read_bytes()
