"""Connections of every type, initialisation by declared dependencies, recording, streams; and other masters."""
import subprocess
import sys
from functools import partial
from pathlib import Path

import numpy as np
import peers
import pyarrow.parquet
import pytest
import small

from cosim.errors import RunError, UsageError
from cosim.master.fly import fly
from cosim.master.recording import CHUNK_ROWS, Stream
from cosim.master.system import Component, Connection, System
from cosim.master.wiring import Signal
from cosim.ssp.write import write


@pytest.fixture(scope="module")
def build(tmp_path_factory):
    return partial(small.build, tmp_path_factory.mktemp("small"))


def chain(fmu, *links, **first):
    return System((Component("a", fmu, first), Component("b", fmu)), links)


@pytest.mark.parametrize("plain", [False, True])
def test_whole_numbers_truths_and_texts_travel(build, plain):
    links = [Connection(f"a.{n}_out", f"b.{n}_in") for n in ("whole", "truth", "text")]
    system = chain(build(), *links, whole_in=-7, truth_in=True, text_in="Höhe")
    flight = fly(system, 0.1, 0.5, "jacobi", plain=plain)
    assert flight.finished, flight.message
    assert np.all(flight["b.whole_out"] == -7) and np.all(flight["b.truth_out"] == 1)


def test_a_text_arrives(build):
    """The FMU that gets the text shows it to a third, which would refuse one that is too long."""
    fmu = build()
    links = [Connection("a.text_out", "b.text_in"), Connection("b.text_out", "c.text_in")]
    for length, words in ((4095, ""), (4096, "shows a text longer than 4095 bytes")):
        parts = (Component("a", fmu, {"text_in": "x" * length}), Component("b", fmu), Component("c", fmu))
        flight = None
        try:
            flight = fly(System(parts, tuple(links)), 0.1, 0.5)
        except RunError as error:
            assert words and words in str(error)
        else:
            assert flight.finished and not words


@pytest.mark.parametrize("plain", [False, True])
def test_factor_offset_and_whole_to_real(build, plain):
    system = chain(build(), Connection("a.whole_out", "b.u", 2.5, -1.0), whole_in=3)
    system = System((system.components[0], Component("b", build(direct=True), {"d": 1.0})), system.connections)
    assert np.all(fly(system, 0.1, 0.5, plain=plain)["b.y"][1:] - fly(system, 0.1, 0.5)["b.y1"][1:] == 6.5)


@pytest.mark.parametrize("link,sentence", [
    (Connection("a.y", "b.whole_in"), r"a.y \(Real\) cannot be connected to b.whole_in \(Integer\)"),
    (Connection("a.text_out", "b.u"), r"a.text_out \(String\) cannot be connected"),
    (Connection("a.whole_out", "b.whole_in", 2.0), "can have no factor"),
    (Connection("a.u", "b.u"), "not an output"), (Connection("a.y", "b.y"), "not an input"),
    (Connection("c.y", "b.u"), "c.y is not an output"),
])
def test_a_connection_that_does_not_fit_is_named(build, link, sentence):
    with pytest.raises(UsageError, match=sentence):
        fly(chain(build(), link), 0.1, 0.5)


def test_a_pattern_that_fits_nothing_is_named(build):
    with pytest.raises(UsageError, match=r"--record wing\.\* fits no numeric variable of a, b"):
        fly(chain(build()), 0.1, 0.5, record=["wing.*"])


def gains(fmu, first, second):
    parts = (Component("a", fmu, {"d": first, "x1": 1.0}), Component("b", fmu, {"d": second}))
    return System(parts, (Connection("a.y", "b.u"), Connection("b.y", "a.u")))


def test_a_loop_is_settled_before_the_start(build):
    flight = fly(gains(build(direct=True), 0.5, -0.8), 0.1, 0.5)
    assert flight["a.y"][0] == pytest.approx(1 / 1.4, abs=1e-12)
    assert flight["b.y"][0] == pytest.approx(-0.8 / 1.4, abs=1e-12)


def test_a_loop_that_does_not_settle_is_named(build):
    with pytest.raises(RunError, match=r"The initial values do not settle: a\.y, b\.y still change"):
        fly(gains(build(direct=True), 1.5, -1.5), 0.1, 0.5)


def test_values_travel_against_the_order_of_components(build):
    fmu, count = build(direct=True), 20
    parts = tuple(Component(f"p{i}", fmu, {"d": 1.0, "x1": 1.0 if i == count - 1 else 0.0}) for i in range(count))
    system = System(parts, tuple(Connection(f"p{i + 1}.y", f"p{i}.u") for i in range(count - 1)))
    assert fly(system, 0.1, 0.5)["p0.y"][0] == 1.0


