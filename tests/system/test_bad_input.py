"""Bad input: one sentence naming what and why, a non-zero exit, nothing flown."""
import json
import re
from math import inf, nan, radians

import pytest
from command import ahv, carried_out

from cosim.errors import RunError, UsageError
from cosim.vehicle.linearize import linearize
from cosim.vehicle.trim import beyond_limits, trim

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
    "linearize out of range": (["linearize", "--V", "0"], "plant.V_start = 0.0 is not allowed: it must be"),
    "linearize a word for a number": (["linearize", "--set", "plant.mass=heavy"], "it must be a number"),
}


@pytest.mark.parametrize("words,sentence", REFUSED.values(), ids=REFUSED)
def test_is_refused_before_the_run(words, sentence, tmp_path):
    said = ahv(*words, cwd=tmp_path, status=2)
    assert sentence in said
    assert len(said.strip().splitlines()) == 1
    assert not list(tmp_path.rglob("signals.*"))


@pytest.mark.parametrize("V,h,sentence", [
    (9000, 140000, "ahv: Level flight at V = 9000 ft/s, h = 140000 ft is beyond the vehicle's limits: it needs an "
                   "elevator of 95.15 deg (-20 to 20 deg is allowed)."),
    (15000, 50000, "needs a fuel ratio of"),
])
def test_a_trim_beyond_the_actuators_shows_its_numbers_and_fails(V, h, sentence):
    done = carried_out("trim", "--V", str(V), "--h", str(h), "--json")
    assert done.returncode == 1 and sentence in done.stderr and len(done.stderr.splitlines()) == 1
    assert json.loads(done.stdout)["V_fps"] == V


@pytest.mark.parametrize("V,h", [(5000, 120000), (5250, 127500)])
def test_a_trim_that_newton_does_not_find_is_no_trim(V, h, native_fmus):
    with pytest.raises(RunError, match=f"No level flight was found at V = {V} ft/s, h = {h} ft"):
        trim(V, h)


def test_a_trim_at_the_limits_is_allowed_and_just_beyond_is_not():
    limits = trim(7700, 85000) | {"elevator_deg": 20.0, "fuel_ratio": 0.05}
    assert beyond_limits(limits) == ""
    assert "an elevator of -20.01 deg" in beyond_limits(limits | {"elevator_deg": -20.01})
    assert "a fuel ratio of 0.0499 (0.05 to 1.5 is allowed)." in beyond_limits(limits | {"fuel_ratio": 0.0499})
    assert "1.501 (0.05 to 1.5 is allowed) and an elevator of 20.01 deg" in beyond_limits(
        limits | {"fuel_ratio": 1.501, "elevator_deg": 20.01})


@pytest.mark.parametrize("arguments,sentence", [
    ({"V": nan}, "plant.V_start = nan is not allowed: it must be between 5000 and 15000 ft/s."),
    ({"V": inf}, "plant.V_start = inf is not allowed"), ({"V": 4999.0}, "plant.V_start = 4999.0 is not allowed"),
    ({"h": 1e9}, "plant.h_start = 1000000000.0 is not allowed: it must be between 50000 and 150000 ft."),
    ({"V": 0.0, "plant": "instrumented"}, "plant.V_start = 0.0 is not allowed"),
    ({"step": 0.0}, "--step 0 is not allowed: it must be above 0 and at most 1 s."),
    ({"step": -0.01}, "--step -0.01 is not allowed"), ({"step": inf}, "--step inf is not allowed"),
    ({"step": nan}, "--step nan is not allowed"), ({"step": 100.0}, "--step 100 is not allowed"),
    ({"scale": 0.0}, "--scale 0 is not allowed: it must be a positive number."),
    ({"scale": nan}, "--scale nan is not allowed"), ({"scale": inf}, "--scale inf is not allowed"),
    ({"preset": "printd"}, "has no preset printd; it has calibrated"),
    ({"values": {"plant": {"mass": "-1"}}}, "plant.mass = -1 is not allowed: it must be between 0.3 and 300000"),
    ({"values": {"plant": {"mas": 300.0}}}, "has no variable mas; did you mean mass?"),
    ({"values": {"plant": {"elevator": 0.1}}}, "plant.elevator cannot be set here: controller.elevator gives it."),
    ({"values": {"plnt": {"mass": 300.0}}}, "There is no component plnt; there are controller, plant."),
    ({"values": {"controller": {"k_gamma": nan}}}, "controller.k_gamma = nan is not allowed"),
    ({"values": {"plant": {"V_start": 8000.0}}}, "plant.V_start cannot be set here: --V gives it."),
    ({"values": {"scenario": {"scale_lift_base": 2.0}}}, "scale_lift_base cannot be set here: --scale gives it."),
    ({"values": {"scenario": {"V_command_step": 8.0}}}, "V_command_step cannot be set here: the flight is level"),
], ids=str)
def test_what_cannot_be_linearised_is_refused(arguments, sentence, native_fmus):
    with pytest.raises(UsageError, match=re.escape(sentence)):
        linearize(**arguments)


def test_a_value_with_a_unit_linearises_as_the_same_value_without():
    one, other = (linearize(values={"controller": {"elevator_max": x}}) for x in ("15deg", radians(15)))
    assert one == other


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
    assert (tmp_path / "results" / "run" / "own" / "run.json").exists()
