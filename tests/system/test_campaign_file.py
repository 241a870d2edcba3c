"""A campaign file that is wrong: one sentence with line and field, before anything runs."""
import pytest
import yaml
from campaigns import load
from places import ROOT

from cosim.campaign.store import Store
from cosim.errors import UsageError

GOOD = """\
name: small
scenario: case1
stop: 1
runs: 8
seed: 3
dispersions:
  plant.mass: {distribution: normal, mean: 300, std: 10, low: 270, high: 330}
  scenario.scale_lift:
    distribution: sinusoid
    amplitude: {distribution: uniform, low: 0, high: 0.4}
    period: 40
success:
  altitude: altitude_error_ft.max_abs < 20
"""

WRONG = {
    "no YAML": ("runs: 8", "runs: [8", "line 5: this is not YAML: expected ',' or ']'"),
    "a missing field": ("seed: 3\n", "", "line 1: seed is missing"),
    "a misspelt field": ("seed: 3", "sede: 3", "line 5: sede: there is no such field; did you mean seed?"),
    "a field too many": ("seed: 3", "seed: 3\ncolour: red", "line 6: colour: there is no such field"),
    "a key twice": ("seed: 3", "seed: 3\nruns: 9", "line 6: runs is given twice"),
    "no runs": ("runs: 8", "runs: 0", "line 4: runs: Input should be greater than or equal to 1, not 0"),
    "a word for a number": ("seed: 3", "seed: three", "line 5: seed: Input should be a valid integer, not 'three'"),
    "half a seed": ("seed: 3", "seed: 1.5", "line 5: seed: Input should be a valid integer, not 1.5"),
    "a truth for a seed": ("seed: 3", "seed: true", "line 5: seed: Input should be a valid integer, not True"),
    "a letter for a seed": ("seed: 3", 'seed: "a"', "line 5: seed: Input should be a valid integer, not 'a'"),
    "a seed below 0": ("seed: 3", "seed: -1", "line 5: seed: Input should be greater than or equal to 0, not -1"),
    "a seed too large": ("seed: 3", "seed: 1.0e+30", "line 5: seed: Input should be a valid integer, not 1e+30"),
    "a seed too long": ("seed: 3", f"seed: {2**63}", f"line 5: seed: Input should be less than {2**63}, not {2**63}"),
    "half a run": ("runs: 8", "runs: 8.5", "line 4: runs: Input should be a valid integer, not 8.5"),
    "truly runs": ("runs: 8", "runs: true", "line 4: runs: Input should be a valid integer, not True"),
    "an unknown scenario": ("case1", "caes1", "line 2: scenario: caes1 is neither a scenario"),
    "an unknown law": ("seed: 3",
                       "seed: 3\ncontrollers: [pid]", "line 6: controllers.0: --controller pid is not known"),
    "one law twice": ("seed: 3", "seed: 3\ncontrollers: [neural, neural]", "two controllers are called neural"),
    "an unknown preset": ("seed: 3",
                          "seed: 3\ncontrollers:\n- {law: neural, preset: x}", "line 7: controllers.0: AhvCon"),
    "an unknown flavour": ("seed: 3",
                           "seed: 3\nflavour: java", "line 6: flavour: there is no java; there are python, na"),
    "an unknown plant": ("seed: 3", "seed: 3\nplant: glider", "line 6: plant: there is no glider; there are ideal"),
    "an unknown sampling": ("seed: 3", "seed: 3\nsampling: magic", "line 6: sampling: Input should be 'random'"),
    "an unknown algorithm": ("seed: 3", "seed: 3\nalgorithm: magic", "line 6: algorithm: --algorithm magic"),
    "a stop that does not fit": ("stop: 1", "stop: 1.005", "line 3: stop: --stop 1.005 s is not a whole number"),
    "a value that is not allowed": ("seed: 3",
                                    "seed: 3\nset: {plant.mass: -1}", "line 6: set.plant.mass: plant.mass = -1"),
    "a variable that is not there": ("plant.mass:",
                                     "plant.maas:", "line 7: dispersions.plant.maas: AhvPlant.fmu has no "
                                     "variable maas; did you mean mass?"),
    "a component that is not there": ("plant.mass:", "plnt.mass:", "There is no component plnt"),
    "an output": ("plant.mass:", "plant.V:", "plant.V is an output and cannot be set"),
    "an unknown distribution": ("distribution: normal",
                                "distribution: gauss", "line 7: dispersions.plant.mass: there is no distribution gau"),
    "no distribution": ("distribution: normal, ", "", "line 7: dispersions.plant.mass: distribution is missing"),
    "a negative spread": ("std: 10", "std: -10", "line 7: dispersions.plant.mass.std: Input should be greater than 0"),
    "ends the wrong way round": ("low: 270", "low: 370", "line 7: dispersions.plant.mass: low must be below high"),
    "an end that is not allowed": ("low: 270, high: 330", "low: 270, high: 1e9", "plant.mass = "),
    "half an end of whole numbers": ("distribution: normal, mean: 300, std: 10, low: 270, high: 330",
                                     "distribution: integer, low: 270, high: 330.5",
                                     "line 7: dispersions.plant.mass.high: Input should be a valid integer, not 330.5"),
    "whole numbers the wrong way round": ("distribution: normal, mean: 300, std: 10, low: 270, high: 330",
                                          "distribution: integer, low: 330, high: 330", "low must be below high"),
    "weights without a sum": ("distribution: normal, mean: 300, std: 10, low: 270, high: 330",
                              "distribution: choice, values: [290, 300], weights: [1.0e308, 1.0e308]",
                              "line 7: dispersions.plant.mass: weights must be one for each of values, with a finite"),
    "a wave on no signal": ("scenario.scale_lift:",
                            "plant.chord:", "line 8: dispersions.plant.chord: plant.chord is no signal"),
    "a period of nothing": ("period: 40",
                            "period: {distribution: uniform, low: 0, high: 1}", "a period must be above 0"),
    "a period of next to nothing": ("period: 40", "period: {distribution: uniform, low: 1.0e-320, high: 1}",
                                    "a period must be above 0"),
    "a variable drawn twice": ("success:",
                               "  scenario.scale_lift_sine: {distribution: uniform, low: 0, high: 1}\nsuccess:",
                               "line 12: dispersions.scenario.scale_lift_sine: scenario.scale_lift_sine is set by"),
    "correlation with nothing": ("success:", "correlations:\n- {draws: [plant.mass, plant.chord], coefficient: 0.5}\n"
                                 "success:", "line 13: correlations.0: plant.chord is not drawn"),
    "correlation that cannot be": ("success:",
                                   "correlations:\n- draws: [plant.mass, scenario.scale_lift_sine]\n  matrix: "
                                   "[[1, 2], [2, 1]]\nsuccess:", "line 13: correlations.0: nothing can be correlated"),
    "correlation of nothing in particular": ("success:", "correlations:\n"
                                             "- draws: [plant.mass, scenario.scale_lift_sine]\nsuccess:",
                                             "line 13: correlations.0: either coefficient or matrix"),
    "correlation with itself": ("success:", "correlations:\n- {draws: [plant.mass, plant.mass], coefficient: 0.5}\n"
                                "success:", "line 13: correlations.0: draws must differ"),
    "correlation of one draw twice": ("success:", "correlations:\n"
                                      "- {draws: [plant.mass, scenario.scale_lift_sine], coefficient: 0.5}\n"
                                      "- {draws: [scenario.scale_lift_sine_phase, plant.mass], coefficient: 0.5}\n"
                                      "success:", "line 14: correlations.1: plant.mass is in two correlated groups"),
    "correlation of a choice": ("success:", "  plant.chord: {distribution: choice, values: [16, 18]}\ncorrelations:\n"
                                "- {draws: [plant.chord, plant.mass], coefficient: 0.5}\nsuccess:",
                                "line 14: correlations.0: plant.chord is a choice and has no order to correlate by"),
    "words times something": ("distribution: normal, mean: 300, std: 10, low: 270, high: 330",
                              "distribution: choice, values: [a, b], relative: true",
                              "line 7: dispersions.plant.mass: relative needs values that are numbers"),
    "a metric that is not there": ("altitude_error_ft.max_abs",
                                   "altitude_eror", "line 13: success.altitude: 'altitude_ero"),
    "a maximum of one": ("altitude_error_ft.max_abs <", "max(altitude_error_ft.max_abs) <",
                         "line 13: success.altitude: 'max(altitude_error_ft.max_abs) < 20': max takes two numbers"),
    "an absolute value of two": ("altitude_error_ft.max_abs <", "abs(altitude_error_ft.max_abs, 1) <",
                                 "line 13: success.altitude: 'abs(altitude_error_ft.max_abs, 1) < 20': abs takes one"),
    "a great many signs": ("altitude_error_ft.max_abs", f"{'-' * 970}1", "nested more than 100 levels deep"),
    "a criterion that is none": ("altitude_error_ft.max_abs < 20", "elevator_deg.max", "is neither true nor false"),
    "code": ("altitude_error_ft.max_abs < 20", "__import__('os').getcwd() < 3", "is not allowed in an expression"),
    "signals that are not there": ("seed: 3",
                                   "seed: 3\nsignals: {record: [plant.zeal]}", "line 6: signals.record: plant.zeal"),
    "itself": ("seed: 3", "seed: 3\nset: &a {b: *a}", "line 6: set.b: it contains itself"),
}


