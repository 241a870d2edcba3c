"""The controller FMUs' own C on an emulated Cortex-M7, fed with Case 1 as our master flew it.

    .venv/bin/python benchmarks/board.py [--json]      writes the table in docs/board.md

It needs qemu-system-arm and a C library for the processor: on Debian, apt-get install qemu-system-arm
picolibc-arm-none-eabi. The emulator counts no cycles of a real processor, so there are no times here.
"""
import json
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile
from dataclasses import asdict, dataclass
from pathlib import Path

import fmpy
import numpy as np

from cosim.master.fly import fly
from cosim.vehicle.closed_loop import closed_loop
from cosim.vehicle.registry import LAWS
from cosim.vehicle.scenarios import BUILT_IN
from fmus.native_compiler import COMPILE, cc
from fmus.places import found

DOCS = Path(__file__).parent.parent / "docs"
BOARD, PAGE = DOCS / "examples" / "board", DOCS / "board.md"
PICOLIBC = Path("/usr/lib/picolibc/arm-none-eabi")
LIBRARIES = PICOLIBC / "lib" / "release" / "thumb" / "v7e-m+dp" / "hard"
EMULATOR = ["qemu-system-arm", "-M", "mps2-an500", "-display", "none", "-monitor", "none", "-serial", "none",
            "-chardev", "stdio,id=out", "-semihosting-config", "enable=on,target=native,chardev=out", "-kernel"]

TARGET = "thumb-freestanding-eabihf"
PROCESSOR = ["-mcpu=cortex_m7+fp_armv8d16"]  # with its floating-point unit for double precision
SMALL = ["-ffunction-sections", "-fdata-sections", "-fno-unwind-tables", "-fno-asynchronous-unwind-tables"]
FLAGS = [*(flag for flag in COMPILE if flag != "-fPIC"), "-Wall", "-Wextra", *PROCESSOR, *SMALL,
         f"-isystem{PICOLIBC}/include"]
ONE_DOOR = "-DWITHOUT_FMI3"  # that of FMI 2.0 takes its memory from the arena
LINK = ["-nostdlib", "-rtlib=compiler-rt", "-s", "-Wl,--gc-sections", "-Wl,--print-map"]

STEP, ARENA = 0.01, 16384  # s, bytes
MEASURED, COMMANDED = ("V", "h", "gamma", "theta", "Q"), ("V_command", "h_command")
RAM = 0x20000000


@dataclass(frozen=True)
class Board:
    """What an image takes and how it flew; sizes in bytes."""
    flash: int
    flash_fmu: int         # of it, the FMU's own code and tables
    flash_library: int     # of it, the C library: exp, sin, cos, printf, ...
    ram: int               # without arena and stack
    arena: int             # what the FMU took of it
    stack: int
    rows: int
    difference: float      # from the host's outputs, relative to nominal, the largest


def missing() -> str:
    """What this machine lacks, in one sentence; "" if nothing."""
    lacks = [package for package, there in (("qemu-system-arm", shutil.which("qemu-system-arm")),
                                            ("picolibc-arm-none-eabi", LIBRARIES.exists())) if not there]
    return f"no {' and no '.join(lacks)}: apt-get install {' '.join(lacks)}" if lacks else ""


def flight(law: str, outputs: list[str]) -> np.ndarray:
    """Case 1 as the controller `law` saw it and answered, a row a tick: shape (ticks + 1, inputs + outputs)."""
    scenario = BUILT_IN["case1"]
    flown = fly(closed_loop(scenario, law, flavour="native").system, STEP, scenario.stop)
    assert flown.finished, flown.message
    after = np.column_stack([flown[f"plant.{name}"] for name in MEASURED])
    seen = np.vstack([after[:1], after[:-1]])  # the plant steps last
    return np.column_stack([seen, *(flown[f"scenario.{name}"] for name in COMMANDED),
                            *(flown[f"controller.{name}"] for name in outputs)])


