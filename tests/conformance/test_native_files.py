"""What a native FMU is made of: libraries that need nothing and export nothing else, and sources to make them again."""
import re
import struct
import subprocess
import sys
import zipfile
from importlib import import_module
from pathlib import Path

import pytest
from fmpy.validation import validate_fmu
from native_host import HEADERS, HOSTS, Unpacked, run

from cosim.vehicle.registry import MODELS
from fmus import native_compiler
from fmus.build import build
from fmus.model_files import model_files

CO_SIMULATION = {"fmi2" + name for name in re.findall(r"X\(([A-Z]\w+)\)", (HOSTS / "fmu.h").read_text())}
CO_SIMULATION |= {"fmi2GetTypesPlatform", "fmi2GetVersion"}
ZIG_MARKS = {"__dso_handle", "_mh_dylib_header"}  # addresses of the library itself, which zig's Mach-O linker exports


@pytest.fixture(scope="module", params=MODELS)
def fmu(request, native_fmus, tmp_path_factory) -> Unpacked:
    return Unpacked.of(native_fmus[request.param], tmp_path_factory.mktemp("files"))


def exports_below(trie: bytes, at: int = 0, prefix: str = "") -> set[str]:
    """Names in a Mach-O export trie: at each node what is exported there, then edges to other nodes."""
    def number(at: int) -> tuple[int, int]:
        value = shift = 0
        while True:
            value |= (trie[at] & 0x7f) << shift
            shift, at = shift + 7, at + 1
            if not trie[at - 1] & 0x80:
                return value, at

    size, at = number(at)
    found = {prefix.removeprefix("_")} if size else set()
    at += size
    edges, at = trie[at], at + 1
    for _ in range(edges):
        end = trie.index(b"\0", at)
        node, following = number(end + 1)
        found |= exports_below(trie, node, prefix + trie[at:end].decode())
        at = following
    return found


def mach_o(content: bytes) -> tuple[set[str], set[str]]:
    """(names a Mach-O library exports, libraries it needs)."""
    magic, _, _, kind, n_commands, _ = struct.unpack_from("<IiiIII", content)
    assert (magic, kind) == (0xfeedfacf, 6)  # 64 bit, a dynamic library
    at, exported, needed = 32, set(), set()
    for _ in range(n_commands):
        command, size = struct.unpack_from("<II", content, at)
        if command in (0x80000022, 0x80000033):  # LC_DYLD_INFO_ONLY, LC_DYLD_EXPORTS_TRIE
            start, length = struct.unpack_from("<II", content, at + (40 if command == 0x80000022 else 8))
            exported |= exports_below(content[start:start + length])
        if command == 0xc:  # LC_LOAD_DYLIB
            needed.add(content[at + struct.unpack_from("<I", content, at + 8)[0]:at + size].rstrip(b"\0").decode())
        at += size
    return exported, needed


def test_linux64_needs_libc_and_libm_of_2012_alone(fmu):
    needed = set(re.findall(r"NEEDED\s+(\S+)", run("objdump", "-p", fmu.library())))
    assert needed <= {"libc.so.6", "libm.so.6"}
    versions = re.findall(r"@GLIBC_2\.(\d+)", run("nm", "-D", fmu.library()))
    assert max(map(int, versions)) <= 17
    loaded = {line.split()[0] for line in run("ldd", fmu.library()).splitlines()}
    assert loaded <= {"linux-vdso.so.1", "libm.so.6", "libc.so.6", "/lib64/ld-linux-x86-64.so.2"}


def test_linux64_exports_the_fmi_functions_and_nothing_else(fmu):
    assert {line.split()[-1] for line in run("nm", "-D", "--defined-only", fmu.library()).splitlines()} == CO_SIMULATION


def test_darwin64_exports_the_fmi_functions_and_nothing_else(fmu):
    exported, needed = mach_o(fmu.library("darwin64", ".dylib").read_bytes())
    assert exported - ZIG_MARKS == CO_SIMULATION
    assert needed == {"/usr/lib/libSystem.B.dylib"}


def test_win64_exports_the_fmi_functions_and_needs_the_system_alone(fmu):
    told = run("objdump", "-p", fmu.library("win64", ".dll"))
    exported = told.partition("[Ordinal/Name Pointer] Table")[2]
    assert set(re.findall(r"^\s+\[ *\d+\] (\w+)$", exported, re.MULTILINE)) == CO_SIMULATION
    assert set(re.findall(r"DLL Name: (\S+)", told)) == {"ucrtbase.dll"}


