"""SSP files from a stranger: one sentence, exit 2, nothing outside the work folder, nothing left behind."""
import os
import struct
import subprocess
import tempfile
import zipfile
from pathlib import Path

import pytest
from places import AHV
from ssp_files import HEAD, component, connection, gain, inline, parameter, ssd, system, write

from cosim.errors import UsageError
from cosim.systems.simulate import simulate

ONE = ssd(system("root", component("a")))
ENTITIES = "".join(f"<!ENTITY a{i} '{10 * f'&a{i - 1};'}'>" for i in range(1, 30))
BOMB = f"{HEAD}<!DOCTYPE x [<!ENTITY a0 'aaaaaaaaaa'>{ENTITIES}]><x>&a29;</x>"
THIEF = f'{HEAD}<!DOCTYPE x [<!ENTITY a SYSTEM "file:///etc/passwd">]><x>&a;</x>'

SHARED = '<ssd:Connector name="p" kind="inout"/>'
CIRCLE = ssd(system("root", system("x", component("a"), connection(".p", "a.u"), SHARED)
                    + system("y", component("b"), "", SHARED), connection("x.p", "y.p") + connection("y.p", "x.p")))


def truncated(path):
    data = write(path, ONE).read_bytes()
    path.write_bytes(data[:len(data) // 2])


def damaged(path):
    data = bytearray(write(path, ONE).read_bytes())
    data[len(data) // 3] ^= 0xFF
    path.write_bytes(data)


def words(path):
    path.write_text("not a zip file at all")


def escaping(path):
    write(path, ONE)
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("../../escaped.txt", "x")


def absolute(path):
    write(path, ONE)
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("/tmp/escaped.txt", "x")


def link(path):
    write(path, ONE)
    entry = zipfile.ZipInfo("resources/link")
    entry.external_attr = 0o120777 << 16
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr(entry, "/etc")


def claiming_2_gb(path):
    """The archive's directory says 2 GB of a member that has a few hundred bytes."""
    data = bytearray(write(path, ONE).read_bytes())
    place = data.rindex(b"PK\x01\x02") + 24
    data[place:place + 4] = struct.pack("<I", 2 << 30)
    path.write_bytes(data)


def unpacking_to_a_gigabyte(path):
    write(path, ONE)
    archive = zipfile.ZipFile(path, "a", zipfile.ZIP_DEFLATED, compresslevel=1)
    with archive, archive.open("resources/zeros", "w") as member:
        for _ in range(1025):
            member.write(bytes(1 << 20))


BAD = {
    "no file": (lambda path: None, "there is no file"),
    "a truncated archive": (truncated, "truncated or damaged"),
    "a damaged archive": (damaged, "damaged"),
    "no archive": (words, "is not a zip file"),
    "a path that leads outside": (escaping, "leads outside of the archive"),
    "an absolute path": (absolute, "leads outside of the archive"),
    "a symbolic link": (link, "is a symbolic link"),
    "a claim of 2 GB": (claiming_2_gb, "bytes"),
    "a gigabyte of zeros": (unpacking_to_a_gigabyte, "at most 1073741824 bytes are unpacked"),
    "no description": (lambda path: write(path, None), "has no SystemStructure.ssd: it is not an SSP"),
    "an empty description": (lambda path: write(path, ""), "SystemStructure.ssd is not well-formed XML"),
    "half a description": (lambda path: write(path, ONE[:len(ONE) // 2]), "SystemStructure.ssd is not well-formed XML"),
    "an unknown encoding": (lambda path: write(path, ONE.replace("UTF-8", "UTF-88")), "is not well-formed XML"),
    "another XML file": (lambda path: write(path, "<html/>"), "its root element is html"),
    "entities without bound": (lambda path: write(path, BOMB), "declares a document type"),
    "an entity from a file": (lambda path: write(path, THIEF), "declares a document type"),
    "a missing attribute": (lambda path: write(path, ONE.replace(' kind="input"', "")),
                            "The attribute 'kind' is required but missing"),
    "a parameter set with entities": (lambda path: write(path, ssd(system("root", component(
        "a", bindings='<ssd:ParameterBinding source="p.ssv"/>'))), p_dot_ssv=BOMB), "p.ssv declares a document type"),
    "a parameter that is no number": (
        lambda path: write(path, ssd(system("root", component("a", bindings=inline(parameter("k", "heavy")))))),
        "'heavy' is not a valid value"),
    "a parameter that may not be set": (
        lambda path: write(path, ssd(system("root", component("a", bindings=inline(parameter("y", 1)))))),
        "a.y is an output and cannot be set"),
    "an FMU that is no archive": (lambda path: write(path, ONE, resources__Gain_dot_fmu="x"),
                                  "resources/Gain.fmu cannot be opened: 'Gain.fmu' is not a zip file"),
    "an FMU that leads outside": (
        lambda path: write(path, ONE, resources__Gain_dot_fmu=hostile_fmu(path)),
        "resources/Gain.fmu cannot be opened: the member '../../../escaped.txt' leads outside"),
    "an FMU with entities": (lambda path: write(path, ONE, resources__Gain_dot_fmu=hostile_fmu(path, BOMB)),
                             "resources/Gain.fmu cannot be read as an FMU"),
    "a step of nothing": (lambda path: write(path, ONE.replace('stopTime="1"', 'stopTime="0"')), "--stop"),
    "no stop": (lambda path: write(path, ssd(system("root", component("a")), "")), "does not say when to stop"),
    "a stop before the start": (lambda path: write(path, ssd(system("root", component("a")),
                                                             '<ssd:DefaultExperiment startTime="5" stopTime="4"/>')),
                                "--stop 4 s must be after the start at 5 s"),
    "a circle of connections": (lambda path: write(path, CIRCLE), "lead in a circle through"),
}


def hostile_fmu(path, description=None):
    """An FMU with this modelDescription.xml, or Gain.fmu with a path that leads outside."""
    inner = path.with_suffix(".fmu")
    if description is None:
        inner.write_bytes(gain())
    with zipfile.ZipFile(inner, "a") as archive:
        archive.writestr("../../../escaped.txt" if description is None else "modelDescription.xml", description or "x")
    data = inner.read_bytes()
    inner.unlink()
    return data


@pytest.fixture
def work(tmp_path, monkeypatch):
    """A work folder, with a temporary folder beside it."""
    (tmp_path / "work").mkdir()
    (tmp_path / "temporary").mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))
    monkeypatch.chdir(tmp_path / "work")
    return tmp_path / "work"


@pytest.mark.parametrize("make,sentence", BAD.values(), ids=BAD)
def test_is_refused_with_one_sentence_and_leaves_nothing(make, sentence, work):
    make(work / "bad.ssp")
    before = sorted(work.parent.rglob("*"))
    with pytest.raises(UsageError) as error:
        simulate(Path("bad.ssp"), 0.5, None, "gauss-seidel", None)
    assert sentence in str(error.value) and "\n" not in str(error.value)
    assert sorted(work.parent.rglob("*")) == before


@pytest.mark.parametrize("what", ["a truncated archive", "a path that leads outside", "entities without bound",
                                  "an FMU that leads outside"])
def test_the_command_exits_with_2(what, work):
    make, sentence = BAD[what]
    make(work / "bad.ssp")
    before = sorted(work.parent.rglob("*"))
    done = subprocess.run([AHV, "simulate", "bad.ssp", "--json"], capture_output=True, text=True, timeout=120,
                          env={**os.environ, "TMPDIR": str(work.parent / "temporary")})
    assert done.returncode == 2 and not done.stdout
    assert sentence in done.stderr and done.stderr.startswith("ahv: ") and len(done.stderr.strip().splitlines()) == 1
    assert sorted(work.parent.rglob("*")) == before
