"""One FMU linearised alone, through model exchange: where it starts, after a while, and at given values."""
import json
import zipfile
from pathlib import Path

import numpy as np
import pytest
from command import ahv
from exact_linear import linear_vehicle, nominal_trim, values_of

import cosim
from ahv_plant_fmu import model as plant
from cosim.analysis import linearize_fmu
from cosim.analysis.equations import slopes_along
from cosim.errors import RunError, UsageError

LEVEL = ["V_start=7700", "h_start=85000"]
STATES = ["V", "h", "gamma", "theta", "Q", "eta1", "eta1_dot", "eta2", "eta2_dot"]


@pytest.fixture(params=["native_fmus", "native_fmi3_fmus"])
def vehicle(request) -> Path:
    return request.getfixturevalue(request.param)["AhvPlant"]


@pytest.fixture(scope="module")
def without_derivatives(native_fmus, tmp_path_factory) -> Path:
    """The plant of FMI 2.0 that claims no directional derivatives."""
    path = tmp_path_factory.mktemp("without") / "AhvPlant.fmu"
    with zipfile.ZipFile(native_fmus["AhvPlant"]) as own, zipfile.ZipFile(path, "w") as other:
        for name in own.namelist():
            content = own.read(name)
            if name == "modelDescription.xml":
                content = content.replace(b' providesDirectionalDerivative="true"', b"")
            other.writestr(name, content)
    return path


def trimmed() -> list[str]:
    """Words for level flight at 7700 ft/s, 85000 ft."""
    trim = nominal_trim(plant, 7700.0, 85000.0, values_of(plant, {}))[1]
    return [*LEVEL, f"fuel_ratio={float(trim.fuel_ratio)!r}", f"elevator={float(trim.elevator)!r}"]


def test_the_vehicle_at_its_trim_has_the_matrices_of_its_equations(vehicle):
    found, exact = linearize_fmu(vehicle, trimmed()), linear_vehicle(plant, 7700, 85000)
    assert found["derivatives"] == "directional" and list(found["states"]) == STATES
    assert max(abs(rate) for rate in found["rates"].values()) < 1e-9
    system = found["system"]
    columns = [system["inputs"].index(name) for name in ("fuel_ratio", "elevator")]
    assert np.allclose(system["A"], exact.A, rtol=1e-12, atol=1e-15)
    assert np.allclose(np.array(system["B"])[:, columns], exact.B, rtol=1e-12, atol=1e-15)
    assert np.array_equal(np.array(system["C"])[system["outputs"].index("alpha")], [0, 0, -1, 1, 0, 0, 0, 0, 0])
    poles = np.array([p["real"] + 1j * p["imag"] for p in system["poles"]])
    assert np.abs(np.sort_complex(poles) - np.sort_complex(exact.poles)).max() < 1e-9


def test_differences_are_taken_where_the_fmu_has_no_derivatives_of_its_own(without_derivatives, native_fmus):
    words = [*LEVEL, "fuel_ratio=0.4", "elevator=0.1", "gamma=0.01", "Q=2deg/s", "eta2_dot=3"]
    found, own = linearize_fmu(without_derivatives, words), linearize_fmu(native_fmus["AhvPlant"], words)
    assert (found["derivatives"], own["derivatives"]) == ("differences", "directional")
    assert own["states"]["Q"] == pytest.approx(np.radians(2)) and found["rates"] == own["rates"]
    for name in "ABCD":
        expected = np.array(own["system"][name])
        scale = np.abs(expected).max(axis=0, initial=1e-9)
        assert (np.abs(np.array(found["system"][name]) - expected) <= 1e-9 * scale).all(), name


def test_after_a_while_it_is_where_it_flies_to(vehicle):
    found = linearize_fmu(vehicle, [*LEVEL, "fuel_ratio=0.3", "elevator=0.2"], 0.5)
    flown = cosim.fly(cosim.System([cosim.Component("plant", vehicle, {
        "V_start": 7700.0, "h_start": 85000.0, "fuel_ratio": 0.3, "elevator": 0.2})]), step=0.01, stop=0.5)
    for name in STATES:
        assert found["states"][name] == pytest.approx(flown[f"plant.{name}"][-1], rel=1e-7, abs=1e-9), name
    at_start = linearize_fmu(vehicle, [*LEVEL, "fuel_ratio=0.3", "elevator=0.2"])
    assert found["time_s"] == 0.5 and found["system"]["A"] != at_start["system"]["A"]


def test_a_kink_is_no_place_for_differences():
    def answer(v):
        return np.array([abs(v[0]), v[0] ** 2, np.exp(v[0]), 3.0])

    slopes, kink = slopes_along(answer, np.array([0.0]), np.array([1.0]))
    assert kink.tolist() == [True, False, False, False]
    assert slopes[1:] == pytest.approx([0.0, 1.0, 0.0], abs=1e-11)
    assert not slopes_along(answer, np.array([0.5]), np.array([1.0]))[1].any()


def test_what_cannot_be_linearised_alone_is_said_in_one_sentence(native_fmus, python_fmus, tmp_path):
    fmu, python = native_fmus["AhvPlant"], python_fmus["AhvPlant"]
    for words, time, sentence in (
            (["V_sart=1"], 0, "did you mean V_start?"), (["V_start"], 0, "is not of the form VARIABLE=VALUE"),
            (["gamma=steep"], 0, "gamma"), (["gamma=nan"], 0, "it must be a number"), ([], -1, "--time -1")):
        with pytest.raises(UsageError, match=sentence):
            linearize_fmu(fmu, words, time)
    with pytest.raises(UsageError, match=r"is FMI 2\.0 without model exchange; model-exchange FMUs of FMI 2\.0"):
        linearize_fmu(python)
    with pytest.raises(RunError, match="cannot be flown to t = 100 s"):
        linearize_fmu(fmu, [*LEVEL, "elevator=0.3"], 100.0)
    assert "--V cannot be given here: AhvPlant.fmu is linearised alone" in ahv("linearize", fmu, "--V", 7700, status=2)
    assert "--time cannot be given here" in ahv("linearize", "--time", 1, status=2)
    assert "must end in .mat or .json" in ahv("linearize", fmu, "--out", tmp_path / "x.txt", status=2)
    assert "folder that exists" in ahv("linearize", fmu, "--out", tmp_path / "no" / "x.mat", status=2)
    assert "--of tail is not known" in ahv("linearize", "--of", "tail", status=2)
    found = json.loads(ahv("linearize", fmu, *(w for word in trimmed() for w in ("--set", word)), "--json"))
    assert found["fmi_version"] == "2.0" and len(found["system"]["poles"]) == 9
