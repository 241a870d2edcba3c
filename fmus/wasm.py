"""A native FMU as WebAssembly, compiled from the sources inside the FMU file.

    python -m fmus.wasm       a module for each FMU in fmus/dist/native, into fmus/dist/wasm
"""
import tempfile
import zipfile
from pathlib import Path

from .native_compiler import COMPILE, zig

WRAPPER = Path(__file__).parent / "wrapper" / "wasm"
DIST = Path(__file__).parent / "dist"

TARGET = ["-target", "wasm32-wasi", "-mexec-model=reactor"]  # for its C library; nothing of the system is used
LINK = ["-s", "-Wl,--export-dynamic", "-Wl,--export=malloc", "-Wl,--export=free"]


def module(fmu: Path) -> bytes:
    """The native FMU in the file `fmu` as a module without imports; docs/wasm.md has what it exports.

    Raises RuntimeError where the compiler is missing or fails.
    """
    with tempfile.TemporaryDirectory() as folder:
        with zipfile.ZipFile(fmu) as archive:
            for path in archive.namelist():
                if path.startswith("sources/"):
                    Path(folder, Path(path).name).write_bytes(archive.read(path))
        Path(folder, "module.c").write_bytes((WRAPPER / "module.c").read_bytes())
        zig(Path(folder), "cc", *TARGET, *COMPILE, *LINK, "-o", "module.wasm", "module.c", "-lm")
        return Path(folder, "module.wasm").read_bytes()


def main() -> None:
    (DIST / "wasm").mkdir(exist_ok=True)
    for fmu in sorted((DIST / "native").glob("*.fmu")):
        (DIST / "wasm" / f"{fmu.stem}.wasm").write_bytes(module(fmu))


if __name__ == "__main__":
    main()
