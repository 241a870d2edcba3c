"""System files, tables, states and SSP 2.0 that are wrong: one sentence each, before anything flies."""
import json
import re
import zipfile

import numpy as np
import pyarrow as pa
import pyarrow.parquet
import pytest
import small
import ssp_files

from cosim.errors import RunError, UsageError
from cosim.master.fly import fly
from cosim.master.state import read_state
from cosim.master.system import Component, System
from cosim.master.table import read_table
from cosim.ssp.load import load_ssp
from cosim.systems.load import load_system
from cosim.systems.simulate import simulate
from cosim.vehicle import scenarios
from cosim.vehicle.closed_loop import closed_loop


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    place = tmp_path_factory.mktemp("bad")
    small.build(place)
    (place / "no.fmu").write_text("no zip")
    return place


def sentence(error):
    """The message, which is one sentence."""
    text = str(error.value)
    assert "\n" not in text and text.endswith((".", "?")) and not re.search(r"Traceback|Error\(|pydantic|pyarrow", text)
    return text


A = "components: {a: small_indirect.fmu, b: small_indirect.fmu}\n"
SYSTEMS = {
    "empty": ("", "line 1: a system file has fields such as components, not None"),
    "a list": ("- a\n", "a system file has fields such as components, not ['a']"),
    "not YAML": ("components: [\n", "line 2: this is not YAML"),
    "a tab": ("components:\n\ta: b\n", "this is not YAML"),
    "no components": ("name: x\n", "components is missing"),
    "empty components": ("components: {}\n", "line 1: components: at least 1 must be given"),
    "components as a list": ("components: [a.fmu]\n", "components: components has fields with values, not ['a.fmu']"),
    "no such FMU": ("components:\n  a: nothing.fmu\n", "line 2: components.a: There is no FMU at "),
    "a broken FMU": ("components: {a: no.fmu}\n", "line 1: components.a: "),
    "an FMU without a path": ("components: {a: {set: {}}}\n", "components.a: fmu is missing"),
    "an FMU that is a number": (
        "components: {a: 3}\n", "components.a: the path of an FMU, or fields such as fmu and set, "
                                                        "are wanted, not 3"),
    "an FMU with an empty path": ("components: {a: ''}\n", "components.a: String should have at least 1 character"),
    "a component with a dot": ("components: {a.b: small_indirect.fmu}\n", "must not have a dot"),
    "a component with a slash": (
        "components: {../a: small_indirect.fmu}\n", "The component name '../a' is not allowed"),
    "a component twice": ("components:\n  a: x.fmu\n  a: y.fmu\n", "line 3: components.a is given twice"),
    "an unknown field": (
        A + "conections: []\n", "line 2: conections: there is no such field; did you mean connections?"),
    "an unknown field of a component": ("components: {a: {fmu: small_indirect.fmu, sett: {}}}\n",
                                        "components.a.sett: there is no such field"),
    "a name that is a path": (A + "name: ../../x\n", "line 2: name: the name '../../x' is not allowed"),
    "an unknown preset": ("components: {a: {fmu: small_indirect.fmu, preset: p}}\n",
                          "components.a.preset: small_indirect.fmu has no preset p; it has none"),
    "an unknown variable": ("components: {a: {fmu: small_indirect.fmu, set: {x3: 1}}}\n",
                            "components.a.set.x3: small_indirect.fmu has no variable x3; did you mean x2?"),
    "an output that is set": ("components: {a: {fmu: small_indirect.fmu, set: {y1: 1}}}\n",
                              "a.y1 is an output and cannot be set"),
    "a value that is a list": ("components: {a: {fmu: small_indirect.fmu, set: {x1: [1]}}}\n",
                               "components.a.set.x1: a number, a truth value or a text is wanted, not [1]"),
    "a value that is not a number": (
        A + "parameters: {a.x1: fast}\n", "parameters.a.x1: a.x1 = fast is not allowed: it "
                                                                       "must be a number"),
    "a value that is nan": (A + "parameters: {a.x1: .nan}\n", "parameters.a.x1: a number, a truth value or a text"),
    "a unit that it has not": (A + "parameters: {a.x1: 3 kg}\n", "the FMU declares no unit for it"),
    "a parameter without a component": (A + "parameters: {x1: 1}\n", "a parameter is named COMPONENT.VARIABLE"),
    "a parameter of no component": (A + "parameters: {c.x1: 1}\n", "there is no component c"),
    "parameters as a list": (A + "parameters: [a.x1]\n", "parameters has fields with values, not ['a.x1']"),
    "a connection of one word": (
        A + "connections: [a.y]\n", "connections.0: a connection is written COMPONENT.OUTPUT -> "
                                                             "COMPONENT.INPUT, not 'a.y'"),
    "a connection of three": (A + "connections: [a.y -> b.u -> a.u]\n", "a connection is written COMPONENT.OUTPUT"),
    "a connection with one end": (A + "connections: [[a.y]]\n", "a list has the two ends of a connection"),
    "a connection without an end": (A + "connections: [{from: a.y}]\n", "connections.0: to is missing"),
    "a connection that is a number": (A + "connections:\n- 7\n", "line 3: connections.0: a connection is written"),
    "no such component": (A + "connections: [c.y -> b.u]\n", "connections.0: there is no component c"),
    "no component": (A + "connections: [y -> b.u]\n", "y is not of the form COMPONENT.VARIABLE"),
    "no such output": (A + "connections: [a.z -> b.u]\n", "small_indirect.fmu has no variable z"),
    "from an input": (A + "connections: [a.u -> b.u]\n", "a.u is not an output that a connection can start from"),
    "to an output": (A + "connections: [a.y -> b.y]\n", "b.y is not an input that a connection can end at"),
    "two to one input": (
        A + "connections:\n- a.y -> b.u\n- a.y1 -> b.u\n", "line 4: connections.1: b.u has more than one "
                                                                            "connection"),
    "types that do not fit": (A + "connections: [a.y -> b.text_in]\n", "a.y (Real) cannot be connected to b.text_in"),
    "a factor on a whole number": (A + "connections: [{from: a.whole_out, to: b.whole_in, factor: 2}]\n",
                                   "its connection can have no factor or offset"),
    "a factor that is a word": (A + "connections: [{from: a.y, to: b.u, factor: two}]\n",
                                "connections.0.factor: Input should be a valid number"),
    "a factor that is infinite": (A + "connections: [{from: a.y, to: b.u, factor: .inf}]\n",
                                  "connections.0.factor: Input should be a finite number"),
    "connections as a mapping": (A + "connections: {a.y: b.u}\n", "connections: Input should be a valid list"),
    "a stop before the start": (A + "experiment: {start: 2, stop: 1}\n", "experiment.stop: --stop 1 s must be after"),
    "a step that does not fit": (
        A + "experiment:\n  stop: 1\n  step: 0.3\n", "line 3: experiment.stop: --stop 1 s is not a "
                                                                             "whole number of communication steps"),
    "a step of nothing": (A + "experiment: {step: 0}\n", "experiment.step: Input should be greater than 0, not 0"),
    "an unknown algorithm": (
        A + "experiment: {algorithm: euler}\n", "experiment.algorithm: --algorithm euler is not known"),
    "a negative tolerance": (
        A + "experiment: {tolerance: -1}\n", "experiment.tolerance: Input should be greater than 0"),
    "an experiment that is a word": (A + "experiment: long\n", "experiment has fields with values, not 'long'"),
}


