"""`ahv ssp`: the closed loop as a file that the standard, other tools and `ahv simulate` accept."""
import json
import xml.etree.ElementTree as ET
import zipfile

import pyarrow.parquet
import pytest
import small
from altered import redescribed
from command import ahv
from fmpy.ssp.ssd import read_ssd
from lxml import etree

from cosim.errors import UsageError
from cosim.master.fly import fly
from cosim.master.system import Component, Connection, System
from cosim.master.xml_file import SSD, SSV, schema
from cosim.ssp.load import load_ssp
from cosim.ssp.write import write

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
    assert not list(root.iter(f"{SSC}LinearTransformation"))  # values travel as they are


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


@pytest.fixture
def reading(tmp_path):
    """Writes a system and reads it again."""
    def written(system):
        write(tmp_path / "test.ssp", "test", system, 0.1, 0.5)
        return load_ssp(tmp_path / "test.ssp")
    return written


def variant(folder, name, **given):
    """small.fmu as folder/name/Same.fmu, its u in the unit `u` and its y in the unit `y`, of these definitions."""
    (folder / name).mkdir()
    units = "".join(f'<Unit name="{unit}"><BaseUnit {base}/></Unit>' for unit, base in dict(given.values()).items())
    y = '<Real/></ScalarVariable><!-- 16 -->'
    swaps = {"u": ('<Real start="0.0"/></ScalarVariable><!-- 15 -->', '<Real start="0.0" unit="{}"/></ScalarVariable>'),
             "y": (y, '<Real unit="{}"/></ScalarVariable>')}
    return redescribed(small.build(folder), folder / name / "Same.fmu",
                       ("<ModelVariables>", f"<UnitDefinitions>{units}</UnitDefinitions><ModelVariables>"),
                       *((swaps[v][0], swaps[v][1].format(unit)) for v, (unit, _) in given.items()))


KM, M, FOOT, SHORT_FOOT = (("km", 'm="1" factor="1000"'), ("m", 'm="1"'), ("foot", 'm="1" factor="0.3048"'),
                           ("foot", 'm="1" factor="0.3"'))


def test_two_fmus_of_one_file_name_stay_two(tmp_path, reading, capsys):
    one, other = (variant(tmp_path, name, u=unit) for name, unit in (("one", KM), ("other", M)))
    (tmp_path / "copy").mkdir()
    copy = tmp_path / "copy" / "Same.fmu"
    copy.write_bytes(one.read_bytes())
    parts = [Component(name, fmu) for name, fmu in (("a", one), ("b", other), ("c", copy), ("d", other))]
    with reading(System(parts)) as found:
        assert found.sources == {"a": "resources/Same.fmu", "b": "resources/Same_2.fmu", "c": "resources/Same.fmu",
                                 "d": "resources/Same_2.fmu"}
        assert [c.fmu.read_bytes() for c in found.components] == [p.fmu.read_bytes() for p in parts]
    assert capsys.readouterr().err == ""  # valid, also without connections


@pytest.mark.parametrize("ends,factor,offset", [
    ((KM, M), 1000.0, 0.0), ((KM, M), 1.0, 0.0), ((KM, M), 2.0, 3.0), ((M, M), 2.0, 3.0),
    ((FOOT, SHORT_FOOT), 1.0, 0.0)])
def test_a_connection_means_the_same_once_it_is_written(ends, factor, offset, tmp_path, reading):
    """The master's connections carry numbers; a reader of the SSP would convert units beside."""
    parts = (Component("a", variant(tmp_path, "one", y=ends[0])), Component("b", variant(tmp_path, "other", u=ends[1])))
    links = (Connection("a.y", "b.u", factor, offset),)
    with reading(System(parts, links)) as found:
        assert found.connections == links


def test_units_of_one_name_and_two_definitions_keep_theirs(tmp_path, reading):
    parts = (Component("a", variant(tmp_path, "one", y=FOOT)), Component("b", variant(tmp_path, "other", y=SHORT_FOOT)))
    with reading(System(parts)) as found, zipfile.ZipFile(tmp_path / "test.ssp") as archive:
        root = etree.fromstring(archive.read("SystemStructure.ssd"))
        assert len(found.components) == 2
        assert [u.get("factor") for u in root.iter(f"{SSC}BaseUnit")] == ["0.3048"]
        used = {c.get("name"): [r.get("unit") for r in c.iter(f"{SSC}Real") if r.get("unit")]
                for c in root.iter(f"{SSD}Component")}
        assert used == {"a": ["foot"], "b": []}


def test_values_and_connections_of_every_type_come_back(tmp_path, reading):
    fmu = small.build(tmp_path)
    parts = (Component("a", fmu, {"a21": -4.5, "whole_in": -7, "truth_in": True, "text_in": "x < y"}),
             Component("b", fmu, {"truth_in": False}))
    links = (*(Connection(f"a.{n}_out", f"b.{n}_in") for n in ("whole", "text")), Connection("a.y", "b.u"))
    with reading(System(parts, links)) as found:
        assert [c.values for c in found.components] == [p.values for p in parts]
        assert set(found.connections) == set(links) and (found.step, found.stop) == (0.1, 0.5)
        one, other = fly(System(parts, links), 0.1, 0.5), fly(found, 0.1, 0.5)
    assert one.signals.tobytes() == other.signals.tobytes()


def test_a_value_that_does_not_fit_writes_nothing(tmp_path):
    system = System((Component("a", small.build(tmp_path), {"whole_in": 1.5}),))
    with pytest.raises(UsageError, match=r"a\.whole_in = 1\.5 is not allowed: it must be a whole number"):
        write(tmp_path / "test.ssp", "test", system, 0.1, 0.5)
    assert list(tmp_path.glob("test.ssp*")) == []


def test_an_enumeration_keeps_its_type(tmp_path, reading):
    fmu = redescribed(small.build(tmp_path), tmp_path / "enumeration.fmu",
                      ("<ModelVariables>", '<TypeDefinitions><SimpleType name="mode"><Enumeration><Item name="on" '
                       'value="0"/></Enumeration></SimpleType></TypeDefinitions><ModelVariables>'),
                      ("<Integer/></ScalarVariable>", '<Enumeration declaredType="mode"/></ScalarVariable>'))
    with reading(System((Component("a", fmu),))), zipfile.ZipFile(tmp_path / "test.ssp") as archive:
        root = etree.fromstring(archive.read("SystemStructure.ssd"))
    assert [kind.attrib for kind in root.iter(f"{SSC}Enumeration")] == [{"name": "mode"}]
