"""One member of an archive of unknown origin, read without unpacking the others."""
import zipfile

import pytest

from cosim.master.unpack import BadArchive, read_member


@pytest.fixture
def archive(tmp_path):
    path = tmp_path / "some.fmu"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        file.writestr("a/b.txt", b"0123456789")
        file.writestr("bzip2", b"0123456789", zipfile.ZIP_BZIP2)
    return path


def test_a_member_is_read_up_to_the_most_that_is_allowed(archive):
    assert read_member(archive, "a/b.txt") == read_member(archive, "a/b.txt", 10) == b"0123456789"
    with pytest.raises(BadArchive, match=r"the member 'a/b\.txt' has more; at most 9 bytes are unpacked") as caught:
        read_member(archive, "a/b.txt", 9)
    assert caught.value.rule == "archive.size"


def test_what_cannot_be_read_is_named(archive, tmp_path):
    with pytest.raises(BadArchive, match=r"there is no member 'b\.txt'"):
        read_member(archive, "b.txt")
    with pytest.raises(BadArchive, match="the member 'bzip2' is compressed by method 12, not deflate"):
        read_member(archive, "bzip2")
    with pytest.raises(BadArchive, match="there is no file"):
        read_member(tmp_path / "nothing.fmu", "a/b.txt")


def test_a_damaged_member_is_named(archive):
    content = bytearray(archive.read_bytes())
    content[content.index(b"a/b.txt") + 9] ^= 0xFF
    archive.write_bytes(content)
    with pytest.raises(BadArchive, match=r"the member 'a/b\.txt' is truncated or damaged"):
        read_member(archive, "a/b.txt")