def plan(text, tmp_path):
    (tmp_path / "campaign.yaml").write_text(text)
    return load(tmp_path / "campaign.yaml")


@pytest.mark.parametrize("before,after,sentence", WRONG.values(), ids=WRONG)
def test_a_wrong_file_is_refused_with_line_and_field(before, after, sentence, tmp_path):
    assert before in GOOD
    with pytest.raises(UsageError) as error:
        plan(GOOD.replace(before, after), tmp_path)
    assert sentence in str(error.value) and str(tmp_path / "campaign.yaml") in str(error.value)
    assert len(str(error.value).splitlines()) == 1


@pytest.mark.parametrize("text", ["", "- 1\n", "words", "\x00", "5", "? [a]\n: 1\n"])
def test_what_is_no_campaign_at_all_is_refused_too(text, tmp_path):
    with pytest.raises(UsageError, match=r"campaign\.yaml"):
        plan(text, tmp_path)


def test_a_relative_draw_multiplies_the_value_that_would_fly(tmp_path):
    text = GOOD.replace("distribution: normal, mean: 300, std: 10, low: 270, high: 330",
                        "distribution: uniform, low: 0.5, high: 1.5, relative: true")
    assert text != GOOD
    assert plan(text, tmp_path).draws["neural"][0].factor == 300.0
    assert plan(f"{text}set: {{plant.mass: 290}}\n", tmp_path).draws["neural"][0].factor == 290.0