def test_nothing_of_this_machine_is_in_a_library(fmu):
    for path in (fmu.folder / "binaries").rglob("*.*"):
        assert b"/work" not in path.read_bytes() and b"/tmp" not in path.read_bytes()


def test_sizes(fmu, native_fmus):
    assert native_fmus[fmu.name].stat().st_size < 450_000


def test_the_sources_are_clean_for_a_strict_compiler(fmu, tmp_path):
    fmu.compiled(tmp_path / "again.so", "-O0", "-Wshadow", "-Wconversion", "-Wvla")


def test_no_variable_is_shared_between_instances_or_threads(fmu, tmp_path):
    run("gcc", "-std=c99", "-fno-pic", "-fno-pie", "-c", "-o", tmp_path / "all.o", fmu.folder / "sources" / "all.c")
    kinds = {line.split()[-2] for line in run("nm", tmp_path / "all.o").splitlines()}
    assert not kinds & set("bBdDC")  # neither initialised nor zeroed writable data


def test_the_same_sources_give_the_same_bytes(native_fmus, tmp_path, monkeypatch):
    monkeypatch.setattr(native_compiler, "CACHE", tmp_path / "cache")
    again = build(MODELS["AhvScenario"], "native", tmp_path)
    assert again.read_bytes() == native_fmus["AhvScenario"].read_bytes()


def test_arm_processors_are_an_option(tmp_path):
    with zipfile.ZipFile(build(MODELS["AhvScenario"], "native", tmp_path, arm=True)) as archive:
        assert archive.read("binaries/aarch64-linux/AhvScenario.so")[18:20] == b"\xb7\x00"  # AArch64
        both = archive.read("binaries/darwin64/AhvScenario.dylib")
    magic, count = struct.unpack_from(">II", both)
    parts = [struct.unpack_from(">5I", both, 8 + 20 * i) for i in range(count)]
    assert magic == 0xcafebabe and [part[0] for part in parts] == [0x01000007, 0x0100000c]
    for _, _, offset, size, _ in parts:
        assert mach_o(both[offset:offset + size])[0] - ZIG_MARKS == CO_SIMULATION


@pytest.mark.parametrize("name", MODELS)
def test_checkers_find_nothing(native_fmus, name):
    assert validate_fmu(str(native_fmus[name])) == []
    told = subprocess.run([str(Path(sys.executable).with_name("fmutool")), "-input", native_fmus[name], "-check"],
                          capture_output=True, text=True)
    assert told.returncode == 0 and "No semantic error" in told.stdout + told.stderr


@pytest.mark.parametrize("flavour", ["native_fmus", "python_fmus"])
@pytest.mark.parametrize("name", MODELS)
def test_the_page_names_every_variable_and_the_icon_is_a_picture(request, flavour, name):
    with zipfile.ZipFile(request.getfixturevalue(flavour)[name]) as archive:
        text = archive.read("documentation/index.html").decode()
        icon = archive.read("model.png")
    model = import_module(MODELS[name])
    assert all(f"<td>{row[0]}</td>" in text for row in model.VARIABLES)
    assert all(preset in text for preset in model.PRESETS)
    assert icon.startswith(b"\x89PNG")


def test_the_page_has_the_equations_source(native_fmus):
    named = model_files(import_module("ahv_ctrl_fmu.neural_model"))
    assert {"ahv_ctrl_fmu/neural.py", "ahv_ctrl_fmu/differentiator.py", "ahv_plant_fmu/trim.py"} <= set(named)
    with zipfile.ZipFile(native_fmus["AhvController"]) as archive:
        text = archive.read("documentation/index.html").decode()
    assert all(f"<h3>{name.removesuffix('.py').replace('/', '.')}</h3>" in text for name in named)


def test_headers_are_the_standard_ones(fmu):
    for header in HEADERS.glob("fmi2*.h"):
        assert (fmu.folder / "sources" / header.name).read_bytes() == header.read_bytes()


def test_without_the_compiler_the_error_says_what_to_install(monkeypatch):
    def missing(_):
        raise native_compiler.PackageNotFoundError

    monkeypatch.setattr(native_compiler, "version", missing)
    with pytest.raises(RuntimeError, match="pip install ziglang"):
        native_compiler.compiler_version()
