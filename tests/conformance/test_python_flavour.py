"""The FMU files of the Python flavour, each alone."""
import subprocess
import sys
from shutil import copyfile, copytree

import numpy as np
import pytest
from flying import look_on, running, step
from fmpy.validation import validate_fmu
from places import ROOT

from cosim.errors import RunError
from cosim.vehicle.registry import MODELS
from fmus.builder import build


@pytest.fixture(params=sorted(MODELS))
def fmu(request, python_fmus):
    return python_fmus[request.param]


def outputs(instance):
    return instance.get(instance.file.names("output"))


def test_fmpy_finds_nothing_wrong(fmu):
    assert validate_fmu(str(fmu)) == []


def test_two_builds_of_the_same_source_are_byte_identical(fmu, tmp_path):
    again = subprocess.run(
        [sys.executable, "-c", "import sys; from pathlib import Path; from fmus.builder import build;"
                               "build(sys.argv[1], 'python', Path(sys.argv[2]))", MODELS[fmu.stem], tmp_path],
        cwd=ROOT, env={"PYTHONHASHSEED": "7", "PATH": ""}, check=True)
    assert again.returncode == 0
    assert (tmp_path / "python" / fmu.name).read_bytes() == fmu.read_bytes()


def test_every_number_has_a_unit_and_angles_show_degrees_but_frequencies_do_not(fmu):
    with running(fmu) as instance:
        for v in instance.file.variables.values():
            if v.type == "Real":
                assert v.unit, v.name
                frequency = v.name.endswith(("omega", "omega_1", "omega_2", "bandwidth", "_zero", "_pole"))
                shown = v.unit.replace("rad", "deg") if v.unit.startswith("rad") and not frequency else ""
                assert v.display_unit == shown, v.name


def test_state_can_be_saved_serialised_and_replayed_to_the_last_bit(fmu):
    with running(fmu) as instance:
        for k in range(20):
            step(instance, k * 0.01, 0.01)
        blob = instance.saved()

        def rest(instance):
            trajectory = []
            for k in range(20, 40):
                step(instance, k * 0.01, 0.01)
                trajectory.append(outputs(instance))
            return trajectory

        expected = rest(instance)
        instance.restore(blob)
        assert rest(instance) == expected
        with running(fmu) as fresh:
            fresh.restore(blob)
            assert rest(fresh) == expected


@pytest.mark.slow
def test_hundreds_of_instances_of_one_fmu_can_come_and_go(python_fmus):
    """pythonfmu's loader drops a reference of the slave module's globals with every instance."""
    for _ in range(200):
        with running(python_fmus["AhvScenario"]) as instance:
            assert outputs(instance)[0] == 7900


def test_two_builds_in_one_process_each_run_their_own_code(tmp_path):
    """A copy of the project with another direction of the elevator, beside the real one."""
    copy = tmp_path / "copy"
    for room in ("ahv_plant_fmu", "ahv_ctrl_fmu", "cosim", "fmus"):
        copytree(ROOT / room, copy / room, ignore=lambda *_: ["dist", "__pycache__", ".cache"])
    copyfile(ROOT / "LICENSE", copy / "LICENSE")
    law = copy / "ahv_ctrl_fmu" / "neural.py"
    law.write_text(law.read_text().replace('"h_error": u.h - s.h_ref[0]', '"h_error": 42.0'))
    subprocess.run([sys.executable, "-c", "import sys; from pathlib import Path; from fmus.builder import build;"
                                          "build(sys.argv[1], 'python', Path(sys.argv[2]))",
                    MODELS["AhvController"], copy], cwd=copy, check=True)
    original = build(MODELS["AhvController"], "python", tmp_path)
    altered = copy / "python" / "AhvController.fmu"
    for first, second, values in ((original, altered, (0.0, 42.0)), (altered, original, (42.0, 0.0))):
        with running(first) as a, running(second) as b:
            assert (a.get(["h_error"])[0], b.get(["h_error"])[0]) == values


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), -float("inf")])
def test_an_input_that_is_no_number_never_reaches_a_state(python_fmus, bad):
    with running(python_fmus["AhvPlant"]) as plant:
        step(plant, 0.0, 0.01)
        before = outputs(plant)
        with pytest.raises(RunError, match=r"elevator = (nan|-?inf) is not a finite number and was refused"):
            plant.set({"elevator": bad})
        look_on(plant)
        with pytest.raises(RunError, match=r"elevator = (nan|-?inf) is not a finite number at t = 0\.01 s"):
            step(plant, 0.01, 0.01)
        look_on(plant)
        assert outputs(plant) == before
        plant.set({"elevator": 0.2})
        step(plant, 0.01, 0.01)
        assert np.all(np.isfinite(outputs(plant)))


def test_a_vehicle_that_leaves_the_models_range_is_reported_and_stays_where_it_was(python_fmus):
    with running(python_fmus["AhvPlant"], elevator=-1.5) as plant:
        with pytest.raises(RunError, match=r"theta = .* deg is above its maximum 90 deg at t = "):
            for k in range(1000):
                last = outputs(plant)
                step(plant, k * 0.01, 0.01)
        look_on(plant)
        assert outputs(plant) == last


@pytest.mark.parametrize("length", [0.0, -0.01, float("nan")])
def test_a_step_that_is_not_positive_is_refused(fmu, length):
    with running(fmu) as instance, pytest.raises(RunError, match="is not a positive number"):
        step(instance, 0.0, length)


def test_a_fixed_parameter_cannot_be_set_after_initialisation(python_fmus):
    with running(python_fmus["AhvPlant"]) as plant, pytest.raises(RunError, match="mass is fixed"):
        plant.set({"mass": 310.0})


def test_no_step_goes_past_the_stop_time(fmu):
    with running(fmu) as instance, pytest.raises(RunError, match="would go past the stop time 1000 s"):
        step(instance, 999.995, 0.01)


def test_calls_out_of_order_are_refused(fmu):
    with running(fmu) as instance, pytest.raises(RunError, match="initialisation can begin once"):
        instance.simple("fmi2EnterInitializationMode")
