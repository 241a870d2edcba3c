"""A model as C: the traced functions in a generic wrapper, for every platform, with no Python inside."""
from pathlib import Path
from types import ModuleType

from .description import Flavour
from .native_code import generated_sources
from .native_compiler import LINUX, compiler_version, libraries, universal
from .trace import Trace

WRAPPER = Path(__file__).parent / "wrapper"
HEADERS = Path(__file__).parent / "headers"

FLAVOUR = Flavour({"canGetAndSetFMUstate": "true", "canSerializeFMUstate": "true",
                   "providesDirectionalDerivative": "true"}, ["all.c"], ("2", "3"), exchanges=True)

# Platform, as FMI 3.0 names its folder -> (target, suffix, the folder's name in FMI 2.0). FMI 2.0 has no names for Arm:
# its darwin64 is for both processors, so every importer finds it; importers that look into linux64 on every processor
# (fmpy 0.3 does) need the library of aarch64-linux moved there.
PLATFORMS = {
    "x86_64-linux": (LINUX, ".so", "linux64"),
    "aarch64-linux": ("aarch64-linux-gnu.2.17", ".so", "aarch64-linux"),
    "x86_64-windows": ("x86_64-windows-gnu", ".dll", "win64"),
    "x86_64-darwin": ("x86_64-macos", ".dylib", "darwin64"),
    "aarch64-darwin": ("aarch64-macos", ".dylib", "darwin64"),
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


def binaries(model: ModuleType, contents: dict[str, bytes], token: str, fmi: str) -> dict[str, bytes]:
    """guid.h with the token, which cannot be known before the sources are, and the libraries that they are compiled
    into, where FMI `fmi` (2 or 3) has them. Raises RuntimeError where the compiler is missing or fails."""
    header = f'#define FMU_GUID "{token}"\n'.encode()
    code = {path.removeprefix("sources/"): content for path, content in contents.items() if path.startswith("sources/")}
    code["guid.h"] = header
    made: dict[str, list[bytes]] = {}
    compiled = libraries([(model.NAME + suffix, target) for target, suffix, _ in PLATFORMS.values()], code)
    for (platform, (_, suffix, in_fmi2)), content in zip(PLATFORMS.items(), compiled):
        made.setdefault(f"binaries/{in_fmi2 if fmi == '2' else platform}/{model.NAME}{suffix}", []).append(content)
    return {"sources/guid.h": header,
            **{place: universal(*parts) if len(parts) > 1 else parts[0] for place, parts in made.items()}}
