"""safe_extract and read_library on what a stranger may send: one sentence, or the content, and never anything else."""

import io
import zipfile
from pathlib import Path

import pytest
from check_fixture import library, write
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cosim.conformance.binary import BadBinary, read_library
from cosim.master.unpack import BadArchive, safe_extract
from fmus.native_compiler import cc


def test_contents_arrive_unchanged(tmp_path: Path) -> None:
    content = {"a.txt": b"one", "b/c.txt": b"two", "b/d/": b""}
    (tmp_path / "out").mkdir()
    names = safe_extract(write(tmp_path / "x.fmu", content), tmp_path / "out")
    assert names == list(content)
    assert (tmp_path / "out" / "b" / "c.txt").read_bytes() == b"two"
    assert (tmp_path / "out" / "b" / "d").is_dir()


def test_bomb_of_zeros_stops_at_the_limit(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    file = write(tmp_path / "x.fmu", {"zeros": bytes(5_000_000)})
    with pytest.raises(BadArchive, match="claims 5000000 bytes; at most 1000000 bytes are unpacked"):
        safe_extract(file, tmp_path / "out", max_total_bytes=1_000_000)
    assert list((tmp_path / "out").iterdir()) == []


def test_many_members_count_together(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    file = write(tmp_path / "x.fmu", {f"{n}": bytes(400_000) for n in range(3)})
    with pytest.raises(BadArchive, match="the members claim 1200000 bytes together"):
        safe_extract(file, tmp_path / "out", max_total_bytes=1_000_000)


def test_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(BadArchive, match=r"there is no file '.*none\.fmu'"):
        safe_extract(tmp_path / "none.fmu", tmp_path)


@pytest.mark.parametrize("name", ["../a", "/a", "a/../../b", "C:/a", "C:a", "\\\\host\\share\\a", "..\\a"])
def test_names_that_lead_outside_are_refused_before_anything_is_written(tmp_path: Path, name: str) -> None:
    (tmp_path / "out").mkdir()
    file = write(tmp_path / "x.fmu", {"first.txt": b"x", name: b"y"})
    with pytest.raises(BadArchive, match="leads outside"):
        safe_extract(file, tmp_path / "out")
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["out", "x.fmu"]


def test_only_deflate_is_unpacked(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    file = write(tmp_path / "x.fmu", {"a.txt": b"one"}, zipfile.ZIP_BZIP2)
    with pytest.raises(BadArchive, match=r"the member 'a\.txt' is compressed by method 12, not deflate") as caught:
        safe_extract(file, tmp_path / "out")
    assert caught.value.rule == "archive.compression" and not list((tmp_path / "out").iterdir())


def _small_zip() -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("modelDescription.xml", "<fmi/>" * 50)
        archive.writestr("resources/data.bin", bytes(range(256)))
    return buffer.getvalue()


SMALL_ZIP = _small_zip()
_quick = settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


@_quick
@given(at=st.integers(0, len(SMALL_ZIP) - 1), byte=st.integers(0, 255))
def test_any_flipped_byte_gives_content_or_one_sentence(tmp_path: Path, at: int, byte: int) -> None:
    out = tmp_path / "out"
    out.mkdir(exist_ok=True)
    (tmp_path / "x.fmu").write_bytes(SMALL_ZIP[:at] + bytes([byte]) + SMALL_ZIP[at + 1 :])
    try:
        safe_extract(tmp_path / "x.fmu", out, max_total_bytes=1_000_000)
    except BadArchive as problem:
        assert "\n" not in str(problem)
    assert {path.name for path in tmp_path.iterdir()} <= {"out", "x.fmu"}


@_quick
@given(cut=st.integers(0, 30_000), at=st.integers(0, 700), data=st.binary(max_size=16))
def test_any_damaged_library_gives_tables_or_one_sentence(tmp_path: Path, cut: int, at: int, data: bytes) -> None:
    whole = library()[: max(cut, at + len(data))]
    (tmp_path / "x.so").write_bytes(whole[:at] + data + whole[at + len(data) :])
    try:
        read_library(tmp_path / "x.so")
    except BadBinary as problem:
        assert "\n" not in str(problem)


def test_library_tables(tmp_path: Path) -> None:
    (tmp_path / "x.so").write_bytes(library())
    tables = read_library(tmp_path / "x.so")
    assert (tables.system, tables.machines) == ("linux", {"x86_64"})
    assert {"fmi2DoStep", "fmi2Instantiate"} <= tables.exports
    assert "malloc" not in tables.exports  # imported, not exported


@pytest.mark.slow
@pytest.mark.parametrize(
    ("target", "system", "machine"),
    [
        ("x86_64-windows-gnu", "windows", "x86_64"),
        ("x86-windows-gnu", "windows", "x86"),
        ("aarch64-macos", "darwin", "aarch64"),
        ("x86_64-macos", "darwin", "x86_64"),
        ("x86-linux-gnu", "linux", "x86"),
    ],
)
def test_libraries_of_other_platforms(tmp_path: Path, target: str, system: str, machine: str) -> None:

    source = tmp_path / "f.c"
    export = "__declspec(dllexport) " if system == "windows" else ""
    source.write_text(f"static int hidden(void) {{ return 1; }}\n{export}int fmi2DoStep(void) {{ return hidden(); }}\n")
    cc("-shared", "-o", tmp_path / "x", source, target=target)
    tables = read_library(tmp_path / "x")
    assert (tables.system, tables.machines) == (system, {machine})
    assert "fmi2DoStep" in tables.exports and "hidden" not in tables.exports
