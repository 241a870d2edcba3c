"""What a native FMU is made of: libraries that need nothing and export nothing else, and sources to make them again."""
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile
from functools import partial
from importlib import import_module
from pathlib import Path

import lief
import pytest
from fmpy.validation import validate_fmu
from native_host import HEADERS, Unpacked, run
from places import ROOT

from cosim.vehicle.registry import MODELS
from fmus import native_compiler
from fmus.builder import build
from fmus.model_files import model_files
from fmus.native_compiler import cc

FUNCTIONS = {name for version in "23" for name in re.findall(rf"\b(fmi{version}\w+)TYPE\b", (
    HEADERS / f"fmi{version}FunctionTypes.h").read_text())}
ZIG_MARKS = {"__dso_handle", "_mh_dylib_header"}  # addresses of the library itself, which zig's Mach-O linker exports


@pytest.fixture(scope="module", params=MODELS)
def fmu(request, native_fmus, tmp_path_factory) -> Unpacked:
    return Unpacked.of(native_fmus[request.param], tmp_path_factory.mktemp("files"))


def mach_o(library: lief.MachO.Binary) -> tuple[set[str], set[str]]:
    """(names a Mach-O library exports, libraries it needs)."""
    assert library.header.file_type == lief.MachO.Header.FILE_TYPE.DYLIB
    exported = {str(symbol.name).removeprefix("_") for symbol in library.exported_symbols}
    load = lief.MachO.LoadCommand.TYPE.LOAD_DYLIB
    return exported, {entry.name for entry in library.libraries if entry.command == load}


def test_linux64_needs_libc_and_libm_of_2012_alone(fmu):
    library = lief.ELF.parse(str(fmu.library()))
    assert set(library.libraries) <= {"libc.so.6", "libm.so.6"}
    versions = [auxiliary.name for required in library.symbols_version_requirement
                for auxiliary in required.get_auxiliary_symbols()]
    assert versions and max(int(re.fullmatch(r"GLIBC_2\.(\d+)[.\d]*", name)[1]) for name in versions) <= 17
    loaded = {line.split()[0] for line in run("ldd", fmu.library()).splitlines()}
    assert loaded <= {"linux-vdso.so.1", "libm.so.6", "libc.so.6", "/lib64/ld-linux-x86-64.so.2"}


def test_linux64_exports_the_fmi_functions_and_nothing_else(fmu):
    library = lief.ELF.parse(str(fmu.library()))
    assert {symbol.name for symbol in library.exported_symbols} == FUNCTIONS


def test_darwin64_exports_the_fmi_functions_and_nothing_else(fmu):
    library = lief.MachO.parse(str(fmu.library("darwin64", ".dylib")))
    exported, needed = mach_o(library[0])
    assert exported - ZIG_MARKS == FUNCTIONS
    assert needed == {"/usr/lib/libSystem.B.dylib"}


def test_win64_exports_the_fmi_functions_and_needs_the_system_alone(fmu):
    library = lief.PE.parse(str(fmu.library("win64", ".dll")))
    assert {entry.name for entry in library.get_export().entries} == FUNCTIONS
    assert {entry.name for entry in library.imports} == {"ucrtbase.dll"}


def test_nothing_of_this_machine_is_in_a_library(fmu):
    folders = [str(folder).encode() for folder in (ROOT, sys.prefix, tempfile.gettempdir())]
    for path in (fmu.folder / "binaries").rglob("*.*"):
        assert not [folder for folder in folders if folder in path.read_bytes()]


def test_sizes(fmu, native_fmus):
    platforms = len(list((fmu.folder / "binaries").glob("*/*"))) + 1  # darwin64 is for two processors
    assert native_fmus[fmu.name].stat().st_size < 190_000 * platforms  # sources and experiments beside them


STRICTER = ["-O0", "-Wshadow", "-Wconversion", "-Wvla"]


def test_the_sources_are_clean_for_clang(fmu, tmp_path):
    """All but two warnings, which clang extends to the truth of a double and to the sign of an enum."""
    fmu.compiled(tmp_path / "again.so", *STRICTER, "-Wno-float-conversion", "-Wno-sign-conversion")


@pytest.mark.skipif(not shutil.which("gcc"), reason="no gcc: apt-get install gcc libc6-dev")
def test_the_sources_are_clean_for_gcc(fmu, tmp_path):
    fmu.compiled(tmp_path / "again.so", *STRICTER, compiler=partial(run, "gcc"))


def test_no_variable_is_shared_between_instances_or_threads(fmu, tmp_path):
    cc("-std=c99", "-O2", "-fno-common", "-c", "-o", tmp_path / "all.o", fmu.folder / "sources" / "all.c")
    library = lief.ELF.parse(str(tmp_path / "all.o"))
    writable = {section.name for section in library.sections
                if section.has(lief.ELF.Section.FLAGS.WRITE) and section.size}
    assert writable <= {".data.rel.ro"}  # constant once addresses are known


def test_the_same_sources_give_the_same_bytes(native_fmus, tmp_path, monkeypatch):
    monkeypatch.setattr(native_compiler, "CACHE", tmp_path / "cache")
    again = build(MODELS["AhvScenario"], "native", tmp_path)
    assert again.read_bytes() == native_fmus["AhvScenario"].read_bytes()


def test_one_library_serves_both_versions_and_arm_processors_as_well(native_fmus, native_fmi3_fmus):
    with zipfile.ZipFile(native_fmus["AhvScenario"]) as archive, \
            zipfile.ZipFile(native_fmi3_fmus["AhvScenario"]) as in_fmi3:
        assert archive.read("binaries/aarch64-linux/AhvScenario.so")[18:20] == b"\xb7\x00"  # AArch64
        both = archive.read("binaries/darwin64/AhvScenario.dylib")
        separate = [in_fmi3.read(f"binaries/{tuple_}-darwin/AhvScenario.dylib") for tuple_ in ("x86_64", "aarch64")]
        assert all(library in both for library in separate)
        for folder, tuple_, suffix in (("linux64", "x86_64-linux", ".so"), ("win64", "x86_64-windows", ".dll")):
            assert in_fmi3.read(f"binaries/{tuple_}/AhvScenario{suffix}") == \
                archive.read(f"binaries/{folder}/AhvScenario{suffix}")  # one library, two doors
    processors = lief.MachO.parse(list(both))
    cpu = lief.MachO.Header.CPU_TYPE
    assert {library.header.cpu_type for library in processors} == {cpu.X86_64, cpu.ARM64}
    assert all(mach_o(library)[0] - ZIG_MARKS == FUNCTIONS for library in processors)


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
    for header in HEADERS.glob("*.h"):
        assert (fmu.folder / "sources" / header.name).read_bytes() == header.read_bytes()


def test_without_the_compiler_the_error_says_what_to_install(monkeypatch):
    def missing(_):
        raise native_compiler.PackageNotFoundError

    monkeypatch.setattr(native_compiler, "version", missing)
    with pytest.raises(ModuleNotFoundError, match="pip install ziglang"):
        native_compiler.compiler_version()


def test_the_cache_of_libraries_is_made_and_used(tmp_path, monkeypatch):
    monkeypatch.setattr(native_compiler, "CACHE", tmp_path / "new" / "cache")
    sources = {"all.c": b"int answer(void) { return 42; }"}
    made = native_compiler.library("answer.so", native_compiler.LINUX, sources)
    kept, = native_compiler.CACHE.iterdir()
    assert kept.read_bytes() == made
    monkeypatch.setattr(native_compiler, "make", None)  # no need of it now
    assert native_compiler.library("answer.so", native_compiler.LINUX, sources) == made
