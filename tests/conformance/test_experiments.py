"""The experiments that travel in the controllers' FMUs (FMI-LS-REF), run by what is in the FMU file alone."""
import csv
import io
import posixpath
import subprocess
import sys
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from fmpy import read_model_description, simulate_fmu
from places import ROOT

from cosim.vehicle.registry import LAWS, MODELS, PLANTS, SCENARIO

FOLDER = "extra/org.fmi-standard.fmi-ls-ref"
LARGEST = 300_000  # bytes that the experiments may add to an FMU
SSV = "{http://ssp-standard.org/SSP1/SystemStructureParameterValues}"


def related(archive) -> dict[str, list[str]]:
    """Role -> paths in the archive, as the manifest has them."""
    root = ElementTree.fromstring(archive.read(f"{FOLDER}/fmi-ls-manifest.xml"))
    found: dict[str, list[str]] = {}
    for entry in root:
        found.setdefault(entry.get("role"), []).append(posixpath.normpath(f"{FOLDER}/{entry.get('source')}"))
    return found


def table(archive, path) -> np.ndarray:
    """A CSV file of the archive, with its columns by name."""
    return np.genfromtxt(io.StringIO(archive.read(path).decode()), delimiter=",", names=True)


def experiments(fmu: Path, role: str) -> list[tuple]:
    """(name, parameters, inputs or None, golden outputs, what else is said) of the experiments of a role."""
    found = []
    with zipfile.ZipFile(fmu) as archive:
        for path in related(archive)[role]:
            for entry in ElementTree.fromstring(archive.read(path)):
                def of(tag, entry=entry):
                    found = entry.find(tag)
                    return None if found is None else posixpath.normpath(f"{FOLDER}/{found.get('source')}")

                parameters = ElementTree.fromstring(archive.read(of("Parameters"))) if of("Parameters") else []
                values = {p.get("name"): p[0].get("value") == "true" if p[0].tag == f"{SSV}Boolean"
                          else float(p[0].get("value"))
                          for group in parameters for p in group}
                said = {**entry.find("TransientSimulation").attrib, "tolerance": entry.get("tolerance")}
                inputs = table(archive, of("Stimuli")) if of("Stimuli") else None
                found.append((entry.get("name"), values, inputs,
                              table(archive, of("References")), {key: float(value) for key, value in said.items()}))
    return found


def worst(fmu: Path, values, inputs, golden, said) -> float:
    """The largest difference of a flight in FMPy from the golden outputs, as a part of a variable's nominal value."""
    nominal = {v.name: float(v.nominal or 1) for v in read_model_description(str(fmu)).modelVariables}
    names = [name for name in golden.dtype.names if name != "time"]
    first = {} if inputs is None else {name: float(inputs[name][0]) for name in inputs.dtype.names if name != "time"}
    flown = simulate_fmu(str(fmu), fmi_type="CoSimulation", start_time=said["startTime"], stop_time=said["stopTime"],
                         step_size=said["stepSize"], output_interval=said["stepSize"], input=inputs, output=names,
                         start_values={**values, **first})
    at = np.searchsorted(flown["time"], golden["time"] - 1e-6 * said["stepSize"])
    assert np.allclose(flown["time"][at], golden["time"], rtol=0, atol=1e-9)
    return max(float(np.abs(flown[name][at] - golden[name]).max()) / nominal[name] for name in names)


@pytest.fixture(params=["native_fmus", "native_fmi3_fmus"])
def fmus(request):
    return request.getfixturevalue(request.param)


LAWS_HAVE = ["experiment/smoke-test", "experiment/validation", "experiment/uncertainty-analysis"]


@pytest.mark.parametrize("model, role", [
    *((law.fmu, role) for law in LAWS.values() for role in LAWS_HAVE), (SCENARIO.fmu, LAWS_HAVE[0]),
    (SCENARIO.fmu, LAWS_HAVE[1]), *((plant.fmu, LAWS_HAVE[0]) for plant in PLANTS.values())])
def test_an_fmu_repeats_the_golden_results_that_it_carries(fmus, model, role):
    found = experiments(fmus[model], role)
    assert found
    for name, values, inputs, golden, said in found:
        assert len(golden) > 3 and said["tolerance"] <= 1e-6, name
        assert worst(fmus[model], values, inputs, golden, said) <= said["tolerance"], name


def test_another_law_does_not_repeat_them(native_fmus):
    """The comparison can fail: the preset decides on the results."""
    (_, values, inputs, golden, said), = experiments(native_fmus["AhvController"], "experiment/smoke-test")
    assert worst(native_fmus["AhvController"], {**values, "kV1": 1.5 * values["kV1"]}, inputs, golden, said) > 1e-3


@pytest.mark.parametrize("name", MODELS)
def test_the_manifest_names_all_files_and_no_other(fmus, name):
    with zipfile.ZipFile(fmus[name]) as archive:
        listed = [path for paths in related(archive).values() for path in paths]
        there = [path for path in archive.namelist()
                 if path.startswith((FOLDER, "resources/presets/")) and not path.endswith("fmi-ls-manifest.xml")]
        extra = sum(archive.getinfo(path).compress_size for path in archive.namelist() if path.startswith(FOLDER))
        page = archive.read("documentation/fmi-ls-ref.html").decode()
    assert sorted(listed) == sorted([*there, "documentation/index.html"])
    assert all(path.rpartition("/")[2] in page for path in listed) and extra < LARGEST


@pytest.mark.slow
def test_the_files_in_the_tree_are_what_recording_gives(native_fmus, tmp_path):
    subprocess.run([sys.executable, "benchmarks/record_experiments.py", "--out", tmp_path], cwd=ROOT, check=True)
    kept = {path.relative_to(path.parents[1]): path for room in ("ahv_ctrl_fmu", "ahv_plant_fmu", "cosim/vehicle")
            for path in (ROOT / room / "experiments").glob("*/*")}
    recorded = {path.relative_to(tmp_path): path for path in tmp_path.glob("*/*")}
    assert kept and kept.keys() == recorded.keys()
    for path in kept:
        one, other = (list(csv.reader(folder[path].open())) for folder in (kept, recorded))
        if path.suffix == ".csv":
            assert one[0] == other[0]
            assert np.allclose(np.array(one[1:], float), np.array(other[1:], float), rtol=1e-7, atol=1e-6), path
        else:
            assert one == other, path
