"""Samples of one's own: exact values, and one sentence with row and column for what is wrong."""
import csv
import random
import tracemalloc

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from cosim.campaign.distributions import Given, Uniform
from cosim.campaign.samples import GROUP, Column, header, load, measured
from cosim.campaign.sampling import Draw, Sampler, drawn
from cosim.campaign.store import kind_of
from cosim.errors import UsageError

KINDS = {"p.x": "Real", "p.n": "Integer", "p.on": "Boolean", "p.word": "String"}


def columns(*names):
    """Columns of these names."""
    return tuple(Column(name, name, KINDS[name]) for name in names)


def in_csv(folder, text):
    """A CSV file."""
    (folder / "draws.csv").write_text(text)
    return folder / "draws.csv"


@pytest.fixture(scope="module")
def many():
    """More rows than are in memory at a time."""
    numbers = random.Random(1)
    return [{"p.x": numbers.gauss(0, 1) * 10.0**numbers.randint(-300, 300), "p.n": numbers.randint(-2**63, 2**63 - 1),
             "p.on": numbers.random() < 0.5, "p.word": numbers.choice(["a", "b c", "ü"])} for _ in range(2 * GROUP + 5)]


@pytest.mark.parametrize("kind", ["csv", "parquet"])
def test_what_is_read_has_the_file_s_bits_in_any_part(tmp_path, many, kind):
    path = tmp_path / f"draws.{kind}"
    if kind == "csv":
        with path.open("w", newline="") as file:
            writer = csv.DictWriter(file, KINDS)
            writer.writeheader()
            writer.writerows(many)
    else:
        pq.write_table(pa.Table.from_pylist(many), path, row_group_size=1000)
    found = load(path, path.name, columns(*header(path)))
    assert found.rows == len(many) and [list(found.read(a, b)) for a, b in (
        (0, found.rows), (7, 7), (GROUP - 1, GROUP + 2), (found.rows - 1, found.rows))] == [
        many, [], many[GROUP - 1:GROUP + 2], many[-1:]]
    x, n, on, word = found.columns
    assert x.seen == {value: 1 + next(i for i, row in enumerate(many) if row["p.x"] == value)
                      for value in (min(r["p.x"] for r in many), max(r["p.x"] for r in many))}
    assert len(n.seen) == 2 and set(on.seen) == {True, False} and set(word.seen) == {"a", "b c", "ü"}


def test_rows_stand_beside_what_is_drawn(tmp_path):
    samples = load(in_csv(tmp_path, "p.x\n1\n2\n3\n"), "draws.csv", columns("p.x"))
    draws = (Draw("p.x", ("p.x",), Given(file="draws.csv", values=[1.0, 3.0])),
             Draw("p.y", ("p.y",), Uniform(distribution="uniform", low=0, high=1)))
    rows = list(drawn(Sampler("random", 5, 3, 1, samples=samples), draws, 1, 3))
    alone = list(drawn(Sampler("random", 5, 3, 1), draws[1:], 1, 3))
    assert rows == [{"p.x": x, **one} for x, one in zip((2.0, 3.0), alone)]
    assert list(drawn(Sampler("random", 5, 3, 0, samples=samples), draws[:1], 0, 2)) == [{"p.x": 1.0}, {"p.x": 2.0}]


def test_a_grid_has_every_combination_once_the_last_variable_first():
    draws = (Draw("p.x", ("p.x",), Uniform(distribution="uniform", low=0, high=1, points=3), factor=10.0),
             Draw("p.y", ("p.y",), Uniform(distribution="uniform", low=1, high=2, points=2)))
    sampler = Sampler("grid", 0, 6, 2)
    rows = [(row["p.x"], row["p.y"]) for row in drawn(sampler, draws, 0, 6)]
    assert rows == [(0.0, 1.0), (0.0, 2.0), (5.0, 1.0), (5.0, 2.0), (10.0, 1.0), (10.0, 2.0)]
    assert [(row["p.x"], row["p.y"]) for row in drawn(sampler, draws, 3, 5)] == rows[3:5]


@pytest.mark.parametrize("values,kind", [
    ([-3, 2**53], pa.float64()), ([-3, 2**53 + 1], pa.int64()), ([-2**63, 5], pa.int64()), ([1.0, 1e300], pa.float64()),
    ([True, False], pa.bool_()), (["a"], pa.string())])
