"""The compiled tick loop: where its library comes from, and what flies without one."""
import struct
import subprocess

import numpy as np
import pytest
import small

from cosim.master import compile_loop, loop_compiled, loop_plain, program
from cosim.master.compile_loop import compile_to, everywhere, library, name
from cosim.master.fly import fly
from cosim.master.loaded import make_loop
from cosim.master.wiring import Wiring


@pytest.fixture
def elsewhere(tmp_path, monkeypatch):
    """An installation that is no checkout and has no library, of a user with a cache folder."""
    monkeypatch.setattr(compile_loop, "CHECKOUT", tmp_path / "none")
    monkeypatch.setattr(compile_loop, "BUILT", tmp_path / "built")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    loop_compiled.library.cache_clear()
    yield tmp_path
    loop_compiled.library.cache_clear()


def machine(content):
    """Format and processor of a library, by its first bytes."""
    if content.startswith(b"\x7fELF"):
        return "elf", struct.unpack_from("<H", content, 18)[0]
    if content.startswith(b"MZ"):
        return "pe", struct.unpack_from("<H", content, struct.unpack_from("<I", content, 0x3c)[0] + 4)[0]
    return "mach-o" if content.startswith(b"\xcf\xfa\xed\xfe") else "", struct.unpack_from("<I", content, 4)[0]


def test_a_wheel_carries_a_library_for_each_platform(elsewhere):
    (elsewhere / "built").mkdir()
    (elsewhere / "built" / "loop-of-another-time.so").write_text("old")
    made = everywhere()
    assert sorted((elsewhere / "built").iterdir()) == sorted(made)
    assert {path.name.split("-", 2)[2].partition(".")[0]: machine(path.read_bytes()) for path in made} == {
        "x86_64-linux": ("elf", 62), "aarch64-linux": ("elf", 183), "x86_64-windows": ("pe", 0x8664),
        "x86_64-darwin": ("mach-o", 0x01000007), "aarch64-darwin": ("mach-o", 0x0100000c)}
    for path in made:  # the same code gives the same bytes, which name nothing of this machine
        compile_to(elsewhere / "again", path.name.split("-", 2)[2].partition(".")[0])
        content = path.read_bytes()
        assert content == (elsewhere / "again").read_bytes() and str(elsewhere).encode() not in content
        assert all(function in content for function in (b"run", b"look_up_reals", b"look_up_wholes"))


def test_a_library_is_compiled_once_into_the_users_cache(elsewhere, monkeypatch):
    path = library()
    assert path == elsewhere / "cache" / "ahv" / path.name
    assert isinstance(make_loop(False, Wiring()), loop_compiled.Loop)
    assert [file.name for file in path.parent.iterdir()] == [path.name]
    monkeypatch.setattr(subprocess, "run", None)
    assert library() == path
    monkeypatch.setattr(program, "MOST_ROUNDS", 999)  # a library of other constants does not fit
    assert name("x86_64-linux") != path.name


def test_in_a_checkout_it_is_beside_the_code():
    assert library().parent == compile_loop.SOURCE.parent / "built"


@pytest.mark.parametrize("why", ["no compiler", "another machine"])
def test_without_one_the_plain_loop_flies(elsewhere, monkeypatch, capsys, why):
    fmu = small.build(elsewhere)
    compiled = fly(small.pair(fmu), 0.01, 1.0)
    loop_compiled.library.cache_clear()
    (elsewhere / "cache" / "ahv" / library().name).unlink()
    if why == "no compiler":
        monkeypatch.setattr(compile_loop, "find_spec", lambda name: None)
    else:
        monkeypatch.setattr(compile_loop.fmpy, "platform_tuple", "riscv64-linux")
    assert library() is None and isinstance(make_loop(False, Wiring()), loop_plain.Loop)
    assert np.array_equal(fly(small.pair(fmu), 0.01, 1.0).signals, compiled.signals)
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("why", ["source", "cache", "library"])
def test_what_keeps_it_from_being_compiled_or_loaded_is_said_once(elsewhere, monkeypatch, capsys, why):
    if why == "source":
        monkeypatch.setattr(compile_loop, "SOURCE", elsewhere / "loop.c")
        compile_loop.SOURCE.write_text("int run(;")
    elif why == "cache":
        (elsewhere / "cache").write_text("a file where the folder should be")
    else:
        (elsewhere / "built").mkdir()
        (elsewhere / "built" / name(compile_loop.fmpy.platform_tuple)).write_text("no library")
    assert isinstance(make_loop(False, Wiring()), loop_plain.Loop)
    assert isinstance(make_loop(False, Wiring()), loop_plain.Loop)
    said = capsys.readouterr().err
    assert said.count("ahv: The tick loop cannot be compiled or loaded, so ticks take the slower one in Python: ") == 1
    assert {"source": "expected parameter declarator", "cache": "Not a directory", "library": "too short"}[why] in said
