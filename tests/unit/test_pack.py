"""The one way of writing a zip archive: the same bytes every time, whole or not at all."""
import zipfile

import pytest

from fmus.pack import digest, write

FILES = {"b/two.bin": bytes(1000), "a.txt": b"one", "c": b""}


def test_an_archive_has_its_files_sorted_without_dates_and_readable_by_all(tmp_path):
    path = tmp_path / "new" / "folder" / "x.zip"
    write(path, FILES)
    with zipfile.ZipFile(path) as archive:
        assert archive.namelist() == ["a.txt", "b/two.bin", "c"]
        assert {name: archive.read(name) for name in archive.namelist()} == FILES
        for entry in archive.infolist():
            assert entry.date_time == (1980, 1, 1, 0, 0, 0) and entry.external_attr >> 16 == 0o644
            assert entry.compress_type == zipfile.ZIP_DEFLATED
    assert path.stat().st_size < 600


def test_equal_contents_give_equal_bytes_whatever_their_order(tmp_path):
    write(tmp_path / "one", FILES)
    write(tmp_path / "two", dict(reversed(FILES.items())))
    assert (tmp_path / "one").read_bytes() == (tmp_path / "two").read_bytes()


def test_what_cannot_be_written_leaves_the_old_file_and_nothing_else(tmp_path):
    path = tmp_path / "x.zip"
    write(path, FILES)
    before = path.read_bytes()
    with pytest.raises(TypeError):
        write(path, {**FILES, "d": None})
    assert path.read_bytes() == before and [p.name for p in tmp_path.iterdir()] == ["x.zip"]
    write(path, {"a.txt": b"other"})
    assert path.read_bytes() != before and [p.name for p in tmp_path.iterdir()] == ["x.zip"]


def test_a_digest_is_of_names_and_contents():
    found = [digest(f) for f in (FILES, dict(reversed(FILES.items())), {**FILES, "c": b"x"},
                                 {"b/two.bin": bytes(1000), "a.txt": b"one", "d": b""}, {"a": b"b"}, {"ab": b""})]
    assert found[0] == found[1] and len(set(found)) == 5