@pytest.mark.parametrize("text", ["seed: 0", f"seed: {2**63 - 1}", "seed: 0x10"])
def test_seeds_are_all_whole_numbers_of_63_bits(text, tmp_path):
    assert plan(GOOD.replace("seed: 3", text), tmp_path).campaign.seed == int(text.partition(" ")[2], 0)


def test_files_are_named_from_the_campaign_file_wherever_it_is_read_from(tmp_path, monkeypatch):
    from cosim.campaign.rerun import command

    there, here = tmp_path / "there", tmp_path / "here"
    (there / "fmus").mkdir(parents=True)
    here.mkdir()
    monkeypatch.chdir(here)
    (there / "own.yaml").write_text("name: own\nstop: 2\n")
    for name in ("AhvPlant", "AhvController"):
        (there / "fmus" / f"{name}.fmu").write_bytes((ROOT / "fmus" / "dist" / "native" / f"{name}.fmu").read_bytes())
    text = GOOD.replace("scenario: case1\nstop: 1", "scenario: own.yaml\nplant: fmus/AhvPlant.fmu\n"
                        "controllers: [mine=fmus/AhvController.fmu]")
    found = plan(text, there)
    assert found.stop == 2 and found.subject.name == "own" and found.subject.word == str(there / "own.yaml")
    assert {path.parent for stored, path in found.fmus.items() if "Scenario" not in stored} == {there / "fmus"}
    row = {"run": 7, "controller": "mine", "plant.mass": 300.0, "scenario.scale_lift_sine": 0.1,
           "scenario.scale_lift_sine_phase": 1.0}
    words = command(found, row).split()
    assert words[2] == str(there / "own.yaml")
    assert words[words.index("--out") + 1] == f"results/run/{found.campaign.name}-mine-7"
    assert words[words.index("--plant") + 1] == str(there / "fmus" / "AhvPlant.fmu")
    assert words[words.index("--controller") + 1] == f"mine={there / 'fmus' / 'AhvController.fmu'}"
    assert "scenario.scale_lift_sine=0.1" in words and plan(GOOD, there).subject.word == "case1"