def test_a_column_of_the_results_holds_whole_numbers_exactly(values, kind):
    draw = Draw("p.n", ("p.n",), Given(file="draws.csv", values=values))
    assert kind_of(draw) == kind and pa.array(values, kind, from_pandas=True).to_pylist() == values


@pytest.mark.parametrize("text,reason", [
    ("p.x,p.n\n1,2\n3,\n", "p.n in row 2 is empty; it must be a whole number"),
    ("p.x,p.n\n1,2\nab,3\n", "p.x in row 2 is ab; it must be a finite number"),
    ("p.x\n1\nnan\n", "p.x in row 2 is nan; it must be a finite number"),
    ("p.x\n1\n1e999\n", "p.x in row 2 is 1e999; it must be a finite number"),
    ("p.n\n1\n2.5\n", "p.n in row 2 is 2.5; it must be a whole number"),
    (f"p.n\n1\n{2**63}\n", f"p.n in row 2 is {2**63}; it must be a whole number"),
    ("p.on\ntrue\nmaybe\n", "p.on in row 2 is maybe; it must be true or false"),
    ("p.x,p.n\n1,2\n1,2,3\n", "row 2 has 3 values, not 2"),
    ("p.x,p.x\n1,2\n", "has two columns called p.x"),
    ("p.x,\n1,2\n", "column 2 has no name"),
    ("p.x\n", "has no rows"),
    ("", "has no columns"),
    ("\udcff", "is not text"),
])
def test_a_wrong_file_is_refused_with_row_and_column(tmp_path, text, reason):
    path = tmp_path / "draws.csv"
    path.write_bytes(text.encode(errors="surrogateescape"))
    with pytest.raises(UsageError, match=reason):
        load(path, path.name, columns(*header(path)))


@pytest.mark.parametrize("kind,values,reason", [
    ("p.x", pa.array(["1", "2"]), "p.x holds string; each value must be a finite number"),
    ("p.x", pa.array([1.0, None]), "p.x in row 2 is empty"), ("p.x", pa.array([1.0, float("nan")]), "row 2 is nan"),
    ("p.x", pa.array([1, 2**53 + 1]), f"row 2 is {2**53 + 1}"), ("p.n", pa.array([1.0]), "p.n holds double; each valu"),
    ("p.on", pa.array([1]), "p.on holds int64; each value must be true or false"),
])
def test_a_parquet_file_of_other_types_is_refused(tmp_path, kind, values, reason):
    pq.write_table(pa.table({kind: values}), tmp_path / "draws.parquet")
    with pytest.raises(UsageError, match=reason):
        load(tmp_path / "draws.parquet", "draws.parquet", columns(kind))


def test_what_is_no_table_is_refused(tmp_path):
    (tmp_path / "draws.parquet").write_text("p.x\n1\n")
    for path, reason in ((tmp_path / "none.csv", "There is no file"), (tmp_path / "draws.parquet", "cannot be read"),
                         (tmp_path, "There is no file")):
        with pytest.raises(UsageError, match=reason):
            header(path)
    (tmp_path / "draws.txt").write_text("p.x\n1\n")
    with pytest.raises(UsageError, match=r"must end with .csv or .parquet"):
        header(tmp_path / "draws.txt")


def test_measured_numbers_come_from_a_column(tmp_path):
    path = in_csv(tmp_path, "mass,other\n3,x\n1.5,y\n")
    assert measured(path, "mass") == [3.0, 1.5]
    with pytest.raises(UsageError, match="has no column mas; there are mass, other"):
        measured(path, "mas")


def test_many_rows_need_little_memory(tmp_path):
    path = tmp_path / "draws.csv"
    path.write_text("p.x\n" + "\n".join(map(str, range(100_000))))
    load(path, path.name, columns("p.x"))  # what is imported and made once
    tracemalloc.start()
    found = load(path, path.name, columns("p.x"))
    assert list(found.read(99_998, 100_000)) == [{"p.x": 99_998.0}, {"p.x": 99_999.0}]
    assert tracemalloc.get_traced_memory()[1] < 5e6
    tracemalloc.stop()
