"""A model as C: the traced functions in a generic wrapper, for every platform, with no Python inside."""
from pathlib import Path
from types import ModuleType

from .description import Flavour
from .native_code import generated_sources
from .native_compiler import LINUX, compiler_version, library, universal
from .trace import Trace

WRAPPER = Path(__file__).parent / "wrapper"
HEADERS = Path(__file__).parent / "headers"

FLAVOUR = Flavour({"canGetAndSetFMUstate": "true", "canSerializeFMUstate": "true",
                   "providesDirectionalDerivative": "true"}, ["all.c"])

# Folder in binaries/ -> (target, suffix).
PLATFORMS = {
    "linux64": (LINUX, ".so"),
    "win64": ("x86_64-windows-gnu", ".dll"),
    "darwin64": ("x86_64-macos", ".dylib"),
}


def versions() -> dict[str, str]:
    """What decides on the FMU's bytes beside CasADi. Raises RuntimeError where the compiler is missing."""
    return {"ziglang": compiler_version()}


def files(model: ModuleType, trace: Trace) -> dict[str, bytes]:
    """What the FMU is made of: its C, all but guid.h. Raises RuntimeError where CasADi generates other C than known."""
    code = generated_sources(model, trace)
    code.update((path.name, path.read_bytes()) for path in WRAPPER.iterdir() if path.is_file())
    code.update((path.name, path.read_bytes()) for path in HEADERS.glob("*.h"))
    return {f"sources/{name}": content for name, content in code.items()}


def binaries(model: ModuleType, contents: dict[str, bytes], guid: str, arm: bool) -> dict[str, bytes]:
    """The GUID, which cannot be known before the sources are, and the libraries it is compiled into.

    With `arm`, darwin64 is for both processors, so every importer finds it. FMI 2.0 has no name for Arm Linux:
    its library goes where FMI 3.0 has it, aarch64-linux; importers that look into linux64 on every processor
    (fmpy 0.3 does) need it moved there. Raises RuntimeError where the compiler is missing or fails.
    """
    header = f'#define FMU_GUID "{guid}"\n'.encode()
    code = {path.removeprefix("sources/"): content for path, content in contents.items() if path.startswith("sources/")}
    code["guid.h"] = header
    made = {f"{folder}/{model.NAME}{suffix}": library(model.NAME + suffix, target, code)
            for folder, (target, suffix) in PLATFORMS.items()}
    if arm:
        mac, linux = f"{model.NAME}.dylib", f"{model.NAME}.so"
        made[f"darwin64/{mac}"] = universal(made[f"darwin64/{mac}"], library(mac, "aarch64-macos", code))
        made[f"aarch64-linux/{linux}"] = library(linux, "aarch64-linux-gnu.2.17", code)
    return {"sources/guid.h": header, **{f"binaries/{path}": content for path, content in made.items()}}
