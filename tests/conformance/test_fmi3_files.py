"""Our FMUs of FMI 3.0: what is in the files, and that they fly as those of FMI 2.0 do, to the last bit."""
import zipfile
from importlib import import_module
from itertools import combinations
from xml.etree import ElementTree

import numpy as np
import pytest
from fmpy import read_model_description, simulate_fmu
from fmpy.validation import validate_fmu
from places import ROOT

import cosim
from cosim.errors import UsageError
from cosim.vehicle import scenarios
from cosim.vehicle.closed_loop import CLOSED_LOOP, closed_loop
from cosim.vehicle.registry import LAWS, MODELS, PLANTS, SCENARIO

PLATFORMS = {"x86_64-linux": ".so", "aarch64-linux": ".so", "x86_64-windows": ".dll", "x86_64-darwin": ".dylib",
             "aarch64-darwin": ".dylib"}


@pytest.fixture(params=MODELS)
def name(request):
    return request.param


def terminals(fmu) -> dict[str, list[str]]:
    """Name -> variables of an FMU's terminals."""
    with zipfile.ZipFile(fmu) as archive:
        root = ElementTree.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
    assert all(t.get("matchingRule") == "plug" and m.get("memberName") == m.get("variableName")
               for t in root.iter("Terminal") for m in t)
    return {t.get("name"): [m.get("memberName") for m in t] for t in root.iter("Terminal")}


def test_a_file_has_what_the_standard_names(native_fmi3_fmus, name):
    assert validate_fmu(str(native_fmi3_fmus[name])) == []
    with zipfile.ZipFile(native_fmi3_fmus[name]) as archive:
        there = set(archive.namelist())
        built = ElementTree.fromstring(archive.read("sources/buildDescription.xml"))
        assert archive.read("documentation/licenses/license.txt") == (ROOT / "LICENSE").read_bytes()
        assert archive.read("terminalsAndIcons/icon.png").startswith(b"\x89PNG")
    assert {path for path in there if path.startswith("binaries/")} == {
        f"binaries/{platform}/{name}{suffix}" for platform, suffix in PLATFORMS.items()}
    assert {f"sources/{file.get('name')}" for file in built.iter("SourceFile")} <= there
    assert "model.png" not in there


def test_both_versions_have_one_library_and_one_description_of_each_variable(native_fmus, native_fmi3_fmus, name):
    libraries = set()
    for fmus, platform in ((native_fmus, "linux64"), (native_fmi3_fmus, "x86_64-linux")):
        with zipfile.ZipFile(fmus[name]) as archive:
            libraries.add(archive.read(f"binaries/{platform}/{name}.so"))
    two, three = (read_model_description(str(fmus[name])) for fmus in (native_fmus, native_fmi3_fmus))
    tokens = {two.guid, three.guid}
    assert len(libraries) == len(tokens) == 1
    told = [[(v.name, v.valueReference, v.causality, v.variability, v.initial, v.start, v.unit, v.displayUnit, v.min,
              v.max, v.nominal, v.description, v.derivative and v.derivative.name) for v in d.modelVariables]
            for d in (two, three)]
    assert told[0] == told[1][:-1]  # what FMI 3.0 has beside it is the time
    assert (three.modelVariables[-1].causality, three.modelVariables[-1].unit) == ("independent", "s")
    assert len({v.valueReference for v in three.modelVariables}) == len(three.modelVariables)


def test_dependencies_are_those_of_fmi_2_and_the_time(native_fmus, native_fmi3_fmus, name):
    two, three = (read_model_description(str(fmus[name])) for fmus in (native_fmus, native_fmi3_fmus))
    timed = 0
    for kind in ("outputs", "derivatives", "initialUnknowns"):
        told = [{u.variable.name: [v.name for v in u.dependencies] for u in getattr(d, kind)} for d in (two, three)]
        timed += sum("time" in needs for needs in told[1].values())
        assert told[0] == {name: [n for n in needs if n != "time"] for name, needs in told[1].items()}
    assert (timed > 0) == (name in ("AhvScenario", "AhvInstrumentedPlant"))


@pytest.mark.parametrize("plant", PLANTS.values(), ids=lambda model: model.word)
@pytest.mark.parametrize("law", LAWS.values(), ids=lambda model: model.word)
def test_terminals_of_one_name_are_the_connections_of_the_loop(native_fmi3_fmus, plant, law):
    groups = {"scenario": terminals(native_fmi3_fmus[SCENARIO.fmu]), "controller": terminals(native_fmi3_fmus[law.fmu]),
              "plant": terminals(native_fmi3_fmus[plant.fmu])}
    expected: dict[frozenset[str], list[str]] = {}
    for source, target, names in CLOSED_LOOP:
        expected.setdefault(frozenset((source, target)), []).extend(names)
    found = {frozenset(pair): [n for name in groups[pair[0]].keys() & groups[pair[1]].keys()
                               for n in groups[pair[0]][name]] for pair in combinations(groups, 2)}
    assert {pair: sorted(names) for pair, names in found.items()} == {
        pair: sorted(names) for pair, names in expected.items()}


@pytest.mark.parametrize("case, controller, plant", [("case1", "neural", "ideal"), ("case2", "neural", "ideal"),
                                                     ("case1", "resilient", "instrumented"),
                                                     ("case1", "backstepping", "ideal")])
def test_the_loop_of_fmi_3_flies_as_that_of_fmi_2_to_the_last_bit(native_fmus, native_fmi3_fmus, case, controller,
                                                                  plant):
    plan = scenarios.load(case)
    two, three = (cosim.fly(closed_loop(plan, controller, plant, flavour).system, 0.01, plan.stop, progress=False)
                  for flavour in ("native", "native-fmi3"))
    assert three.finished and len(three.time) == round(plan.stop / 0.01) + 1
    assert np.array_equal(two.signals, three.signals)


def test_fmpy_flies_each_file(native_fmus, native_fmi3_fmus, name):
    two, three = (simulate_fmu(str(fmus[name]), fmi_type="CoSimulation", stop_time=0.5, step_size=0.01,
                               output_interval=0.01) for fmus in (native_fmus, native_fmi3_fmus))
    assert len(three) == 51 and two.dtype == three.dtype and np.array_equal(two.tolist(), three.tolist())


def test_a_flavour_that_is_not_built_for_a_version_is_refused():
    with pytest.raises(UsageError, match="native-fmi4 is not known; there are python, native, native-fmi3"):
        closed_loop(scenarios.load("hold"), flavour="native-fmi4")


def test_the_terminals_of_our_models_name_ports(name):
    model = import_module(MODELS[name])
    ports = {row[0] for row in model.VARIABLES if row[1] in ("input", "output")}
    assert model.TERMINALS and ports.issuperset(n for names in model.TERMINALS.values() for n in names)