def test_what_is_said_of_a_law_wins_over_what_is_said_of_all(tmp_path):
    found = plan(GOOD.replace("seed: 3", "seed: 3\nset: {plant.chord: 16, controller.elevator_max: 0.3}\n"
                              "presets: {controller: robust}\ncontrollers:\n- neural\n"
                              "- {law: neural, name: other, preset: calibrated, set: {plant.chord: 18}}"), tmp_path)
    chord = {law: float(c.values["chord"]) for law, loop in found.subject.loops.items() for c in loop.system.components
             if c.name == "plant"}
    assert chord == {"neural": 16, "other": 18}
    assert {law: loop.presets["controller"] for law, loop in found.subject.loops.items()} == {
        "neural": "robust", "other": "calibrated"}


def test_the_tasks_hold_all_runs_once_and_the_file_s_stop_wins(tmp_path):
    found = plan(GOOD.replace("runs: 8", "runs: 41\nruns_per_task: 20"), tmp_path)
    assert list(Store(tmp_path, found).missing()) == [(0, 20), (20, 40), (40, 41)]
    assert found.stop == 1 and found.job.ticks == 100
    assert plan(GOOD.replace("runs: 8", "runs: 41"), tmp_path).runs_per_task == 3           # a 16th, rounded up
    assert plan(GOOD.replace("runs: 8", "runs: 99999"), tmp_path).runs_per_task == 200
    assert plan(GOOD.replace("runs: 8", "runs: 99999\nflavour: python"), tmp_path).runs_per_task == 40


@pytest.mark.parametrize("sampling,grows", [("random", True), ("sobol", True), ("latin-hypercube", False)])
def test_the_number_of_runs_is_in_the_key_where_the_draws_depend_on_it(sampling, grows, tmp_path):
    few, more = (plan(GOOD.replace("runs: 8", f"runs: {runs}\nsampling: {sampling}"), tmp_path) for runs in (8, 800))
    assert (few.job.key == more.job.key) is grows and few.described != more.described
    assert few.runs_per_task != more.runs_per_task


def test_what_determines_the_rows_is_in_the_fingerprint(tmp_path):
    one = plan(GOOD, tmp_path)
    for before, after in (("seed: 3", "seed: 4"), ("std: 10", "std: 11"), ("< 20", "< 21"), ("stop: 1", "stop: 2"),
                          ("seed: 3", "seed: 3\nstop_when: {half_width: 0.1}")):
        assert plan(GOOD.replace(before, after), tmp_path).job.key != one.job.key
    other = plan(GOOD.replace("name: small", "name: other\nworst_by: protected_s"), tmp_path)
    assert other.job.key == one.job.key
    assert (other.worst_by, one.worst_by) == ("protected_s", "altitude_error_ft.max_abs")


EXAMPLES = ROOT / "docs" / "campaigns"


@pytest.mark.parametrize("file", sorted(EXAMPLES.glob("*.yaml")), ids=lambda file: file.stem)
def test_the_examples_fit_the_fmus(file):
    assert load(file).laws


def test_constants_of_a_wave_are_set_and_the_rest_is_drawn(tmp_path):
    found = plan(GOOD.replace("period: 40", "period: 30"), tmp_path)  # case1 has 40 of its own
    assert [d.name for d in found.draws["neural"]] == [
        "plant.mass", "scenario.scale_lift_sine", "scenario.scale_lift_sine_phase"]
    scenario = found.job.systems["neural"].components[0]
    assert scenario.values["scale_lift_sine_omega"] == pytest.approx(0.20943951)


def test_a_signal_stands_for_its_base_and_a_relative_draw_multiplies_the_nominal_value(tmp_path):
    data = yaml.safe_load(GOOD)
    data["set"] = {"plant.mass": 200}
    data["dispersions"] = {
        "scenario.h_command": {"distribution": "choice", "values": [80000, 90000], "also": ["plant.h_start"]},
        "plant.mass": {"distribution": "uniform", "low": 0.9, "high": 1.1, "relative": True}}
    command, mass = plan(yaml.dump(data, sort_keys=False), tmp_path).draws["neural"]
    assert command.targets == ("scenario.h_command_base", "plant.h_start")
    assert mass.extremes() == [180.0, pytest.approx(220.0)]