@pytest.mark.parametrize("text,words", SYSTEMS.values(), ids=SYSTEMS)
def test_a_system_file_that_is_wrong(text, words, folder, tmp_path):
    path = folder / "bad.yaml"
    path.write_text(text)
    with pytest.raises(UsageError) as error, load_system(path):
        pass
    assert words in sentence(error) and str(path) in str(error.value)


@pytest.mark.parametrize("name,words", [
    ("bad.txt", "is not a system: its name must end with .fmu, .ssp, .ssd, .yaml or"), ("nothing", "is not a system"),
    ("nothing.yaml", "There is no system file"), ("nothing.ssd", "There is no file"),
    ("nothing.fmu", "There is no FMU at")])
def test_a_file_that_is_no_system(name, words, folder):
    with pytest.raises(UsageError) as error, load_system(folder / name):
        pass
    assert words in sentence(error)


# --- tables -----------------------------------------------------------------------------------------------------------

TABLES = {
    "empty": ("", "cannot be read as a table"),
    "no rows": ("time,u\n", "has no rows"),
    "no time": ("u,time\n1,0\n", "The first column of"),
    "time alone": ("time\n0\n", "has no column beside time"),
    "two of one name": ("time,u,u\n0,1,2\n", "has two columns called u"),
    "a word": ("time,u\n0,1\n1,fast\n", "u in row 2 is 'fast'; it must be a number"),
    "an empty cell": ("time,u\n0,1\n1,\n", "u in row 2 is empty; it must be a number"),
    "not a number": ("time,u\n0,1\n1,nan\n", "u in row 2 is empty; it must be a number"),
    "infinite": ("time,u\n0,inf\n", "u in row 1 is inf; it must be a finite number"),
    "time goes back": ("time,u\n0,1\n2,1\n1,1\n", "time goes back from 2 s to 1 s in row 3; it must ascend"),
    "time is a word": ("time,u\nnow,1\n", "time in row 1 is 'now'; it must be a number"),
    "a short line": ("time,u\n0,1\n1\n", "cannot be read as a table"),
    "no such input": ("time,uu\n0,1\n", "uu is no input that takes numbers; did you mean u?"),
    "an output": ("time,y\n0,1\n", "y is no input that takes numbers"),
    "a text input": ("time,text_in\n0,1\n", "text_in is no input that takes numbers"),
    "an input twice": ("time,u,a.u\n0,1,2\n", "has a.u twice"),
    "a half": ("time,whole_in\n0,1\n1,1.5\n", "whole_in in row 2: a.whole_in = 1.5 is not allowed: it must be a whole"),
    "too large": ("time,whole_in\n0,1\n1,3000000000\n", "whole_in in row 2: a.whole_in = 3000000000 is not allowed"),
    "no truth": (
        "time,truth_in\n0,1\n1,2\n", "truth_in in row 2: a.truth_in = 2.0 is not allowed: it is true or false"),
    "a column without a name": ("time,\n0,1\n", "a column without a name is no input"),
}


