"""A model as C: the traced functions in a generic wrapper, compiled for every platform, no Python inside."""
import hashlib
import os
import subprocess
import sys
import tempfile
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from types import ModuleType

import fmpy

from .archive import digest
from .description import Flavour
from .native_code import sources
from .trace import Trace

WRAPPER = Path(__file__).parent / "wrapper"
HEADERS = Path(fmpy.__file__).parent / "c-code"
CACHE = Path(__file__).parent / "dist" / ".cache"
ZIG_CACHE = Path(__file__).parent / "dist" / ".zig-cache"

CAPABILITIES = {
    "canGetAndSetFMUstate": "true", "canSerializeFMUstate": "true", "providesDirectionalDerivative": "true",
}
FLAVOUR = Flavour(CAPABILITIES, ["all.c"])

# The same floating point everywhere, and the same as Python's: no contraction, no fast mathematics.
FLAGS = ["-std=c99", "-O2", "-ffp-contract=off", "-fvisibility=hidden", "-fPIC", "-shared", "-g0", "-s"]
# Folder in binaries/ -> target and suffix. FMI 2.0 names no folder for Arm: these are FMI 3.0's, which importers use.
TARGETS = {
    "linux64": ("x86_64-linux-gnu.2.17", ".so"),
    "win64": ("x86_64-windows-gnu", ".dll"),
    "darwin64": ("x86_64-macos", ".dylib"),
}
ARM_TARGETS = {
    "aarch64-linux": ("aarch64-linux-gnu.2.17", ".so"),
    "aarch64-darwin": ("aarch64-macos", ".dylib"),
}


def compiler() -> str:
    try:
        return version("ziglang")
    except PackageNotFoundError:
        raise RuntimeError("The native flavour needs a C compiler for all platforms: pip install ziglang") from None


def compile_library(name: str, target: str, files: dict[str, bytes]) -> bytes:
    """The shared library `name` for `target` made of all.c among `files`; from the cache if it was made before."""
    key = repr((compiler(), name, target, FLAGS, digest(files)))
    kept = CACHE / hashlib.sha256(key.encode()).hexdigest()
    if not kept.exists():
        CACHE.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory() as folder:
            for path, content in files.items():
                Path(folder, path).write_bytes(content)
            command = [sys.executable, "-m", "ziglang", "cc", "-target", target, *FLAGS, "-o", name, "all.c", "-lm"]
            caches = {"ZIG_GLOBAL_CACHE_DIR": str(ZIG_CACHE), "ZIG_LOCAL_CACHE_DIR": str(ZIG_CACHE)}
            done = subprocess.run(command, cwd=folder, env={**os.environ, **caches}, capture_output=True, text=True)
            if done.returncode:
                raise RuntimeError(f"compiling {name} for {target} failed:\n{done.stderr}")
            partial = kept.with_suffix(f".{os.getpid()}")
            partial.write_bytes(Path(folder, name).read_bytes())
            partial.replace(kept)
    return kept.read_bytes()


def files(model: ModuleType, trace: Trace) -> dict[str, bytes]:
    """The FMU's C, all but guid.h."""
    code = sources(model, trace)
    code.update((path.name, path.read_bytes()) for path in WRAPPER.iterdir())
    code.update((path.name, path.read_bytes()) for path in HEADERS.glob("fmi2*.h"))
    return {f"sources/{name}": content for name, content in code.items()}


def binaries(model: ModuleType, files: dict[str, bytes], guid: str) -> dict[str, bytes]:
    """What `guid` is compiled into."""
    header = f'#define FMU_GUID "{guid}"\n'.encode()
    code = {path.removeprefix("sources/"): content for path, content in files.items() if path.startswith("sources/")}
    code["guid.h"] = header
    made = {f"binaries/{folder}/{model.NAME}{suffix}": compile_library(model.NAME + suffix, target, code)
            for folder, (target, suffix) in TARGETS.items()}
    return {"sources/guid.h": header, **made}
