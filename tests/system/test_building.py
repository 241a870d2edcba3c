"""The tutorial of docs/building.md: its three models, built native, checked, flown here and by importers of others."""
import re
import shutil
import zipfile

import fmpy
import lief
import numpy as np
import pytest
from command import ahv
from places import ROOT
from test_foreign_masters import assert_same_flight

import cosim
import cosim.cli.app as cli
import fmus

EXAMPLES = ROOT / "docs" / "examples"
MODELS = ("spring", "pid", "valve")
LINES = 30


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A copy of the examples, and their FMUs in both flavours, as the page has them built."""
    place = tmp_path_factory.mktemp("building")
    for file in (*(EXAMPLES / f"{model}_model.py" for model in MODELS), EXAMPLES / "positioner.yaml"):
        shutil.copy(file, place)
    for model in MODELS:
        for flavour in ("native", "python"):
            fmus.build(place / f"{model}_model.py", flavour, place / "fmus")
    return place


def fmu(folder, model, flavour="native"):
    return folder / "fmus" / flavour / f"{model.capitalize()}.fmu"


@pytest.mark.parametrize("model", MODELS)
def test_an_example_has_few_lines_and_stands_on_the_page(model):
    text = (EXAMPLES / f"{model}_model.py").read_text()
    assert len(text.splitlines()) <= LINES
    assert f"```python title=\"{model}_model.py\"\n{text}```" in (ROOT / "docs" / "building.md").read_text()


def test_the_system_stands_on_the_page():
    assert f"```yaml\n{(EXAMPLES / 'positioner.yaml').read_text()}```" in (ROOT / "docs" / "building.md").read_text()


@pytest.mark.parametrize("model", MODELS)
def test_an_example_is_checked_clean_and_has_no_python_inside(model, folder):
    assert [f for f in cosim.check(fmu(folder, model)).findings if f.severity != "note"] == []
    with zipfile.ZipFile(fmu(folder, model)) as archive:
        assert [name for name in archive.namelist() if ".py" in name] == []
        library = lief.ELF.parse(list(archive.read(f"binaries/linux64/{model.capitalize()}.so")))
    assert set(library.libraries) <= {"libc.so.6", "libm.so.6"}


def test_the_spring_swings_as_its_closed_form_says(folder):
    system = cosim.System([cosim.Component("spring", fmu(folder, "spring"), {"position_start": 0.1})])
    flight = cosim.fly(system, step=0.01, stop=5)
    decay, omega = 4.0 / 4, np.sqrt(50.0 / 2 - 1.0)  # damping / 2 mass; sqrt(stiffness / mass - decay^2)
    t = flight.time
    exact = 0.1 * np.exp(-decay * t) * (np.cos(omega * t) + decay / omega * np.sin(omega * t))
    assert abs(flight["spring.position"] - exact).max() < 1e-8


def positioner(folder, **values):
    """The system of positioner.yaml, with these parameters of the controller."""
    components = [cosim.Component("spring", fmu(folder, "spring")), cosim.Component("pid", fmu(folder, "pid"), values),
                  cosim.Component("valve", fmu(folder, "valve"))]
    wires = ("spring.position", "pid.position"), ("pid.opening", "valve.opening"), ("valve.force", "spring.force")
    return cosim.System(components, [cosim.Connection(*wire) for wire in wires])


@pytest.mark.parametrize("step", [0.001, 0.01, 0.02])
def test_the_controller_runs_at_its_instants_and_the_mass_arrives(step, folder):
    flight = cosim.fly(positioner(folder), step=step, stop=5)
    changes = np.flatnonzero(np.diff(flight["pid.opening"]))  # in the step that begins at an instant
    assert len(changes) > 100 and not (changes % round(0.02 / step)).any()
    assert flight["pid.limited"].max() == 1.0 and flight["spring.position"].max() < 1.05 * 0.3
    assert flight["spring.position"][-1] == pytest.approx(0.3, abs=1e-4)


def test_the_integral_gives_way_at_the_limit(folder):
    """0.45 m is nearly all that the valve can do; without anti-windup the mass goes far beyond."""
    highest = [cosim.fly(positioner(folder, wanted=0.45, give_way=rate), step=0.01, stop=3)["spring.position"].max()
               for rate in (10.0, 0.0)]
    assert highest[0] < 0.46 < highest[1]


def test_three_importers_of_others_fly_the_same(folder, monkeypatch):
    monkeypatch.chdir(folder)
    ahv("ssp", "positioner.yaml", "--out", "positioner.ssp")
    assert_same_flight(folder / "positioner.ssp", 5, folder)


@pytest.mark.parametrize("model, inputs", [("spring", {"force": 3.0}), ("pid", {"wanted": 0.1, "position": 0.05}),
                                           ("valve", {"opening": 0.4})])
def test_fmpy_flies_each_alike_and_so_do_both_flavours(model, inputs, folder):
    flights = {}
    for flavour in ("native", "python"):
        path = fmu(folder, model, flavour)
        found = cosim.fly(cosim.System([cosim.Component("one", path, inputs)]), step=0.01, stop=1)
        flights[flavour] = np.column_stack([found[name] for name in found])
        names = [name.partition(".")[2] for name in found]
    theirs = fmpy.simulate_fmu(str(fmu(folder, model)), stop_time=1, step_size=0.01, output_interval=0.01, output=names,
                               start_values=inputs, fmi_type="CoSimulation")
    for rows in (np.column_stack([theirs[name] for name in names]), flights["python"]):
        assert np.allclose(flights["native"], rows, rtol=1e-12, atol=1e-14)


@pytest.fixture(scope="module")
def fmi3(folder):
    """The FMUs of FMI 3.0, which have the libraries of those of FMI 2.0."""
    return {model: fmus.build(folder / f"{model}_model.py", "native", folder / "fmus", fmi="3") for model in MODELS}


def test_as_fmi_3_they_are_checked_clean_and_fly_to_the_same_bits(folder, fmi3):
    for path in fmi3.values():
        assert [f for f in cosim.check(path, dynamic=False).findings if f.severity != "note"] == []
    old = positioner(folder)
    new = cosim.System([cosim.Component(c.name, fmi3[c.name]) for c in old.components], old.connections)
    flights = [cosim.fly(system, step=0.01, stop=2) for system in (old, new)]
    assert all(np.array_equal(flights[0][name], flights[1][name]) for name in flights[0])
    description = fmpy.read_model_description(str(fmi3["pid"]))
    assert float(description.coSimulation.fixedInternalStepSize) == 0.02


@pytest.mark.parametrize("version", ["2", "3"])
def test_the_spring_is_integrated_by_an_importers_solver(version, folder, fmi3):
    path = fmi3["spring"] if version == "3" else fmu(folder, "spring")
    found = fmpy.simulate_fmu(str(path), stop_time=3, start_values={"position_start": 0.1, "damping": 0.0},
                              output=["position"], fmi_type="ModelExchange", relative_tolerance=1e-10)
    assert np.allclose(found["position"], 0.1 * np.cos(5 * found["time"]), atol=1e-7)


@pytest.mark.parametrize("module", [False, True])
def test_the_command_builds_a_file_and_a_module(module, folder, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(folder.parent if module else folder)
    name = f"{folder.name}.valve_model" if module else "valve_model.py"
    with pytest.raises(SystemExit, match=r"^0$"):
        cli.done(["build", name, "--flavour", "python", "--out", str(tmp_path)])
    path = tmp_path / "python" / "Valve.fmu"
    assert capsys.readouterr().err == f"{path}\n" and path.is_file()


@pytest.mark.parametrize("word, told", [
    ("Valve", "There is no model Valve; there are AhvPlant, "), ("../valve", "There is no model ../valve; there are "),
    ("nowhere.py", "nowhere: there is no file nowhere.py in "),
    ("nowhere.model", "nowhere.model: there is no module nowhere, neither in ")])
def test_what_is_no_model_is_told(word, told, tmp_path, capsys):
    assert cli.done(["build", word, "--out", str(tmp_path)]) == 2
    assert capsys.readouterr().err.startswith(f"ahv: {told}")
    assert not list(tmp_path.iterdir())


def test_the_same_sources_give_the_same_bytes(folder, tmp_path):
    for model in MODELS:
        again = fmus.build(folder / f"{model}_model.py", "native", tmp_path)
        assert again.read_bytes() == fmu(folder, model).read_bytes()



MISTAKES = {"mass:": ('"kg", 2.0', '"kgs", 2.0'), "outputs()": (', "speed": x[1]', ""),
            "derivative()": ("return [x[1], (", "return [x[1] if x[0] > 0 else 0.0, ("),
            "spring_model.py,": ('NAME =', 'import numpy\nNAME =')}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_the_mistakes_of_the_page_are_told_so(mistake, tmp_path):
    old, new = MISTAKES[mistake]
    text = (EXAMPLES / "spring_model.py").read_text()
    assert text.count(old) == 1
    (tmp_path / "spring_model.py").write_text(text.replace(old, new))
    with pytest.raises(fmus.ModelError) as caught:
        fmus.build(tmp_path / "spring_model.py", "python", tmp_path)
    line, = [line.strip() for line in (ROOT / "docs" / "building.md").read_text().splitlines()
             if line.startswith(f"    ahv: Spring: {mistake}")]
    assert re.fullmatch(".*".join(map(re.escape, line.split("…"))), f"ahv: {caught.value}"), caught.value