@pytest.mark.parametrize("text,words", TABLES.values(), ids=TABLES)
def test_a_table_that_is_wrong(text, words, folder, tmp_path):
    (tmp_path / "t.csv").write_text(text)
    with pytest.raises(UsageError) as error:
        fly(System([Component("a", folder / "small_indirect.fmu")]), 0.1, 1.0, inputs=read_table(tmp_path / "t.csv"))
    assert words in sentence(error)


def test_a_table_in_another_form(tmp_path):
    (tmp_path / "bytes.csv").write_bytes(b"time,\x85\n0,1\n")
    (tmp_path / "t.parquet").write_text("not a Parquet file")
    (tmp_path / "t.xlsx").write_text("")
    pyarrow.parquet.write_table(pa.table({"time": [0.0], "u": [[1.0]]}), tmp_path / "lists.parquet")
    for name, words in (
            ("t.parquet", "cannot be read as a table"), ("t.xlsx", "its name must end with .csv or .parquet"),
            ("none.csv", "There is no table"), ("bytes.csv", "cannot be read as a table"),
            ("lists.parquet", "u in row 1 is [1.0]; it must be a number")):
        with pytest.raises(UsageError) as error:
            read_table(tmp_path / name)
        assert words in sentence(error)


# --- states -----------------------------------------------------------------------------------------------------------

@pytest.fixture(scope="module")
def state(tmp_path_factory):
    path = tmp_path_factory.mktemp("state") / "at.state"
    assert fly(closed_loop(scenarios.load("hold")).system, 0.01, 0.1, save=path).finished
    return path


@pytest.mark.parametrize("step,stop,algorithm,words", [
    (0.02, 1.0, "gauss-seidel", "--step 0.02 is not that of"),
    (0.01, 0.1, "gauss-seidel", "--stop 0.1 s must be after 0.1 s"),
    (0.01, 1.0, "jacobi", "--algorithm jacobi is not that of")])
def test_a_flight_that_cannot_go_on(state, step, stop, algorithm, words):
    with pytest.raises(UsageError) as error:
        fly(closed_loop(scenarios.load("hold")).system, step, stop, algorithm, restore=read_state(state))
    assert words in sentence(error)


