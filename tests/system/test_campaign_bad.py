"""Campaign files that are wrong, of any system and of ours: one sentence with line and field, exit status 2, no cluster
started, nothing written. `test_campaign_file` has more of scenarios."""
import zipfile

import pytest
from bad_campaigns import ANY, BAD, FILES
from places import ROOT

from cosim.campaign import cluster
from cosim.cli.app import done

NATIVE = ROOT / "fmus" / "dist" / "native"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """What bad files name: tables, systems, and two of our FMUs without their sources, which take long to unpack."""
    made = tmp_path_factory.mktemp("bad")
    for name in ("AhvPlant.fmu", "AhvController.fmu"):
        with zipfile.ZipFile(NATIVE / name) as full, zipfile.ZipFile(made / name, "w") as slim:
            for entry in ("modelDescription.xml", f"binaries/linux64/{name.replace('.fmu', '.so')}"):
                slim.writestr(entry, full.read(entry))
    for name, text in FILES.items():
        (made / name).write_text(text)
    return made


@pytest.fixture
def refused(folder, capfd, monkeypatch):
    """What `ahv campaign` says of a file with the text ANY, `before` of it replaced by `after`."""
    def started(*_, **__):
        raise AssertionError("a cluster was started")

    def said(before, after):
        assert before in ANY
        (folder / "bad.yaml").write_text(ANY.replace(before, after, 1))
        there = set(folder.iterdir())
        status = done(["campaign", str(folder / "bad.yaml"), "--out", str(folder / "out")])
        out, error = capfd.readouterr()
        assert (status, out, set(folder.iterdir())) == (2, "", there), error
        assert len(error.splitlines()) == 1 and error.rstrip().endswith((".", "?")), error
        return error.removeprefix(f"ahv: {folder}/").removeprefix("bad.yaml, ").replace(f"{folder}/", "").replace(
            str(folder), "")

    monkeypatch.setattr(cluster, "local", started)
    return said


@pytest.mark.parametrize("before,after,sentence", BAD.values(), ids=BAD)
def test_a_wrong_file_is_refused_in_one_sentence_with_line_and_field(before, after, sentence, refused):
    assert refused(before, after).startswith(sentence)


def test_there_are_sixty():
    assert len({(before, after) for before, after, _ in BAD.values()}) == len(BAD) >= 60