def wiring(variables: list, outputs: list[str]) -> str:
    """wiring.h: value references by name, and the outputs' nominal values."""
    known = {v.name: v for v in variables}
    lists = {"INPUTS": [known[name].valueReference for name in (*MEASURED, *COMMANDED)],
             "OUTPUTS": [known[name].valueReference for name in outputs],
             "NOMINALS": [known[name].nominal or 1.0 for name in outputs]}
    return "\n".join([f"#define STEP {STEP}", f"#define ARENA_BYTES {ARENA}",
                      *(f"#define N_{name} {len(values)}" for name, values in lists.items()),
                      *(f"#define {name} {{{', '.join(map(str, values))}}}" for name, values in lists.items()), ""])


def sizes(link_map: str) -> tuple[dict[str, int], dict[str, int]]:
    """Bytes by section, and bytes of code and constants by the file that they come from."""
    number, sections, files = r"[0-9a-f]+", {}, {}
    for size, name in re.findall(rf"^ *{number} +{number} +({number}) +\d+ (\.\w+)$", link_map, re.MULTILINE):
        sections[name] = int(size, 16)
    of_file = rf"^ *({number}) +{number} +({number}) +\d+ +(?:.*/)?([^/ (]+)(?:\(.*\))?:\("
    for at, size, file in re.findall(of_file, link_map, re.MULTILINE):
        if int(at, 16) < RAM:
            files[file] = files.get(file, 0) + int(size, 16)
    return sections, files


def board(law: str, folder: Path) -> Board:
    """Build the image of `law` in `folder` and fly it. Raises RuntimeError where the compiler fails."""
    with zipfile.ZipFile(found("native", LAWS[law].fmu)) as archive:
        archive.extractall(folder)
    variables = fmpy.read_model_description(str(folder)).modelVariables
    outputs = [v.name for v in variables if v.causality == "output"]
    (folder / "wiring.h").write_text(wiring(variables, outputs))
    flight(law, outputs).astype("<f8").tofile(folder / "flight.bin")
    sources = [folder / "sources" / "all.c", BOARD / "main.c", BOARD / "replay.c"]
    archives = [LIBRARIES / f"lib{name}.a" for name in ("c", "m", "semihost")]
    printed = cc(*FLAGS, ONE_DOOR, *LINK, f"-I{folder}", f"-I{folder / 'sources'}", "-o", folder / "board.elf",
                 *sources, LIBRARIES / "crt0-semihost.o", "-Wl,--start-group", *archives, "-Wl,--end-group",
                 "-T", BOARD / "board.ld", target=TARGET)
    done = subprocess.run([*EMULATOR, folder / "board.elf"], cwd=folder, stdin=subprocess.DEVNULL,
                          capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, f"the board ended with {done.returncode}: {done.stdout}{done.stderr}"
    rows, difference, arena, stack = done.stdout.split()
    sections, files = sizes(printed)
    starts = sections[".data"] + sections[".tdata"]  # kept in flash, copied to RAM
    library = sum(files.get(name, 0) for name in ("libc.a", "libm.a", "libcompiler_rt.a"))
    return Board(sections[".text"] + starts, files["all.o"], library, starts + sections[".bss"] - ARENA, int(arena),
                 int(stack), int(rows), float(difference))


def measure() -> dict[str, Board]:
    """Every law on the board."""
    boards = {}
    for law in LAWS:
        with tempfile.TemporaryDirectory() as folder:
            boards[law] = board(law, Path(folder))
    return boards


HEAD = """| law | flash | of it the FMU | of it the C library | RAM | arena | stack | largest difference |
|---|---|---|---|---|---|---|---|
"""


def table(boards: dict[str, Board]) -> str:
    """The table of docs/board.md."""
    return HEAD + "".join(
        f"| {law} | {b.flash:,} | {b.flash_fmu:,} | {b.flash_library:,} | {b.ram:,} | {b.arena:,} | {b.stack:,} "
        f"| {b.difference:.0e} |\n" for law, b in boards.items())


def main() -> None:
    if lacks := missing():
        raise SystemExit(lacks)
    boards = measure()
    if "--json" in sys.argv:
        print(json.dumps({law: asdict(b) for law, b in boards.items()}))
        return
    text = PAGE.read_text()
    PAGE.write_text(re.sub(re.escape(HEAD) + r"(\|.*\n)*", lambda _: table(boards), text))
    print(table(boards), end="")


if __name__ == "__main__":
    main()
