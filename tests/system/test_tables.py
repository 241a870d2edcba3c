"""Inputs from a table: linear or held, in all loops and algorithms, of FMI 2.0 and 3.0."""
import fmpy
import numpy as np
import pyarrow as pa
import pyarrow.parquet
import pytest
import small
import small3

from cosim.errors import UsageError
from cosim.master import loop_compiled
from cosim.master.fly import fly
from cosim.master.system import Component, Connection, System
from cosim.master.table import Inputs, look_up, read_table

ROWS = {"time": [0.0, 0.5, 0.5, 1.0], "u": [0.0, 1.0, 3.0, 2.0]}


@pytest.fixture(scope="module")
def fmu(tmp_path_factory):
    return small.build(tmp_path_factory.mktemp("small"), direct=True)


def written(path, rows=ROWS):
    if path.suffix == ".parquet":
        pyarrow.parquet.write_table(pa.table(rows), path)
    else:
        lines = [",".join(rows), *(",".join(map(str, line)) for line in zip(*rows.values()))]
        path.write_text("\n".join(lines) + "\n")
    return read_table(path)


def one(fmu, **values):
    return System([Component("a", fmu, small.oscillator(**values))])


@pytest.mark.parametrize("time,linear,held", [
    (-1.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.25, 0.5, 0.0), (0.499, 0.998, 0.0), (0.5, 3.0, 3.0), (0.5 - 1e-13, 3.0, 3.0),
    (0.75, 2.5, 3.0), (1.0, 2.0, 2.0), (9.0, 2.0, 2.0)])
def test_between_rows_it_runs_straight_or_holds(time, linear, held):
    rows, found = np.array([[u, u] for u in ROWS["u"]]), np.empty(2)
    look_up(np.array(ROWS["time"]), rows, np.array([False, True]), time, 1e-12, np.arange(2, dtype=np.uint32), found)
    assert found.tolist() == pytest.approx([linear, held], abs=1e-12)


def test_it_is_known_before_the_start(fmu):
    inputs = Inputs(np.array([0.0, 1.0]), ["a.u", "b.v.w"], np.array([[1.0, 2.0], [3.0, 4.0]]), np.array([False, True]))
    assert inputs.at(0.5) == {"a": {"u": 2.0}, "b": {"v.w": 2.0}}


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_the_flight_is_fmpys(fmu, tmp_path, ending):
    rows = {"time": [0.0, 0.5, 1.0], "u": [0.0, 1.0, 2.5]}
    flight = fly(one(fmu), 0.1, 1.0, inputs=written(tmp_path / f"t.{ending}", rows))
    signals = np.array(list(zip(*rows.values())), [("time", float), ("u", float)])
    theirs = fmpy.simulate_fmu(fmu, stop_time=1.0, step_size=0.1, output_interval=0.1, input=signals,
                               start_values=small.oscillator(), output=["y"], fmi_type="CoSimulation")
    assert np.allclose(flight["a.y"][1:], theirs["y"][1:], rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("algorithm", ["gauss-seidel", "jacobi", "iterated", "multi-rate,a=2", "jacobi,hold=linear"])
def test_all_loops_show_the_same(fmu, tmp_path, algorithm, monkeypatch):
    table = written(tmp_path / "t.csv")
    compiled = fly(one(fmu), 0.1, 1.0, algorithm, inputs=table)
    plain = fly(one(fmu), 0.1, 1.0, algorithm, inputs=table, plain=True)
    monkeypatch.setattr(loop_compiled, "library", lambda: None)
    interpreted = fly(one(fmu), 0.1, 1.0, algorithm, inputs=table, plain=True)
    assert compiled.finished and np.ptp(compiled["a.y"]) > 0.1
    assert compiled.signals.tobytes() == plain.signals.tobytes() == interpreted.signals.tobytes()


def test_an_algorithm_that_chooses_its_steps_takes_no_table(fmu, tmp_path):
    with pytest.raises(UsageError, match="--algorithm variable takes no inputs from a table"):
        fly(one(fmu), 0.01, 1.0, "variable", inputs=written(tmp_path / "t.csv"))


def test_every_numeric_type_arrives(tmp_path):
    rows = {"time": [0.0, 0.5], "Float32_in": [0.25, 0.75], "Int64_in": [-3, 2 ** 40], "UInt8_in": [1, 255],
            "Boolean_in": [False, True], "Enumeration_in": [1, 2], "vector_in[2]": [1.5, 2.5]}
    fmu = small3.build(tmp_path)
    found = fly(System([Component("a", fmu)]), 0.25, 1.0, inputs=written(tmp_path / "t.parquet", rows))
    shown = {name: found[f"a.{name.replace('_in', '_out')}"].tolist() for name in list(rows)[1:-1]}
    assert shown["Int64_in"][1:] == [-3, -3, 2 ** 40, 2 ** 40] and shown["UInt8_in"][1:] == [1, 1, 255, 255]
    assert shown["Boolean_in"][1:] == [0, 0, 1, 1] and shown["Enumeration_in"][1:] == [1, 1, 2, 2]
    assert shown["Float32_in"][1:] == [0.25, 0.5, 0.75, 0.75]


def test_a_table_feeds_what_no_connection_does(fmu, tmp_path):
    parts = [Component("a", fmu, small.oscillator()), Component("b", fmu, small.oscillator())]
    chain = System(parts, [Connection("a.y", "b.u")])
    fed = fly(chain, 0.1, 1.0, inputs=written(tmp_path / "t.csv", {"time": [0.0], "a.u": [2.0]}))
    set_ = fly(System([parts[0].with_values({"u": 2.0}), parts[1]], [Connection("a.y", "b.u")]), 0.1, 1.0)
    assert fed.signals.tobytes() == set_.signals.tobytes()
    with pytest.raises(UsageError, match=r"has the input b\.u, which a\.y feeds"):
        fly(chain, 0.1, 1.0, inputs=written(tmp_path / "t.csv", {"time": [0.0], "b.u": [2.0]}))


def test_a_system_without_a_table_has_the_programs_that_it_had(fmu):
    from cosim.master.algorithms.base import turn
    from cosim.master.loaded import Master, open_files

    system = small.pair(fmu)
    with open_files(system) as files:
        master = Master(system, files)
        try:
            codes = [row[0] for row in turn(master, 0, False)]
            assert master.place is None and codes[0] == 0 and codes.count(3) == 1
        finally:
            master.close()
