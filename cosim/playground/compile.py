"""Compiles our native FMUs and the master's loop to one WebAssembly module, from the sources inside the FMU files."""
import os
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from ..master import compile_loop
from ..vehicle.closed_loop import fmu_path
from ..vehicle.registry import MODELS
from .data import FLAVOUR

HERE = Path(__file__).parent
COMPILE = ["-O3", "-fno-strict-aliasing", "-DWITHOUT_FMI3"]
Files = Mapping[str, bytes]


def module() -> bytes:
    """The module; it imports nothing, and the names of a member's functions begin with NAME_.

    Raises UsageError for FMUs that are not built, RuntimeError where the compiler is missing or fails.
    """
    from fmus import native_compiler
    from fmus.native_compiler import cached, compiler_version
    from fmus.pack import digest
    from fmus.wasm import EXPORTS, STACK, TARGET, WRAPPER, contents

    common = {path.name: path.read_bytes() for path in [*WRAPPER.iterdir(), *HERE.glob("*.c")]}
    common["loop.c"] = compile_loop.source()
    members = {name: {Path(file).name: content for file, content in contents(fmu_path(FLAVOUR, name)).items()
                      if file.startswith("sources/")} for name in MODELS}
    recipe = [Path(__file__).read_text(encoding="utf-8"), native_compiler.COMPILE, TARGET, STACK, EXPORTS]
    key = repr((compiler_version(), recipe, digest(common), [(name, digest(files)) for name, files in members.items()]))
    return cached(key, lambda folder: linked(folder, members, common))


def linked(folder: Path, members: Mapping[str, Files], common: Files) -> bytes:
    """The module of the FMUs whose sources are `members`, made in an empty folder. Raises RuntimeError as `module`."""
    from fmus import native_compiler
    from fmus.wasm import EXPORTS, STACK, TARGET

    def compiled(source: str, out: str, *flags: str) -> str:
        native_compiler.zig(folder, "cc", *TARGET, *native_compiler.COMPILE, *COMPILE, *flags, "-c", source, "-o", out)
        return out

    def member(name: str) -> str:
        (folder / name).mkdir()
        for file, content in {**common, **members[name]}.items():
            (folder / name / file).write_bytes(content)
        return compiled(f"{name}/member.c", f"{name}.o", f"-DFMI2_FUNCTION_PREFIX={name}_")

    for file in ("loop.c", "columns.c"):
        (folder / file).write_bytes(common[file])
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        objects = [*pool.map(member, members), *(compiled(f"{name}.c", f"{name}.o") for name in ("loop", "columns"))]
    native_compiler.zig(folder, "cc", *TARGET, "-O3", "-s", *STACK, *EXPORTS, "-o", "module.wasm", *objects, "-lm")
    return (folder / "module.wasm").read_bytes()
