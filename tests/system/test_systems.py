"""One FMU, a system file and an SSP through one door; `ahv simulate` of each, pictures, and states to go on from."""
import json
import re
import zipfile

import numpy as np
import pyarrow.parquet
import pytest
import small
import small3
import ssp_files
from command import carried_out

from cosim.errors import UsageError
from cosim.master.fly import fly
from cosim.master.quantities import spelling
from cosim.master.state import read_state
from cosim.master.system import Component, Connection, System
from cosim.ssp.load import load_ssp
from cosim.systems.load import load_system
from cosim.systems.simulate import simulate
from cosim.systems.words import assigned, experiment, patterns
from cosim.vehicle import scenarios
from cosim.vehicle.closed_loop import closed_loop

PAIR = """
name: pair of masses
components:
  left: {fmu: small_indirect.fmu, set: {a21: -4.0, a22: -0.3, x1: 1.0}}
  right: small_indirect.fmu
connections:
  - left.y -> right.u
  - {from: right.y, to: left.u, factor: 0.8}
parameters: {right.a21: -9.0, right.a22: -0.3, right.x1: -0.5, right.x2: 0.2}
experiment: {stop: 1, step: 0.01}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("systems")
    small.build(place)
    (place / "pair.yaml").write_text(PAIR)
    return place


def table(folder):
    return pyarrow.parquet.read_table(folder / "signals.parquet")


# --- what a file says -------------------------------------------------------------------------------------------------

def test_a_system_file_is_the_system_that_it_lists(folder):
    with load_system(folder / "pair.yaml") as found:
        fmu = folder / "small_indirect.fmu"
        assert found.name == "pair of masses" and found.system == System(
            [Component("left", fmu, small.oscillator()), Component("right", fmu, small.oscillator(
                x1=-0.5, x2=0.2, a21=-9.0))], [Connection("left.y", "right.u"), Connection("right.y", "left.u", 0.8)],
            0.01, 1.0, 0.0)


def test_a_system_file_its_ssp_and_its_unpacked_ssp_fly_alike(folder, tmp_path):
    done = carried_out("ssp", folder / "pair.yaml", "--set", "left.x1=2", "--out", tmp_path / "pair.ssp")
    assert done.returncode == 0, done.stderr
    with zipfile.ZipFile(tmp_path / "pair.ssp") as archive:
        archive.extractall(tmp_path / "loose")
    for name, file, more in (("yaml", folder / "pair.yaml", ["left.x1=2"]), ("ssp", tmp_path / "pair.ssp", []),
                             ("ssd", tmp_path / "loose" / "SystemStructure.ssd", [])):
        simulate(file, None, None, None, tmp_path / name, values=more)
    assert table(tmp_path / "yaml").equals(table(tmp_path / "ssp"))
    assert table(tmp_path / "yaml").equals(table(tmp_path / "ssd"))


def test_a_system_file_becomes_one_fmu(tmp_path, folder):
    (folder / "chain.yaml").write_text(PAIR.replace("  - {from: right.y, to: left.u, factor: 0.8}\n", ""))
    done = carried_out("container", folder / "chain.yaml", "--out", tmp_path / "Pair.fmu")
    assert done.returncode == 0, done.stderr
    simulate(tmp_path / "Pair.fmu", 0.01, 1.0, None, tmp_path / "one")
    simulate(folder / "chain.yaml", None, None, "jacobi", tmp_path / "two")
    one, two = table(tmp_path / "one"), table(tmp_path / "two")
    assert np.allclose(one["Pair.right.y1"], two["right.y1"], rtol=0, atol=1e-12)


def test_the_experiment_is_the_users_else_the_fmus(tmp_path):
    fmu = small3.build(tmp_path)
    with load_system(fmu) as found:
        assert experiment(found, None, 2.0, None)[:3] == (0.0, 2.0, 0.004)
        assert experiment(found, 1.0, 2.0, 0.1)[:3] == (1.0, 2.0, 0.1)
        with pytest.raises(UsageError, match="does not say when to stop: give --stop"):
            experiment(found, None, None, None)


def test_a_default_experiment_whose_steps_do_not_fit_ends_at_a_whole_number_of_them(tmp_path):
    path = small3.build(tmp_path)
    with load_system(path) as found:
        odd = type(found)(**{**vars(found), "system": System(found.system.components, (), 0.3, 1.0)})
    assert experiment(odd, None, None, None)[1] == pytest.approx(0.9)
    assert "0.9 s is taken" in experiment(odd, None, None, None)[3][0]


def test_of_one_fmu_a_variable_needs_no_component(folder):
    with load_system(folder / "small_indirect.fmu") as found:
        for words in (["x1=2"], ["small_indirect.x1=2"]):
            assert assigned(words, found).components[0].values == {"x1": "2"}
        assert patterns(["y", "small_indirect.y1", "*2"], found) == [
            "small_indirect.y", "small_indirect.y1", "*2"]


def test_units_are_converted_unless_a_factor_is_given(tmp_path):
    def ends(text):
        (tmp_path / "s.yaml").write_text(f"components: {{a: km.fmu, b: m.fmu}}\nconnections: [{text}]\n")
        with load_system(tmp_path / "s.yaml") as found:
            return found.system.connections[0], found.remarks

    for name, factor in (("km", 1000), ("m", 1)):
        small.build(tmp_path)
        unit = f'<UnitDefinitions><Unit name="{name}"><BaseUnit m="1" factor="{factor}"/></Unit></UnitDefinitions>'
        with (zipfile.ZipFile(tmp_path / "small_indirect.fmu") as old,
              zipfile.ZipFile(tmp_path / f"{name}.fmu", "w") as new):
            new.writestr("binaries/linux64/small.so", old.read("binaries/linux64/small.so"))
            text = old.read("modelDescription.xml").decode().replace("<ModelVariables>", f"{unit}<ModelVariables>")
            for variable in ("u", "y"):
                text = re.sub(f'(name="{variable}" .*?<Real)', rf'\1 unit="{name}"', text, count=1)
            new.writestr("modelDescription.xml", text)
    link, remarks = ends("a.y -> b.u")
    assert link == Connection("a.y", "b.u", 1000.0) and "converts km to m: factor 1000" in remarks[0]
    assert ends("{from: a.y, to: b.u, offset: 2}") == (Connection("a.y", "b.u", 1.0, 2.0), [])


# --- flights ----------------------------------------------------------------------------------------------------------

def test_figures_of_a_format_are_drawn_without_plot(folder, tmp_path):
    done = carried_out("simulate", folder / "small_indirect.fmu", "--stop", "1", "--figures", "pdf",
                       "--columns", "1", "--out", tmp_path / "out")
    assert done.returncode == 0, done.stderr
    assert [path.name for path in (tmp_path / "out" / "figures").iterdir()] == ["signals.pdf"]


def test_one_fmu_from_the_command_line(folder, tmp_path):
    done = carried_out("simulate", folder / "small_indirect.fmu", "--start", "1", "--stop", "2", "--step", "0.1",
                       "--set", "x1=2", "--record", "y1", "--decimate", "5", "--plot", "--json", "--out",
                       tmp_path / "out")
    assert done.returncode == 0, done.stderr
    summary, found = json.loads(done.stdout), table(tmp_path / "out")
    assert (summary["start_s"], summary["stop_s"], summary["ticks"]) == (1.0, 2.0, 10)
    assert found.column_names == ["time", "small_indirect.y1"] and found["time"].to_pylist() == [1.0, 1.5, 2.0]
    assert found["small_indirect.y1"][0].as_py() == 2.0
    assert (tmp_path / "out" / "figures" / "signals.png").read_bytes()[:4] == b"\x89PNG"


def test_run_records_what_is_asked_for(tmp_path):
    done = carried_out("run", "hold", "--stop", "0.1", "--record", "plant.h*", "--out", tmp_path, "--json")
    assert done.returncode == 0, done.stderr
    names = table(tmp_path).column_names
    assert "plant.h" in names and all(n == "time" or n.startswith("plant.h") for n in names)
    assert json.loads(done.stdout)["elevator_deg"]["max"] is None


@pytest.mark.parametrize("algorithm", ["gauss-seidel", "jacobi", "jacobi,hold=linear", "multi-rate,controller=5",
                                       "multi-rate,controller=3,hold=linear", "iterated"])
@pytest.mark.parametrize("decimate", [1, 7])
def test_a_run_cut_in_two_equals_the_whole(tmp_path, algorithm, decimate):
    system = closed_loop(scenarios.load("case1")).system
    whole = fly(system, 0.01, 2.1, algorithm, decimate=decimate)
    first = fly(system, 0.01, 1.05, algorithm, decimate=decimate, save=tmp_path / "at.state")
    second = fly(system, 0.01, 2.1, algorithm, decimate=decimate, restore=read_state(tmp_path / "at.state"))
    assert first.finished and second.finished and (first.ticks, second.ticks) == (105, 105)
    assert second.signals[-1].tobytes() == whole.signals[-1].tobytes()
    kept = np.isin(whole.time, second.time)
    shared = np.isin(second.time, whole.time)
    assert kept.sum() > 10 and second.signals[shared].tobytes() == whole.signals[kept].tobytes()
    assert second.time[0] == pytest.approx(1.05) and second.signals[0].tobytes() == first.signals[-1].tobytes()


def test_our_loop_cut_in_two_on_the_command_line(tmp_path):
    def ahv(*words):
        done = carried_out(*words, cwd=tmp_path)
        assert done.returncode == 0, done.stderr

    ahv("ssp", "hold", "--out", "hold.ssp")
    ahv("simulate", "hold.ssp", "--stop", "1", "--out", "whole")
    ahv("simulate", "hold.ssp", "--stop", "0.5", "--save", "at.state", "--out", "first")
    ahv("simulate", "hold.ssp", "--stop", "1", "--restore", "at.state", "--record", "*", "--out", "second")
    whole, second = table(tmp_path / "whole"), table(tmp_path / "second")
    assert second.num_rows == 51 and second.num_columns > whole.num_columns
    assert second.select(whole.column_names).equals(whole.slice(50))


def test_what_cannot_be_saved_is_told_before_it_flies(folder, tmp_path):
    system = small.pair(folder / "small_indirect.fmu")
    with pytest.raises(UsageError, match="left, right cannot: the FMU does not claim canSerializeFMUstate"):
        fly(system, 0.01, 1.0, save=tmp_path / "at.state")
    with pytest.raises(UsageError, match="need steps that are equally long; those of variable are not"):
        fly(system, 0.01, 1.0, "variable", save=tmp_path / "at.state")


# --- SSP 2.0 ----------------------------------------------------------------------------------------------------------

def two(inner, **more):
    return ssp_files.ssd(inner, version="2.0", **more)


def test_ssp_2_flies_as_ssp_1(tmp_path):
    text = ssp_files.ssd(ssp_files.system("root", ssp_files.component("a", bindings=ssp_files.inline(
        ssp_files.parameter("k", 2.5), ssp_files.parameter("n", 3, "Integer"))) + ssp_files.component("b"),
        ssp_files.connection("a.y", "b.u")))
    newer = text.replace('" version="1.0"', '" version="2.0"').replace("ssc:Real", "ssc:Float64").replace(
        "ssv:Real", "ssv:Float64").replace("ssv:Integer", "ssv:Int32").replace(
        "</ssd:System>", '<ssd:MetaData kind="general" type="text/plain" source="x.txt"/></ssd:System>', 1)
    assert "Float64" in newer and "Int32" in newer
    with load_ssp(ssp_files.write(tmp_path / "1.ssp", text)) as one, \
            load_ssp(ssp_files.write(tmp_path / "2.ssp", newer)) as other:
        assert one.connections == other.connections
        assert [c.values for c in one.components] == [c.values for c in other.components] == [{"k": 2.5, "n": 3}, {}]


def test_arrays_of_fmi_3_are_connected_and_set_as_a_whole(tmp_path):
    fmu = small3.build(tmp_path).read_bytes()
    sized = '<ssc:Dimension size="3"/>'

    def connector(name, kind):
        size = '<ssc:Dimension size="2"/>' if name == "vector_out" else sized
        return f'<ssd:Connector name="{name}" kind="{kind}"><ssc:Float64/>{size}</ssd:Connector>'

    def part(name, *connectors, bindings=""):
        return (f'<ssd:Component name="{name}" source="resources/small3.fmu"><ssd:Connectors>{"".join(connectors)}'
                f'</ssd:Connectors>{ssp_files.bound(bindings)}</ssd:Component>')

    values = ssp_files.inline('<ssv:Parameter name="v"><ssv:Float64 value="1 2 3"/></ssv:Parameter>',
                              '<ssv:Parameter name="whole"><ssv:Int32 value="7"/></ssv:Parameter>')
    inner = ssp_files.system(
        "root", part("a", connector("vector_in", "input"), bindings=ssp_files.inline(
            '<ssv:Parameter name="matrix"><ssv:Float64 value="6 5 4 3 2 1"/>'
            '<ssc:Dimension size="2"/><ssc:Dimension size="3"/></ssv:Parameter>')),
        ssp_files.connection(".v", "a.vector_in"), connector("v", "input"), values)
    path = ssp_files.write(tmp_path / "a.ssp", two(inner).replace('name="p" version="1.0"', 'name="p" version="2.0"'),
                           resources__small3_dot_fmu=fmu)
    with load_ssp(path) as found:
        assert found.components[0].values == {
            **{f"matrix[{i},{j}]": 9.0 - 3 * i - j + 1 for i in (1, 2) for j in (1, 2, 3)},
            **{f"vector_in[{i}]": float(i) for i in (1, 2, 3)}}
        assert fly(found, 0.1, 1.0).finished


@pytest.mark.parametrize("spellings", [("[m3]", "m3", "m^3", "m**3", "m³", " m3 "), ("1", "-", ""), ("degC", "°C"),
                                       ("kg.m/s2", "kg*m/s^2", "kg m / s²")])
def test_spellings_of_one_unit(spellings):
    assert len({spelling(word) for word in spellings}) == 1


@pytest.mark.parametrize("one,other", [("m", "mm"), ("m2", "m3"), ("kg.m", "kg/m"), ("s", "S"), ("[m]/s", "m.s")])
def test_other_units_have_other_spellings(one, other):
    assert spelling(one) != spelling(other)


def test_units_that_are_spelt_apart_connect_with_a_note(tmp_path, capsys):
    path = ssp_files.write(tmp_path / "test.ssp", ssp_files.ssd(ssp_files.system(
        "root", ssp_files.component("a", y="[furlong]") + ssp_files.component("b", u="furlong"),
        ssp_files.connection("a.y", "b.u"))))
    with load_ssp(path) as found:
        assert found.connections[0] == Connection("a.y", "b.u")
    assert "the units [furlong] and furlong are taken for one" in capsys.readouterr().err
