"""`ahv ssp`: the closed loop as a file that the standard, other tools and `ahv simulate` accept."""
import json
import xml.etree.ElementTree as ET
import zipfile

import pyarrow.parquet
import pytest
from fmpy.ssp.ssd import read_ssd
from lxml import etree
from test_cases import ahv

from cosim.master.xml_file import SSD, SSV, schema

SSC = "{http://ssp-standard.org/SSP1/SystemStructureCommon}"


@pytest.fixture(scope="module")
def case1(tmp_path_factory):
    path = tmp_path_factory.mktemp("ssp") / "case1.ssp"
    ahv("ssp", "--flavour", "native", "--out", path)
    return path


def test_every_document_is_valid(case1):
    with zipfile.ZipFile(case1) as archive:
        names = archive.namelist()
        for name in names:
            if name.endswith((".ssd", ".ssv")):
                kind = "Description" if name.endswith(".ssd") else "ParameterValues"
                schema(f"SystemStructure{kind}.xsd").assertValid(etree.fromstring(archive.read(name)))
    assert names == ["SystemStructure.ssd", "resources/AhvController.fmu", "resources/AhvPlant.fmu",
                     "resources/AhvScenario.fmu", "resources/controller.ssv", "resources/scenario.ssv"]


def test_fmpy_reads_it(case1):
    system = read_ssd(str(case1)).system
    assert [c.name for c in system.elements] == ["scenario", "controller", "plant"]
    assert len(system.connections) == 14 and not system.connectors


def test_connectors_have_kind_and_unit_and_units_their_base(case1):
    with zipfile.ZipFile(case1) as archive:
        root = ET.fromstring(archive.read("SystemStructure.ssd"))
    units = {u.get("name"): u.find(f"{SSC}BaseUnit").attrib for u in root.iter(f"{SSC}Unit")}
    assert units["ft/s"] == {"m": "1", "s": "-1", "factor": "0.3048"}
    used = {r.get("unit") for r in root.iter(f"{SSC}Real")} - {None}
    assert used == set(units)
    plant = next(c for c in root.iter(f"{SSD}Component") if c.get("name") == "plant")
    kinds = {c.get("name"): c.get("kind") for c in plant.iter(f"{SSD}Connector")}
    assert kinds["elevator"] == "input" and kinds["h"] == "output"


def test_the_same_words_give_the_same_bytes(case1, tmp_path):
    ahv("ssp", "case1", "--flavour", "native", "--out", tmp_path / "again.ssp")
    assert (tmp_path / "again.ssp").read_bytes() == case1.read_bytes()


def test_presets_values_and_step_are_in_it(tmp_path):
    ahv("ssp", "case2", "--flavour", "native", "--preset", "printed", "--set", "plant.V_start=8000", "--step", 0.02,
        "--out", tmp_path / "test.ssp")
    with zipfile.ZipFile(tmp_path / "test.ssp") as archive:
        sets = {name: ET.fromstring(archive.read(f"resources/{name}.ssv"))
                for name in ("scenario", "controller", "plant")}
        description = archive.read("SystemStructure.ssd").decode()
    values = {name: {p.get("name"): p[0].get("value") for p in s.iter(f"{SSV}Parameter")} for name, s in sets.items()}
    assert values["scenario"]["V_command_step"] == "333.33"
    assert values["controller"]["k_gamma"] == "2.0" and values["controller"]["z3_from_pitch_rate"] == "false"
    assert values["plant"] == {"V_start": "8000.0"}
    assert 'baseStepSize="0.02"' in description and 'stopTime="300.0"' in description


@pytest.mark.parametrize("words", [["--controller", "backstepping"], ["--plant", "instrumented"]])
def test_other_laws_and_plants_are_written_and_fly(words, tmp_path):
    ahv("ssp", "case1", *words, "--out", tmp_path / "test.ssp")
    found = json.loads(ahv("simulate", tmp_path / "test.ssp", "--stop", 1, "--out", tmp_path / "out", "--json"))
    assert found["finished"] and found["ticks"] == 100


def test_a_name_becomes_an_identifier(tmp_path):
    (tmp_path / "own.yaml").write_text("name: my run-2\nstop: 2\npresets: {scenario: hold}\n")
    ahv("ssp", tmp_path / "own.yaml", "--out", tmp_path / "own.ssp")
    assert read_ssd(str(tmp_path / "own.ssp")).system.name == "my_run_2"


@pytest.mark.parametrize("flavour", ["python", "native"])
def test_simulate_flies_it_as_run_does(flavour, tmp_path):
    words = ("--flavour", flavour)
    ahv("ssp", "case2", *words, "--out", tmp_path / "case2.ssp")
    ahv("run", "case2", *words, "--stop", 5, "--out", tmp_path / "run")
    found = json.loads(ahv("simulate", tmp_path / "case2.ssp", "--stop", 5, "--out", tmp_path / "simulate", "--json"))
    assert (found["system"], found["step_s"], found["ticks"]) == ("case2", 0.01, 500)
    one, other = (pyarrow.parquet.read_table(tmp_path / name / "signals.parquet") for name in ("run", "simulate"))
    assert one.equals(other)


@pytest.mark.parametrize("words,sentence", [
    (["caes1"], "Did you mean case1?"),
    (["case1", "--preset", "printd"], "no preset printd"),
    (["case1", "--set", "plant.mass=heavy"], "it must be a number"),
    (["case1", "--step", "0"], "must be positive"),
    (["case1", "--out", "/proc/no/such.ssp"], "cannot be written"),
])
def test_wrong_words_write_nothing(words, sentence, tmp_path):
    assert sentence in ahv("ssp", *words, cwd=tmp_path, status=2)
    assert not list(tmp_path.rglob("*.ssp*"))
