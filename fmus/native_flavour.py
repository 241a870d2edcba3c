"""A model as C: the traced functions in a generic wrapper, for every platform, with no Python inside."""
from pathlib import Path
from types import ModuleType

import fmpy

from .description import Flavour
from .native_code import sources
from .native_compiler import library
from .trace import Trace

WRAPPER = Path(__file__).parent / "wrapper"
HEADERS = Path(fmpy.__file__).parent / "c-code"

FLAVOUR = Flavour({"canGetAndSetFMUstate": "true", "canSerializeFMUstate": "true",
                   "providesDirectionalDerivative": "true"}, ["all.c"])

# Folder in binaries/ -> (target, suffix). FMI 2.0 has no names for Arm; these are FMI 3.0's. fmpy and others look
# for linux64 and darwin64 on every processor, so an importer on Arm finds its own name only if it knows FMI 3.0's.
PLATFORMS = {
    "linux64": ("x86_64-linux-gnu.2.17", ".so"),
    "win64": ("x86_64-windows-gnu", ".dll"),
    "darwin64": ("x86_64-macos", ".dylib"),
}
ARM_PLATFORMS = {
    "aarch64-linux": ("aarch64-linux-gnu.2.17", ".so"),
    "aarch64-darwin": ("aarch64-macos", ".dylib"),
}


def files(model: ModuleType, trace: Trace) -> dict[str, bytes]:
    """What the FMU is made of: its C, all but guid.h."""
    code = sources(model, trace)
    code.update((path.name, path.read_bytes()) for path in WRAPPER.iterdir() if path.is_file())
    code.update((path.name, path.read_bytes()) for path in HEADERS.glob("fmi2*.h"))
    return {f"sources/{name}": content for name, content in code.items()}


def binaries(model: ModuleType, files: dict[str, bytes], guid: str) -> dict[str, bytes]:
    """The GUID, which cannot be known before the sources are, and the libraries it is compiled into."""
    header = f'#define FMU_GUID "{guid}"\n'.encode()
    code = {path.removeprefix("sources/"): content for path, content in files.items() if path.startswith("sources/")}
    code["guid.h"] = header
    made = {f"binaries/{folder}/{model.NAME}{suffix}": library(model.NAME + suffix, target, code)
            for folder, (target, suffix) in PLATFORMS.items()}
    return {"sources/guid.h": header, **made}
