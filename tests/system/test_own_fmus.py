"""Anybody's controller and plant in the commands, by file name: docs/examples, built by stock pythonfmu."""
import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
from altered import redescribed
from command import ahv, carried_out

from cosim.errors import UsageError
from cosim.vehicle import scenarios
from cosim.vehicle.closed_loop import closed_loop

EXAMPLES = Path(__file__).parents[2] / "docs" / "examples"
LACKING = """
from pythonfmu import Fmi2Causality, Fmi2Slave, Real
class {name}(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        for name in {inputs}:
            setattr(self, name, 0.0)
            self.register_variable(Real(name, causality=Fmi2Causality.input))
        for name in {outputs}:
            setattr(self, name, 0.2)
            self.register_variable(Real(name, causality=Fmi2Causality.output))
    def do_step(self, current_time, step_size):
        return True
"""


def built(source: Path, folder: Path) -> Path:
    subprocess.run([sys.executable, "-m", "pythonfmu", "build", "-f", source, "-d", folder], check=True,
                   capture_output=True)
    return next(folder.glob("*.fmu"))


@pytest.fixture(scope="module")
def own(tmp_path_factory):
    """pid and plant, of docs/examples."""
    return {name: built(EXAMPLES / f"{source}.py", tmp_path_factory.mktemp(name))
            for name, source in (("pid", "pid"), ("plant", "rigid_plant"))}


def lacking(tmp_path, inputs, outputs, name="Strange"):
    (tmp_path / "strange.py").write_text(LACKING.format(name=name, inputs=inputs, outputs=outputs))
    return built(tmp_path / "strange.py", tmp_path)


def test_a_controller_of_ones_own_flies_case_1_and_has_no_preset(own, tmp_path):
    found = json.loads(ahv("run", "case1", "--controller", f"pid={own['pid']}", "--json", "--out", tmp_path / "out"))
    assert found["controller"] == "pid" and found["preset"] is None and found["finished"]
    assert found["altitude_error_ft"]["max_abs"] < 25
    assert (tmp_path / "out" / "figures" / "figure_03_altitude.png").exists()


def test_a_plant_of_ones_own_flies_as_ours_does(own, tmp_path):
    mine, ours = (json.loads(ahv("run", "case1", "--stop", 20, *words, "--json", "--out", tmp_path / "out"))
                  for words in (("--plant", own["plant"]), ()))
    assert mine["altitude_error_ft"]["max_abs"] == pytest.approx(ours["altitude_error_ft"]["max_abs"], abs=0.01)


def test_compare_has_a_column_of_the_name_given(own, tmp_path):
    found = json.loads(ahv("compare", "case1", "--controller", "backstepping", "--controller", f"mine={own['pid']}",
                           "--plant", own["plant"], "--stop", 5, "--json", "--out", tmp_path / "out"))
    assert list(found["controllers"]) == ["backstepping", "mine"]
    assert found["controllers"]["mine"]["cost_per_step_us"] > 0
    assert "mine" in found["verdict"] or "backstepping" in found["verdict"]


def test_linearize_finds_margins_of_a_strangers_loop(own):
    found = json.loads(ahv("linearize", "--controller", f"pid={own['pid']}", "--json"))
    assert found["closed_loop"]["stable"] and found["elevator_deg"] == pytest.approx(12.511, abs=0.01)
    assert 10 < found["margins"]["elevator"]["phase_deg"] < 30


def test_a_strangers_plant_linearises_as_ours(own):
    mine, ours = (json.loads(ahv("linearize", *words, "--json")) for words in (("--plant", own["plant"]), ()))
    for place in ("fuel_ratio", "elevator", "gamma", "Q"):
        assert mine["margins"][place]["phase_deg"] == pytest.approx(ours["margins"][place]["phase_deg"], rel=1e-3)


def test_a_campaign_flies_a_strangers_controller_and_its_report_names_the_file(own, tmp_path):
    (tmp_path / "own.yaml").write_text(
        f"name: own\nscenario: case1\nstop: 5\ncontrollers: [neural, 'pid={own['pid']}']\nruns: 4\nseed: 1\n"
        "dispersions:\n  plant.mass: {distribution: uniform, low: 290, high: 310}\n"
        "success: {altitude: altitude_error_ft.max_abs < 50}\n")
    found = json.loads(ahv("campaign", tmp_path / "own.yaml", "--out", tmp_path / "out", "--workers", 1, "--json"))
    assert found["controllers"]["pid"]["successes"] == 4
    assert f"--controller pid={own['pid']}" in (tmp_path / "out" / "report.html").read_text()


def test_an_optional_input_that_is_missing_is_noted_and_the_loop_flies(tmp_path):
    path = lacking(tmp_path, ["V", "h"], ["fuel_ratio", "elevator"])
    done = carried_out("run", "hold", "--stop", "0.1", "--controller", f"it={path}", "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    assert "controller (Strange.fmu) has no input V_command, h_command, gamma, theta, Q: not connected." in done.stderr


@pytest.mark.parametrize("words,inputs,outputs,sentence", [
    ("controller", ["V"], ["fuel_ratio"], "controller (Strange.fmu) has no output elevator, which the closed loop"),
    ("plant", ["elevator"], ["V", "h", "gamma", "theta", "Q"], "plant (Strange.fmu) has no input fuel_ratio, which"),
    ("plant", ["elevator", "fuel_ratio"], ["V", "h"], "plant (Strange.fmu) has no output gamma, which"),
])
def test_a_port_that_is_missing_is_named(words, inputs, outputs, sentence, tmp_path):
    path = lacking(tmp_path, inputs, outputs)
    assert sentence in ahv("run", "hold", f"--{words}", path, status=2)


@pytest.mark.parametrize("swap,sentence", [
    (('unit="ft" nominal="1000.0" start="85000.0"', 'unit="m" nominal="1000.0" start="85000.0"'),
     "has h_command in m; the closed loop has it in ft."),
    (('<BaseUnit m="1" factor="0.3048" />', '<BaseUnit m="1" />'),
     "in ft (1 m1); the closed loop has it in ft (0.3048 m1)."),
])
def test_a_port_in_another_unit_is_named(swap, sentence, native_fmus, tmp_path):
    path = redescribed(native_fmus["AhvBackstepping"], tmp_path / "Metric.fmu", swap,
                       ("<UnitDefinitions>", '<UnitDefinitions><Unit name="m"><BaseUnit m="1"/></Unit>'))
    with pytest.raises(UsageError, match=rf"^controller \(Metric\.fmu\) .*{re.escape(sentence)}$"):
        closed_loop(scenarios.load("hold"), f"metric={path}")


def test_a_file_that_is_none_is_named():
    assert "There is no FMU at nothing.fmu" in ahv("run", "hold", "--controller", "mine=nothing.fmu", status=2)
