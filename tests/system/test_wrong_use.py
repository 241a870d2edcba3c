"""No input gets a traceback, a hang, or an end without a sentence: members of every class, drawn from a seed.

`pytest -m slow tests/system/test_wrong_use.py -s` tries more than two thousand and prints a table.
"""
import subprocess

import pytest
import wrong_tried
import wrong_use
import wrong_words
import yaml
from altered import redescribed
from places import AHV

from cosim.cli import app, unforeseen
from cosim.vehicle.closed_loop import fmu_path

FEW = 5


@pytest.mark.parametrize("kind", wrong_use.KINDS)
def test_a_few_of_each_kind(kind, tmp_path, native_fmus):
    assert wrong_tried.tally(kind, 0, FEW, tmp_path).faults == []


@pytest.mark.slow
@pytest.mark.parametrize("kind", wrong_use.KINDS)
def test_all_of_each_kind(kind, tmp_path, native_fmus):
    found = wrong_tried.tally(kind, 0, wrong_use.KINDS[kind][1], tmp_path)
    print(found)
    assert found.faults == []


def test_there_are_two_thousand():
    assert sum(count for _, count in wrong_use.KINDS.values()) >= 2000


ALIASES = ("a0: &a0 [x,x,x,x,x,x,x,x,x]\n"
           + "".join(f"a{i}: &a{i} [{','.join([f'*a{i - 1}'] * 9)}]\n" for i in range(1, 10)))


@pytest.mark.parametrize("text, sentence", [
    ("a: " + "[" * 5000, "line 1: this is not YAML: it is nested more than 50 levels deep."),
    ("a:\n" + "".join(f"{' ' * i}- \n" for i in range(1, 300)), "it is nested more than 50 levels deep."),
    (ALIASES, "there are more than 100000 values, those of aliases included."),
    ("a: &a [*a]", "it contains itself."), ("a: &a {b: &b [*a, *b]}", "it contains itself."),
    ("a: " + "x" * 1_000_001, "file has at most 1000 kB."),
    ("name: \"\\ud800\"", "is no text."), ("a: !!int ''", "a value does not fit its type"),
    ("a: 2001-99-99", "a value does not fit its type"), ("a: " + "9" * 5000, "a value does not fit its type"),
], ids=lambda text: text[:20])
def test_yaml_without_bounds_is_refused_at_once(text, sentence, tmp_path):
    (tmp_path / "own.yaml").write_text(text)
    for command in ("run", "info", "ssp", "compare"):
        found = wrong_tried.tried(wrong_use.Bad("", lambda c=command: wrong_use.ended([c, str(tmp_path / "own.yaml")]),
            ""))
        assert found[0] == 2 and found[1] < wrong_tried.LONGEST and sentence in found[2]