@pytest.mark.parametrize("closed", [True, False])
def test_fifty_fmus(build, closed):
    system = small.ring(build(), 50, closed)
    compiled, plain = (fly(system, 0.01, 1.0, "jacobi", plain=p) for p in (False, True))
    assert compiled.finished and compiled.signals.tobytes() == plain.signals.tobytes()
    assert np.ptp(compiled["part49.y"]) > 1


def test_a_stream_has_every_row_and_memory_a_part(build, tmp_path, monkeypatch):
    monkeypatch.setattr("cosim.master.recording.GROUP_ROWS", 1000)
    monkeypatch.setattr("cosim.master.recording.KEPT_ROWS", 100)
    system = small.pair(build())
    whole = fly(system, 0.01, 200.0)
    part = fly(system, 0.01, 200.0, stream=tmp_path / "signals.parquet")
    table = pyarrow.parquet.read_table(tmp_path / "signals.parquet")
    written = pyarrow.parquet.ParquetFile(tmp_path / "signals.parquet").metadata
    sizes = [written.row_group(i).num_rows for i in range(written.num_row_groups)]
    assert max(sizes) <= 1000 + CHUNK_ROWS and min(sizes[:-1]) >= 1000  # as it flew, and not row by row
    assert np.array_equal(table["time"], whole.time)
    assert all(np.array_equal(table[c.name], whole[c.name]) for c in whole.columns)
    assert 100 <= len(part.time) <= 202 and part.time[-1] == whole.time[-1] and part.ticks == whole.ticks
    assert np.isin(part.time, whole.time).all() and np.ptp(np.diff(part.time)[:-1]) < 1e-9


@pytest.mark.parametrize("options", [{"algorithm": "iterated"}, {"real_time": 1e6}, {"algorithm": "variable"}])
def test_a_stream_that_gets_its_rows_one_by_one_ends_with_the_last(build, tmp_path, monkeypatch, options):
    """Memory keeps every 16th row by the end, so the last ones are in no part that is kept."""
    monkeypatch.setattr("cosim.master.recording.KEPT_ROWS", 100)
    path = tmp_path / "signals.parquet"
    flight = fly(small.pair(build()), 0.01, 15.07, stream=path, **options)
    assert flight.finished and flight.time[-1] == 15.07 and len(flight.time) <= 202
    times = pyarrow.parquet.read_table(path)["time"].to_numpy()
    assert len(times) == flight.ticks + 1 and np.isin(flight.time, times).all()


def test_a_stream_that_is_cut_short_can_be_read(build, tmp_path):
    path = tmp_path / "signals.parquet"
    flight = fly(small.pair(build(), fault=1, fault_time=0.5), 0.01, 1.0, "jacobi", stream=path)
    assert not flight.finished and pyarrow.parquet.read_table(path).num_rows == 51


def test_memory_of_a_stream_does_not_grow_with_the_run(tmp_path):
    stream = Stream([Signal("a.x", "", ""), Signal("a.y", "", "")], tmp_path / "signals.parquet")
    held, waiting = [], []
    for k in range(200):
        stream.keep(np.arange(4096.0) + 4096 * k, np.zeros((4096, 2)))
        held.append(stream.kept_rows)
        waiting.append(sum(len(times) for times, _ in stream.waiting))
    assert max(held) <= 2 * 20000 + 4096 and held[-1] >= 20000
    assert max(waiting) < 65536 and min(waiting[20:]) == 0
    stream.finish()


@pytest.mark.parametrize("master", ["libcosim", "ecos"])
def test_jacobi_is_that_of_other_masters(build, tmp_path, master):
    system, names = small.pair(build()), ["left.y", "left.y2", "right.y", "right.y2"]
    write(tmp_path / "pair.ssp", "pair", system, 0.01, 5.0)
    script = Path(__file__).with_name("foreign.py")
    subprocess.run([sys.executable, script, master, tmp_path / "pair.ssp", "0.01", "5", tmp_path / "out.npz", "{}",
                    *names],
                   check=True, timeout=60, capture_output=True, env=peers.environment())
    theirs, ours = np.load(tmp_path / "out.npz")["rows"], fly(system, 0.01, 5.0, "jacobi")
    assert theirs.shape == (501, 4)
    for name, column in zip(names, theirs.T):
        assert np.abs(column - ours[name]).max() < 1e-12, name
