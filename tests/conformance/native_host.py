"""Builds the C hosts in `native/` against the native FMUs, for the tests that fly them without Python."""
import shutil
import subprocess
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import fmpy

from fmus.native_compiler import cc
from fmus.native_flavour import HEADERS

HOSTS = Path(__file__).parent / "native"
WARNINGS = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror"]
STRICT = [*WARNINGS, "-O2", "-ffp-contract=off"]
SANITIZE = ["-g", "-O1", "-fno-sanitize-recover=all"]
MEASURED = ["V", "h", "gamma", "theta", "Q"]
SCALED = ["scale_thrust", "scale_lift", "scale_drag", "scale_moment", "scale_forces"]


@dataclass
class Unpacked:
    """An FMU in a folder."""
    folder: Path
    name: str

    @classmethod
    def of(cls, fmu: Path, folder: Path) -> "Unpacked":
        with zipfile.ZipFile(fmu) as archive:
            archive.extractall(folder / fmu.stem)
        return cls(folder / fmu.stem, fmu.stem)

    @property
    def description(self):
        return fmpy.read_model_description(str(self.folder))

    @property
    def guid(self) -> str:
        return self.description.guid

    def references(self, names) -> list[int]:
        known = {v.name: v.valueReference for v in self.description.modelVariables}
        return [known[name] for name in names]

    def library(self, platform: str = "linux64", suffix: str = ".so") -> Path:
        return self.folder / "binaries" / platform / (self.name + suffix)

    def compiled(self, path: Path, *flags: str, compiler: Callable = cc) -> Path:
        """The library made again from the FMU's own sources."""
        compiler(*STRICT, "-fPIC", "-shared", *flags, "-o", path, self.folder / "sources" / "all.c", "-lm")
        return path


def run(*command, **kwargs) -> str:
    """stdout of a command that must succeed; AssertionError with what it said if it does not."""
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, **kwargs)
    assert done.returncode == 0, f"{command[0]} ended with {done.returncode}:\n{done.stdout}\n{done.stderr}"
    return done.stdout


def initialiser(references: list[int]) -> str:
    return "{" + ", ".join(map(str, references)) + "}"


def wiring(scenario: Unpacked, controller: Unpacked, plant: Unpacked) -> str:
    """wiring.h of loop.c."""
    commands, actions = ["V_command", "h_command"], ["fuel_ratio", "elevator"]
    lists = {"COMMANDS": (scenario, commands), "COMMANDED": (controller, commands),
             "SCALES": (scenario, SCALED), "SCALED": (plant, SCALED),
             "MEASURES": (plant, MEASURED), "MEASURED": (controller, MEASURED),
             "ACTIONS": (controller, actions), "ACTUATED": (plant, actions)}
    members = {"SCENARIO": scenario, "CONTROLLER": controller, "PLANT": plant}
    lines = [f'#define {member}_GUID "{fmu.guid}"' for member, fmu in members.items()]
    lines += [f"#define {name} {initialiser(fmu.references(names))}" for name, (fmu, names) in lists.items()]
    return "\n".join(lines) + "\n"


def sanitizer() -> Callable:
    """A compiler with sanitizers: address and undefined where there is gcc or clang; zig has the second only."""
    program = shutil.which("gcc") or shutil.which("clang")
    if program:
        return partial(run, program, *SANITIZE, "-fsanitize=address,undefined")
    return partial(cc, *SANITIZE, "-fsanitize=undefined", "-fno-sanitize-trap=undefined")


def host(name: str, folder: Path, *flags: str, compiler: Callable = cc) -> Path:
    """Compile `native/name`.c; headers it needs besides FMI's are looked for in `folder`."""
    path = folder / name
    compiler(*STRICT, *flags, f"-I{HEADERS}", f"-I{folder}", "-o", path, HOSTS / f"{name}.c", "-lm", "-ldl")
    return path
