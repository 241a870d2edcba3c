"""What can be said of a run: whose value wins, values with units, starts that commands follow, names of figures."""
import json

import pytest
from command import ahv

from cosim.errors import UsageError
from cosim.pictures import Format
from cosim.vehicle import scenarios
from cosim.vehicle.closed_loop import assignments, closed_loop
from cosim.vehicle.linearize import linearize
from cosim.vehicle.run import run
from cosim.vehicle.scenarios import Scenario


def recorded(tmp_path, scenario, *words, preset=None):
    """run.json of a second of `scenario`, flown with --set `words`."""
    run(str(scenario), preset=preset, values=assignments(words), stop=1.0, out=tmp_path / "out")
    return json.loads((tmp_path / "out" / "run.json").read_text())


def scenario_values(loop):
    return loop.system.components[0].values


@pytest.mark.parametrize("said,in_file,expected,origin", [
    (None, None, "calibrated", "default"),
    (None, "steady", "steady", "scenario"),
    ("robust", "steady", "robust", "command line"),
])
def test_the_command_line_wins_over_the_scenario_and_that_over_the_default(said, in_file, expected, origin, tmp_path):
    presets = f"presets: {{controller: {in_file}}}\n" if in_file else ""
    (tmp_path / "own.yaml").write_text(f"name: own\nstop: 1\n{presets}")
    record = recorded(tmp_path, tmp_path / "own.yaml", preset=said)
    assert record["preset"] == expected
    assert record["presets"]["controller"] == {"name": expected, "from": origin}


def test_a_scenario_that_says_nothing_holds_and_its_figures_have_plain_names(tmp_path):
    (tmp_path / "own.yaml").write_text("name: own\nstop: 1\n")
    record = recorded(tmp_path, tmp_path / "own.yaml")
    assert record["altitude_error_ft"]["max_abs"] < 1e-6
    assert {p.name for p in (tmp_path / "out" / "figures").iterdir()} >= {"velocity.png", "altitude.png", "inputs.png"}


def test_commands_follow_the_start_unless_they_are_set():
    start = {"plant": {"V_start": 9000.0, "h_start": 90000.0}}
    held = scenario_values(closed_loop(scenarios.load("hold"), values=start))
    assert (held["V_command_base"], held["h_command_base"]) == (9000.0, 90000.0)
    both = {**start, "scenario": {"V_command_base": 9100.0}}
    assert scenario_values(closed_loop(scenarios.load("hold"), values=both))["V_command_base"] == 9100.0


def test_hold_at_another_speed_holds_there(tmp_path):
    record = recorded(tmp_path, "hold", "plant.V_start=9000")
    assert record["velocity_error_fps"]["max_abs"] < 1e-6


@pytest.mark.parametrize("word,expected", [("2deg", 0.034906585039886591), ("2 deg", 0.034906585039886591),
                                           ("0.02 rad", 0.02), ("-1.5e-1deg", -0.0026179938779914941), ("0.02", 0.02),
                                           ("2e-2", 0.02), ("2e-2rad", 0.02)])
def test_a_value_may_have_a_unit(word, expected, tmp_path):
    record = recorded(tmp_path, "hold", "plant.start_at_trim=false", f"plant.theta_start={word}")
    assert record["parameters"]["plant"]["theta_start"] == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize("word,sentence", [
    ("plant.theta_start=2m", "plant.theta_start = 2m is not allowed: its unit is one of rad, deg."),
    ("plant.V_start=9000 km/h", "plant.V_start = 9000 km/h is not allowed: its unit is one of ft/s."),
    ("plant.V_start=nan", "plant.V_start = nan is not allowed"),
])
def test_a_unit_that_does_not_fit_is_refused(word, sentence, tmp_path):
    assert sentence in ahv("run", "hold", "--set", word, cwd=tmp_path, status=2)


