"""The sources of several FMUs in one static program, whose numbers are those of the shared libraries."""
import os
import shutil

import pytest
from native_host import HEADERS, HOSTS, MEASURED, STRICT, WARNINGS, Unpacked, initialiser, run
from native_loop import Loaded

from fmus.native_compiler import LINUX, cc

STEPS, STEP = 200, 0.01
ACTIONS = ["fuel_ratio", "elevator"]


def wiring(a: Unpacked, b: Unpacked, c: Unpacked) -> str:
    """wiring.h of static.c; the plant's token is the same in both versions of FMI."""
    lists = {"A_MEASURED": a.references(MEASURED), "A_ACTIONS": a.references(ACTIONS),
             "B_MEASURED": b.references(MEASURED), "B_ACTIONS": b.references(ACTIONS),
             "C_MEASURES": c.references(MEASURED), "C_ACTUATED": c.references(ACTIONS)}
    return "\n".join([*(f'#define {name}_GUID "{fmu.guid}"' for name, fmu in zip("ABC", (a, b, c))),
                      *(f"#define {name} {initialiser(of)}" for name, of in lists.items()),
                      f"#define STEPS {STEPS}", ""])


def flown(native_fmus) -> list[list[float]]:
    """The same flight by the shared libraries, through FMI 2.0."""
    rows = []
    with Loaded(native_fmus["AhvController"]) as a, Loaded(native_fmus["AhvBackstepping"]) as b, \
            Loaded(native_fmus["AhvPlant"]) as c:
        for member in (a, b, c):
            member.begin()
            member.shut()
        for k in range(STEPS):
            x = c.get(*MEASURED)
            for law in (a, b):
                law.set(**dict(zip(MEASURED, x)))
                law.slave.doStep(k * STEP, STEP)
            c.set(**dict(zip(ACTIONS, a.get(*ACTIONS))))
            c.slave.doStep(k * STEP, STEP)
            rows.append([*a.get(*ACTIONS), *b.get(*ACTIONS), *x[:2]])
    return rows


@pytest.fixture(scope="module")
def members(native_fmus, tmp_path_factory):
    folder = tmp_path_factory.mktemp("static")
    return [Unpacked.of(native_fmus[name], folder) for name in ("AhvController", "AhvBackstepping", "AhvPlant")]


# Target of the compiler -> what runs its programs.
ELSEWHERE = {"x86_64-windows-gnu": "wine", "aarch64-linux-musl": "qemu-aarch64"}


@pytest.mark.parametrize("target", [LINUX, pytest.param("x86_64-linux-musl", marks=pytest.mark.slow), *(
    pytest.param(target, marks=[pytest.mark.slow, pytest.mark.skipif(
        not shutil.which(runner), reason=f"no {runner}: apt-get install {package}")])
    for (target, runner), package in zip(ELSEWHERE.items(), ("wine64", "qemu-user")))])
def test_three_fmus_fly_in_one_static_program(members, native_fmus, tmp_path, target):
    """Through both doors, on Windows and Arm as well. The everyday program takes its C library from the system."""
    (tmp_path / "wiring.h").write_text(wiring(*members))
    objects = []
    for prefix, member in zip("ABC", members):
        objects.append(tmp_path / f"{prefix}.o")
        cc(*WARNINGS, "-O0", "-fno-sanitize=undefined", "-ffp-contract=off", f"-DFMI2_FUNCTION_PREFIX={prefix}_",
           f"-DFMI3_FUNCTION_PREFIX={prefix}_", "-c", "-o", objects[-1], member.folder / "sources" / "all.c",
           target=target)
    program = tmp_path / "static.exe"
    cc(*STRICT, *([] if target == LINUX else ["-static"]), f"-I{HEADERS}", f"-I{tmp_path}", "-o", program,
       HOSTS / "static.c", *objects, "-lm", target=target)
    said = run(*filter(None, [ELSEWHERE.get(target), program]),
               env={**os.environ, "WINEDEBUG": "-all", "WINEPREFIX": str(tmp_path / "wine")})
    rows = [list(map(float.fromhex, line.split())) for line in said.splitlines()]
    assert len(rows) == STEPS
    for row, shared in zip(rows, flown(native_fmus)):  # another C library has other last digits in its exponentials
        assert row == pytest.approx(shared, rel=1e-9, abs=1e-12)