def test_another_system_does_not_go_on(state):
    system = closed_loop(scenarios.load("hold"), "backstepping").system
    with pytest.raises(UsageError) as error:
        fly(system, 0.01, 1.0, restore=read_state(state))
    assert "controller is not the same FMU in the system and in" in sentence(error)


@pytest.mark.parametrize("damage", [lambda data: b"", lambda data: b"no", lambda data: data[:len(data) // 2],
                                    lambda data: data.replace(b"signals.npy", b"sagnals.npy")])
def test_a_state_that_is_none(state, tmp_path, damage):
    (tmp_path / "bad.state").write_bytes(damage(state.read_bytes()))
    with pytest.raises(UsageError) as error:
        read_state(tmp_path / "bad.state")
    assert "is no state that `ahv simulate --save` wrote" in sentence(error)


def said(**changes):
    """An array of JSON: what a state says about itself, with changes."""
    return lambda arrays: np.frombuffer(json.dumps({**json.loads(arrays["about"].tobytes()), **changes}).encode(),
                                        np.uint8)


@pytest.mark.parametrize("name, made", [
    ("about", said(tick=float("inf"))), ("about", said(tick=-5)), ("about", said(tick=2.5)), ("about", said(step="x")),
    ("about", said(components=[1])), ("slots", lambda arrays: np.frombuffer(b"[" * 100_000, np.uint8)),
    ("signals", lambda arrays: arrays["signals"].astype(str)), ("signals", lambda arrays: np.float64(3.0)),
    ("signals", lambda arrays: np.zeros((len(arrays["signals"]), 3))), ("clock", lambda arrays: np.zeros(0)),
    ("fmu_0", lambda arrays: arrays["fmu_0"].astype(float)),
])
def test_a_state_that_was_changed_on_purpose(state, tmp_path, name, made):
    with np.load(state) as file:
        arrays = {key: file[key] for key in file.files}
    with (tmp_path / "bad.state").open("wb") as file:
        np.savez(file, **{**arrays, name: made(arrays)})
    with pytest.raises(UsageError, match="is no state that"):
        read_state(tmp_path / "bad.state")


def test_a_state_with_an_array_larger_than_any_memory(tmp_path):
    head = b"{'descr': '<f8', 'fortran_order': False, 'shape': (1000000000000,), }".ljust(117) + b"\n"
    with zipfile.ZipFile(tmp_path / "bad.state", "w") as archive:
        archive.writestr("about.npy", b"\x93NUMPY\x01\x00" + len(head).to_bytes(2, "little") + head)
    with pytest.raises(UsageError, match="is no state that"):
        read_state(tmp_path / "bad.state")


@pytest.mark.parametrize("start", [float("-inf"), float("inf"), float("nan"), -1.7e308])
def test_a_start_that_cannot_be(native_fmus, tmp_path, start):
    with pytest.raises(UsageError):
        simulate(native_fmus["AhvPlant"], None, None, None, tmp_path / "out", start=start)
    np.savez(tmp_path / "other.npz", x=np.zeros(3))
    with pytest.raises(UsageError, match="is no state"):
        read_state(tmp_path / "other.npz")


def test_options_that_have_no_meaning_beside_a_state(state, folder, tmp_path):
    for more, words in (({"start": 1.0}, "--start and --restore exclude"),
                        ({"values": ["x=1"]}, "--set and --restore exclude")):
        with pytest.raises(UsageError) as error:
            simulate(folder / "small_indirect.fmu", None, 1.0, None, tmp_path / "out", restore=state, **more)
        assert words in sentence(error)
    with pytest.raises(UsageError, match="is not a file in a folder that exists"):
        simulate(folder / "small_indirect.fmu", 0.1, 1.0, None, tmp_path / "out", save=tmp_path / "no" / "at.state")
    with pytest.raises(UsageError, match="There is no state"):
        simulate(folder / "small_indirect.fmu", 0.1, 1.0, None, tmp_path / "out", restore=tmp_path / "none")


def test_a_state_that_finds_no_room_is_the_flights_failure(tmp_path):
    flight = fly(closed_loop(scenarios.load("hold")).system, 0.01, 0.1, save=tmp_path / "gone" / "at.state")
    assert not flight.finished and "at.state cannot be written" in flight.message and len(flight.time) == 11


# --- the command line -------------------------------------------------------------------------------------------------

@pytest.mark.parametrize("more,words", [
    ({"values": ["x1"]}, "--set x1 is not of the form VARIABLE=VALUE"),
    ({"values": ["zzz=1"]}, "has no variable zzz"),
    ({"record": ["zzz"]}, "--record small_indirect.zzz fits no numeric"),
    ({"tolerance": -1.0}, "--tolerance -1 must be a positive number"),
    ({"start": 3.0}, "--stop 1 s must be after the start"),
    ({"inputs": "none.csv"}, "There is no table none.csv")])
def test_words_that_do_not_fit_one_fmu(folder, tmp_path, more, words):
    from pathlib import Path

    if "inputs" in more:
        more = {"inputs": Path(more["inputs"])}
    with pytest.raises(UsageError) as error:
        simulate(folder / "small_indirect.fmu", 0.1, 1.0, None, tmp_path / "out", **more)
    assert words in sentence(error)


# --- SSP 2.0 ----------------------------------------------------------------------------------------------------------

def newer(parameter=None, connection="", connector=""):
    bindings = "" if parameter is None else ssp_files.inline(parameter).replace(
        'name="p" version="1.0"', 'name="p" version="2.0"')
    return ssp_files.ssd(ssp_files.system("root", ssp_files.component("a", bindings=bindings, more=connector)
                                          + ssp_files.component("b"), connection), version="2.0")


NEWER = {
    "a later version": (
        newer().replace('" version="2.0"', '" version="3.0"'), "is an SSP 3.0 system structure description; "
                                                                              "SSP 1.0 and 2.0 are what runs here"),
    "an unknown element": (
        newer().replace("<ssd:Elements>", "<ssd:Elemente>").replace("</ssd:Elements>", "</ssd:Elemente>"),
                           "is not a valid SSP 2.0 system structure description"),
    "a word for a number": (newer('<ssv:Parameter name="k"><ssv:Float64 value="big"/></ssv:Parameter>'),
                            "is not a valid SSP 2.0 parameter set"),
    "an array for a number": (newer('<ssv:Parameter name="n"><ssv:Int32 value="1 2"/><ssc:Dimension size="3"/>'
                                    '</ssv:Parameter>'), "The parameter n has 2 values for 3 elements"),
    "a size that is a connector": (newer('<ssv:Parameter name="n"><ssv:Int32 value="1 2"/>'
                                         '<ssc:Dimension sizeConnector="m"/></ssv:Parameter>'),
                                   "The parameter n has a dimension without a fixed size"),
    "indices": (newer(connection=ssp_files.connection("a.y", "b.u", startIndices="1")),
                "The connection from a.y to b.u chooses elements of arrays by indices"),
    "a clock": (newer(connector='<ssd:Connector name="c" kind="input"><ssc:Clock/></ssd:Connector>'),
                "c has a Clock, which is not supported"),
    "a binary": (newer(connector='<ssd:Connector name="c" kind="input"><ssc:Binary mime-type="x"/></ssd:Connector>'),
                 "a has the Binary connector c, which is not supported"),
    "a type that it is not": (
        newer(connector='<ssd:Connector name="whole" kind="output"><ssc:Float64/></ssd:Connector>'),
                              "a.whole is Real in SystemStructure.ssd and Integer in Gain.fmu"),
    "scheduled execution": (newer().replace('source="resources/Gain.fmu"', 'source="resources/Gain.fmu" '
                                            'implementation="ScheduledExecution"', 1), "is not a valid SSP 2.0"),
    "another package": (newer().replace('source="resources/Gain.fmu"', 'source="resources/Gain.fmu" '
                                        'type="application/x-ssp-package"', 1),
        "a is of type application/x-ssp-package"),
}


@pytest.mark.parametrize("text,words", NEWER.values(), ids=NEWER)
def test_an_ssp_of_version_2_that_is_wrong(text, words, tmp_path):
    with pytest.raises((UsageError, RunError)) as error:
        load_ssp(ssp_files.write(tmp_path / "bad.ssp", text))
    assert words in sentence(error)