def test_uncertainty_is_the_amplitude_of_what_swings():
    values = scenario_values(closed_loop(scenarios.load("case2"), uncertainty=0.5))
    assert {values[f"scale_{group}_sine"] for group in ("thrust", "lift", "drag", "moment", "forces")} == {0.5}
    assert values["V_command_sine"] == 0.0
    with pytest.raises(UsageError, match="no coefficient of hold changes"):
        closed_loop(scenarios.load("hold"), uncertainty=0.5)


def test_a_scenario_can_be_made_in_python():
    loop = closed_loop(Scenario(name="own", stop=5, presets={"plant": "estimated-coupling"}), controller="backstepping")
    assert loop.presets == {"scenario": "hold", "controller": "calibrated", "plant": "estimated-coupling"}
    assert loop.preset_from["plant"] == "scenario"


@pytest.mark.parametrize("word,lines", [
    ("controller", ["presets: calibrated, coupled, independent, printed, robust, steady", "k_gamma",
                    "measured pitch rate"]),
    ("backstepping", ["AhvBackstepping"]),
    ("plant", ["theta_start", "initial pitch angle, if not at trim"]),
    ("case2", ["stop: 300 s", "scenario.V_command_step_count"]),
])
def test_info_shows_what_can_be_set(word, lines):
    found = ahv("info", word)
    assert all(line in found for line in lines)


def test_info_of_a_word_that_is_nothing_suggests_one():
    assert "did you mean plant?" in ahv("info", "plnt", status=2)


def test_a_scenario_s_preset_that_the_command_line_replaces_need_not_be_one_of_this_law():
    steady = Scenario(name="own", stop=5, presets={"controller": "steady"})
    assert closed_loop(steady, "backstepping", presets={"controller": "calibrated"}).preset == "calibrated"
    with pytest.raises(UsageError, match=r"AhvBackstepping\.fmu has no preset steady"):
        closed_loop(steady, "backstepping")


@pytest.mark.parametrize("words, sentence", [
    (("controller.elevator_min=10deg", "controller.elevator_max=5deg"),
     "controller.elevator_min = 10deg is not allowed: it is above controller.elevator_max = 5deg."),
    (("controller.fuel_ratio_min=2",), "controller.fuel_ratio_min = 2 is not allowed: it is above "
                                       "controller.fuel_ratio_max = 1.5."),
])
def test_a_lower_limit_above_its_upper_limit_is_refused(words, sentence):
    hold = scenarios.load("hold")
    for refused in (lambda: closed_loop(hold, values=assignments(words)), lambda: linearize(values=assignments(words))):
        with pytest.raises(UsageError) as error:
            refused()
        assert str(error.value) == sentence


def test_limits_that_meet_are_flown():
    closed_loop(scenarios.load("hold"), values=assignments(["controller.elevator_min=5deg",
                                                            "controller.elevator_max=5deg"]))


def test_limits_are_no_matter_for_a_controller_that_has_none(native_fmus):
    with pytest.raises(UsageError, match=r"AhvScenario\.fmu\) has no output fuel_ratio, which the closed loop needs"):
        closed_loop(scenarios.load("hold"), f"mine={native_fmus['AhvScenario']}",
                    values=assignments(["controller.elevator_min=1deg"]))


def test_figures_are_written_in_the_format_that_is_asked_for(tmp_path):
    run("case1", stop=0.1, out=tmp_path / "out", form=Format("svg", 1))
    found = {path.name for path in (tmp_path / "out" / "figures").iterdir()}
    assert {"figure_02_velocity.svg", "figure_07_phi_hat.svg", "coefficients.svg"} <= found
    assert {path.rpartition(".")[2] for path in found} == {"svg"}


def test_another_format_is_refused_before_the_flight(tmp_path):
    said = ahv("run", "case1", "--figures", "gif", "--out", tmp_path / "out", status=2)
    assert "--figures gif: pictures are written as png, pdf or svg." in said
    assert not (tmp_path / "out").exists()
