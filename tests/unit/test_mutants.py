"""The points that `make mutants` finds, in Python and in C; and the list of judged mutants is that of this tree."""
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from mutants.points import mutants
from mutants.rooms import INSIDE, ROOMS
from places import ROOT

JUDGED = yaml.safe_load((ROOT / "tests" / "mutants" / "judged.yaml").read_text()) or []

PYTHON = '''"""A module - with a text."""
LIMIT = 3


def clipped(value: int | None, low=0.5):
    if value is None or value < low:
        raise ValueError(f"{value - 1} is below {low}")
    self.seen = min(value, LIMIT)
    return not -value
'''
C = '''#define N 10 /* 1 < 2 */
static int clipped(const Instance *i, int value)
{
    const char *text = "a < b";
    if (value < N && value != 0)
        return 1;
    note(i, "c == d");
    while (!value--)
        value += 2e-3 * N;
    return value;
}
'''


def found(folder: Path, name: str, text: str) -> set[tuple[str, str, str]]:
    (folder / name).write_text(text)
    return {mutant.key[1:] for mutant in mutants(folder, name)}


def test_points_of_python(tmp_path):
    test, keep, back = "if value is None or value < low:", "self.seen = min(value, LIMIT)", "return not -value"
    signature = "def clipped(value: int | None, low=0.5):"
    assert found(tmp_path, "a.py", PYTHON) == {
        ("", "LIMIT = 3", "LIMIT = 4"), ("", "LIMIT = 3", "LIMIT = 2"),
        ("clipped", signature, "def clipped(value: int | None, low=0.625):"),
        ("clipped", test, "if value is not None or value < low:"),
        ("clipped", test, "if value is None and value < low:"),
        ("clipped", test, "if value is None or value <= low:"), ("clipped", test, "if value is None or value >= low:"),
        ("clipped", test, "if (not (value is None or value < low)):"),
        ("clipped", 'raise ValueError(f"{value - 1} is below {low}")', "pass"),
        ("clipped", keep, "self.seen = max(value, LIMIT)"), ("clipped", keep, "pass"),
        ("clipped", back, "return -value"), ("clipped", back, "return not value"), ("clipped", back, "return None")}


def test_points_of_c(tmp_path):
    test, step = "if (value < N && value != 0)", "value += 2e-3 * N;"
    assert found(tmp_path, "a.c", C) == {
        ("clipped", test, "if (value <= N && value != 0)"), ("clipped", test, "if (value >= N && value != 0)"),
        ("clipped", test, "if (value < N || value != 0)"), ("clipped", test, "if (value < N && value == 0)"),
        ("clipped", test, "if (value < N && value != 1)"), ("clipped", test, "if (!(value < N && value != 0))"),
        ("clipped", f"{test} return 1;", ";"), ("clipped", "return 1;", "return 0;"),
        ("clipped", 'note(i, "c == d");', ";"),
        ("clipped", "while (!value--)", "while (value--)"), ("clipped", "while (!value--)", "while (!(!value--))"),
        ("clipped", f"while (!value--) {step}", ";"),
        ("clipped", step, "value -= 2e-3 * N;"), ("clipped", step, "value += 0.0025 * N;"),
        ("clipped", step, "value += 2e-3 / N;"), ("clipped", step, ";")}


@pytest.mark.parametrize("name,text", [("a.py", PYTHON), ("a.c", C)])
def test_a_mutant_is_the_same_one_when_lines_move(tmp_path, name, text):
    moved = f"# more\n\n{text}" if name == "a.py" else f"/* more */\n\n{text}"
    assert found(tmp_path, name, text) == found(tmp_path, name, moved)


def test_mutants_on_equal_lines_have_numbers(tmp_path):
    line, after = "x = 1.0", "x = 1.25"
    assert found(tmp_path, "a.py", f"{line}\n{line}\n") == {("", line, after), ("", line, f"{after}  #2")}


def test_every_judged_mutant_is_one_of_this_tree_and_has_a_reason():
    keys = {mutant.key for file in {judged["file"] for judged in JUDGED} for mutant in mutants(ROOT, file)}
    for judged in JUDGED:
        assert tuple(judged[name] for name in ("file", "function", "from", "to")) in keys, judged
        assert len(judged["reason"]) > 20, judged


def test_rooms_name_tests_of_this_tree():
    stages = [stage for rows in ROOMS.values() for _, found in rows for stage in found or ()]
    named = {name for stage in stages for name in stage.removeprefix("platforms ").partition(" -k ")[0].split()}
    assert [name for name in sorted(named) if not (ROOT / "tests" / f"{name}.py").is_file()] == []


@pytest.mark.slow
def test_the_campaigns_that_trials_fly_pass_where_nothing_is_changed():
    name, _, chosen = INSIDE.partition(" -k ")
    words = [sys.executable, "-m", "pytest", "-q", ROOT / "tests" / f"{name}.py", "-k", chosen]
    subprocess.run(words, cwd=ROOT, check=True)