@pytest.mark.parametrize("words", [
    ["run", "x" * 5000], ["run", "x" * 300 + ".yaml"], ["run", "hold", "--controller", "~nobody/x.fmu"], ["check",
        "x" * 300],
    ["info", "x" * 300 + ".fmu"], ["simulate", "x" * 300 + ".ssp"], ["campaign", "x" * 300 + ".yaml"], ["run",
        "/proc/1/mem"],
    ["run", "hold", "--algorithm", "variable,tolerance=1e-300"],
    ["run", "hold", "--real-time", "1e-300", "--step", "0"],
    ["ssp", "hold", "--out", ""], ["ssp", "hold", "--out", "/"], ["container", "hold", "--out", "/"],
    ["tune", "neural", "--seed", "9" * 30],
    ["info", "/proc/self/mem"],
    ["linearize", "--plant", "instrumented", "--step", "1e-12"], ["tune", "neural", "--sigma", "1e308"],
    ["run", "hold", "--step", "1e-320"], ["run", "hold", "--time-limit", "0"], ["tune", "neural", "--gain", "nobody"],
    ["run", "hold", "--algorithm", "multi-rate,controller=99999999999999999999"], ["linearize", "--V", "0"],
    ["run", "hold", "--algorithm", "iterated,passes=1" + "0" * 5000], ["run", "hold", "--set",
        "plant.mass=" + "9" * 5000],
], ids=lambda words: " ".join(words)[:40])
def test_in_a_process_of_its_own(words, tmp_path):
    """As a user sees it: exit status 2 and one line."""
    done = subprocess.run([AHV, *words], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 2 and done.stdout == ""
    assert len(done.stderr.splitlines()) == 1 and done.stderr.startswith("ahv: ") and len(done.stderr) < 5000


@pytest.mark.parametrize("word", ["/", "", ".", "nul\0l", "\ud800"])
@pytest.mark.parametrize("command", [["playground"], ["view", "nothing"], ["check", "nothing.fmu"]])
def test_a_page_that_no_file_can_be_is_refused(command, word):
    status, _, said = wrong_tried.tried(wrong_use.Bad("", lambda: wrong_use.ended([*command, "--out", word]), ""))
    assert (status, said) == (2, f"ahv: --out {word!r} is not allowed: it must be the path of a file.\n")


@pytest.mark.parametrize("command", [["info"], ["check", "--no-dynamic"], ["run", "hold", "--stop", "0.02",
    "--controller"]])
@pytest.mark.parametrize("swap", [
    *(('encoding="UTF-8"', f'encoding="{name}"') for name in ("UTF-7", "UTF-16", "EBCDIC-CP-US", "idna", "hex",
    "x" * 100_000)),
    ('modelIdentifier="AhvController"', f'modelIdentifier="{"x" * 100_000}"'), ('start="7700.0"', 'start="1e999"'),
    ('name="V"', f'name="{"V" * 100_000}"'), ("<ModelVariables>", "<a>" * 5000),
], ids=lambda swap: swap[1][:30])
def test_a_description_that_is_odd(swap, command, tmp_path, native_fmus):
    odd = redescribed(fmu_path("native", "AhvController"), tmp_path / "odd.fmu", swap)
    words = [*command, str(odd), *(["--out", str(tmp_path)] if command[0] == "run" else [])]
    status, seconds, said = wrong_tried.tried(wrong_use.Bad("", lambda: wrong_use.ended(words), ""))
    assert wrong_tried.fault(status, seconds, said) == ""


@pytest.mark.parametrize("name, distribution, sentence", [
    ("plant.mass", {"distribution": "normal", "mean": -1e308, "std": 1e300, "low": 301.0, "high": 401.0},
     "would not be finite numbers"),
    ("plant.mass", {"distribution": "normal", "mean": 300.0, "std": 1e308}, "would not be finite numbers"),
    ("plant.mass", {"distribution": "log-normal", "median": 300.0, "sigma": 1000.0}, "would not be finite numbers"),
    ("plant.beta_1", {"distribution": "uniform", "low": -1e308, "high": 1e308}, "would not be finite numbers"),
    ("plant.beta_1", {"distribution": "uniform", "low": 1e300, "high": 1e307, "relative": True}, "would not be finite"),
    ("plant.mass", {"distribution": "choice", "values": [300.0], "weights": [1e309]}, "finite number"),
    ("plant.mass", {"distribution": "choice", "values": [1.0, 2.0], "weights": [1e308, 1e308]}, "with a finite sum"),
    ("plant.start_at_trim", {"distribution": "normal", "mean": 0.0, "std": 1.0},
     "plant.start_at_trim (Boolean) takes the distribution choice or integer, not normal."),
], ids=str)
def test_a_distribution_that_cannot_be_is_refused(name, distribution, sentence, tmp_path, native_fmus):
    file = tmp_path / "own.yaml"
    data = {**wrong_words.CAMPAIGN, "correlations": [], "dispersions": {name: distribution}}
    file.write_text(yaml.safe_dump(data))
    status, _, said = wrong_tried.tried(wrong_use.Bad("", lambda: wrong_use.planned(file), ""))
    assert status == 2 and f"dispersions.{name}" in said and sentence in said


def test_what_nobody_foresaw_is_one_sentence_and_a_file(monkeypatch, tmp_path, capsys):
    def broken(*_: object) -> None:
        raise KeyError("nobody foresaw it")

    monkeypatch.setattr(app, "app", lambda args: broken())
    monkeypatch.setattr(unforeseen.tempfile, "tempdir", str(tmp_path))
    assert app.done(["run", "it all", "--set=1"]) == 70
    file, = tmp_path.glob("ahv_error_*.txt")
    said = capsys.readouterr().err
    assert said == ("ahv: This is a mistake in ahv: KeyError: 'nobody foresaw it'. "
                    f"Please send us {file}, which tells where it happened.\n")
    text = file.read_text()
    assert text.startswith("ahv run 'it all' --set=1\nPython ") and "in broken\n" in text and "numpy " in text


def test_what_nobody_foresaw_is_a_sentence_where_no_file_can_be_written(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(app, "app", lambda args: 1 / 0)
    monkeypatch.setattr(unforeseen.tempfile, "tempdir", str(tmp_path / "nowhere"))
    assert app.done(["run"]) == 70
    said = capsys.readouterr().err
    assert "ZeroDivisionError: division by zero. A report of it could not be written: No such file" in said


def test_a_place_that_cannot_be_written_is_the_users(monkeypatch, tmp_path, capsys):
    (tmp_path / "file").touch()
    place = tmp_path / "file" / "x"
    monkeypatch.setattr(app, "app", lambda args: place.write_text(""))
    assert app.done(["ssp"]) == 2
    assert capsys.readouterr().err == f"ahv: {place}: Not a directory.\n"
