"""Temporary folders go with their program, and those of killed programs with the next one."""
import errno
import gc
import os
import signal
import subprocess
import sys
import zipfile

import pytest

from cosim import temporary
from cosim.errors import UsageError
from cosim.master import unpack
from cosim.temporary import Folder, NoTemporaryFolder

HOLD = "from cosim.temporary import Folder; kept = Folder(); print(kept.path, flush=True); input()"


@pytest.fixture(autouse=True)
def place(tmp_path, monkeypatch):
    """A TMPDIR of the test's own, where nothing was swept yet."""
    monkeypatch.setattr("tempfile.tempdir", None)
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    return tmp_path


def holder(place, code=HOLD):
    """Another program with a folder in `place`, and the folder."""
    program = subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    return program, place / program.stdout.readline().strip()


def swept():
    """What the next program does first."""
    subprocess.run([sys.executable, "-c", "from cosim.temporary import Folder; Folder()"], check=True)


@pytest.mark.parametrize("end", [lambda folder: folder.close(), lambda folder: folder.__exit__(None, None, None)])
def test_a_folder_goes_when_it_is_closed(place, end):
    folder = Folder()
    (folder.path / "some").mkdir()
    assert folder.path.parent == place and folder.path.stat().st_mode & 0o777 == 0o700
    end(folder)
    assert list(place.iterdir()) == []


def test_a_folder_goes_when_it_is_not_used_any_more(place):
    folder = Folder()
    del folder
    gc.collect()
    assert list(place.iterdir()) == []


def test_a_folder_goes_at_the_end_of_the_program(place):
    program, folder = holder(place)
    assert folder.is_dir()
    program.communicate("\n")
    assert list(place.iterdir()) == []


def test_the_next_program_removes_what_a_killed_one_left_and_nothing_else(place):
    (living, kept), (killed, left) = holder(place), holder(place)
    strange = [place / "ahv-temporary-results", place / f"{temporary.PREFIX}0123456789abcdefg", place / "x"]
    for folder in strange:
        folder.mkdir()
    (place / f"{temporary.PREFIX}0123456789abcdef").symlink_to(strange[0])
    killed.kill()
    killed.wait()
    swept()
    assert kept.is_dir() and not left.exists() and all(folder.is_dir() for folder in strange)
    living.communicate("\n")


def test_a_folder_stays_while_a_fork_of_its_program_lives(place):
    code = ("import os\nfrom cosim.temporary import Folder\nkept = Folder()\nif os.fork() == 0: os.read(0, 1)\n"
            "else: print(kept.path, flush=True); os.kill(os.getpid(), 9)")
    program, folder = holder(place, code)
    program.wait()
    swept()
    assert folder.is_dir()
    program.communicate("\n")
    for _ in range(100):
        swept()
        if not folder.exists():
            return
    raise AssertionError(f"{folder} is still there.")


def test_a_fork_does_not_remove_the_folder_of_its_program():
    folder = Folder()
    if (child := os.fork()) == 0:
        folder.close()
        os._exit(0)
    os.waitpid(child, 0)
    assert folder.path.is_dir()
    folder.close()


def test_a_signal_does_not_interrupt_the_removal(place, monkeypatch):
    folder, remove = Folder(), temporary.empty

    def interrupted(path):
        monkeypatch.setattr(temporary, "empty", remove)
        raise KeyboardInterrupt

    monkeypatch.setattr(temporary, "empty", interrupted)
    with pytest.raises(KeyboardInterrupt):
        folder.close()
    assert list(place.iterdir()) == []


@pytest.mark.parametrize("number,sentence", [
    (errno.ENOSPC, "is full"), (errno.EDQUOT, "is full"), (errno.EROFS, "cannot be written to: Read-only file system"),
    (errno.EACCES, "cannot be written to: Permission denied")])
def test_what_the_place_refuses_is_no_fault_of_the_archive(place, monkeypatch, number, sentence):
    def refuse(*_):
        raise OSError(number, os.strerror(number))

    with zipfile.ZipFile(place / "some.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", "<some/>")
    monkeypatch.setattr(unpack, "copy", refuse)
    with Folder() as outer:
        monkeypatch.setattr("tempfile.tempdir", str(outer.path))
        with Folder() as folder, pytest.raises(NoTemporaryFolder) as caught:
            unpack.safe_extract(place / "some.fmu", folder.path)
    assert str(caught.value) == f"TMPDIR {place} {sentence}."


def test_what_a_name_or_a_content_causes_stays_the_archives_fault(place):
    with zipfile.ZipFile(place / "some.fmu", "w") as archive:
        archive.writestr("a", "")
        archive.writestr("a/b", "")
    with Folder() as folder, pytest.raises(unpack.BadArchive, match="cannot be unpacked"):
        unpack.safe_extract(place / "some.fmu", folder.path)


@pytest.mark.parametrize("name,reason", [("none", "No such file or directory"), ("file", "Not a directory")])
def test_a_tmpdir_that_cannot_be_used_is_named_and_no_other_taken(place, monkeypatch, name, reason):
    (place / "file").touch()
    monkeypatch.setenv("TMPDIR", str(place / name))
    with pytest.raises(UsageError, match=rf"^TMPDIR {place / name} cannot be written to: {reason}\.$"):
        Folder()


def test_a_program_that_a_signal_ends_leaves_nothing(place):
    program, folder = holder(place)
    program.send_signal(signal.SIGINT)
    program.wait()
    assert not folder.exists()
