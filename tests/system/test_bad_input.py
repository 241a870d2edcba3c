"""Bad input: one sentence naming what and why, a non-zero exit, nothing flown."""
import json

import pytest
from test_cases import ahv

REFUSED = {
    "a misspelt variable": (["run", "case1", "--set", "plant.V_sart=8000"], "V_sart; did you mean V_start?"),
    "a misspelt component": (["run", "case1", "--set", "plnt.V_start=8000"], "no component plnt; there are scenario"),
    "no assignment": (["run", "case1", "--set", "plant.V_start"], "not of the form COMPONENT.VARIABLE=VALUE"),
    "a value above its maximum": (["run", "case1", "--set", "plant.V_start=99999"],
                                  "plant.V_start = 99999 is not allowed: it must be between 5000 and 15000 ft/s"),
    "a value that is no number": (["run", "case1", "--set", "plant.mass=nan"], "plant.mass = nan is not allowed"),
    "a word for a number": (["run", "case1", "--set", "plant.mass=heavy"], "it must be a number"),
    "a number for a truth": (["run", "case1", "--set", "controller.solve_trim=maybe"], "it is true or false"),
    "an output": (["run", "case1", "--set", "plant.V=8000"], "plant.V is an output and cannot be set"),
    "a misspelt scenario": (["run", "caes1"], "Did you mean case1?"),
    "a misspelt preset": (["run", "case1", "--preset", "printd"], "no preset printd; it has calibrated"),
    "an unknown controller": (["run", "case1", "--controller", "pid"], "there are neural, resilient, backstepping"),
    "an unknown flavour": (["run", "case1", "--flavour", "java"], "there are python, native"),
    "an unknown algorithm": (["run", "case1", "--algorithm", "magic"], "there are "),
    "a step of nothing": (["run", "case1", "--step", "0"], "must be positive"),
    "a step that does not fit": (["run", "case1", "--step", "0.03"], "not a whole number of communication steps"),
    "a trim out of range": (["trim", "--V", "100"], "plant.V_start = 100.0 is not allowed"),
}


@pytest.mark.parametrize("words,sentence", REFUSED.values(), ids=REFUSED)
def test_is_refused_before_the_run(words, sentence, tmp_path):
    said = ahv(*words, cwd=tmp_path, status=2)
    assert sentence in said
    assert len(said.strip().splitlines()) == 1
    assert not list(tmp_path.rglob("signals.*"))


def test_an_output_folder_that_cannot_be_written_is_noticed_before_flying(tmp_path):
    (tmp_path / "file").write_text("in the way")
    said = ahv("run", "case1", "--out", tmp_path / "file" / "out", status=2)
    assert "cannot be written to" in said


@pytest.mark.parametrize("text,sentence", [
    ("name: x\nstop: -1\n", "own.yaml, line 2: stop: Input should be greater than 0, not -1."),
    ("name: x\nstop: 1\nsotp: 3\n", "own.yaml, line 3: sotp: there is no such field; did you mean stop?"),
    ("stop: 1\n", "own.yaml, line 1: name is missing."),
    ("name: x\nname: y\nstop: 1\n", "own.yaml, line 2: name is given twice."),
    ("name: [x\n", "is not YAML"),
    ("just words\n", "Input should be"),
    ("name: x\nstop: 1\nset: {plant.V_start: {}}\n", "line 3: set.plant.V_start"),
    ("name: x\nstop: 1\nset:\n  plant.V_sart: 8000\n", "line 4: set.plant.V_sart: AhvPlant.fmu has no variable"),
    ("name: x\nstop: 1\nset:\n  plant.V_start: 80\n", "line 4: set.plant.V_start: plant.V_start = 80.0 is not"),
    ("name: x\nstop: 1\nset:\n  plnt.V_start: 80\n", "line 4: set.plnt.V_start: There is no component plnt"),
    ("name: x\nstop: 1\npresets: {plant: glider}\n", "line 3: presets.plant: AhvPlant.fmu has no preset glider"),
])
def test_a_scenario_file_that_is_wrong_names_its_field(text, sentence, tmp_path):
    (tmp_path / "own.yaml").write_text(text)
    assert sentence in ahv("run", tmp_path / "own.yaml", cwd=tmp_path, status=2)


def test_a_scenario_file_flies(tmp_path):
    (tmp_path / "own.yaml").write_text("name: own\nstop: 2\npresets: {scenario: hold}\n"
                                       "set: {plant.V_start: 8000, scenario.V_command_base: 8000}\n")
    found = json.loads(ahv("run", tmp_path / "own.yaml", "--json", cwd=tmp_path))
    assert found["scenario"] == "own" and found["finished"]
    assert found["altitude_error_ft"]["max_abs"] < 1e-3  # it starts in trim and stays there
    assert (tmp_path / "results" / "own" / "run.json").exists()
