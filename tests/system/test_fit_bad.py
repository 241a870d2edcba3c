"""Requests of `ahv fit` that cannot be carried out: one sentence each that names what is wrong and what is allowed."""
import pytest
import small
from fitting import measured, one

import cosim
from cosim.cli.app import done

ROWS = "0,1.0,0.0\n0.1,0.9,-0.4\n0.2,0.7,-0.8\n"
GOOD = "time,y,y2\n" + ROWS


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A folder with the FMU, f.csv with a good table, and a chain of two."""
    folder = tmp_path_factory.mktemp("bad")
    small.build(folder)
    measured(folder / "good.csv", folder / "small_indirect.fmu")
    (folder / "chain.yaml").write_text("components: {a: small_indirect.fmu, b: small_indirect.fmu}\n"
                                       "connections: [a.y -> b.u]\nexperiment: {step: 0.02}\n")
    (folder / "chain.csv").write_text("time,a.y\n0,1\n1,2\n2,2\n")
    return folder


TABLES = [  # what f.csv has, what is said
    ("", "f.csv cannot be read as a table"),
    ("time,y\n0,1\n", "f.csv has one row; a fit needs at least two."),
    ("time,y\n", "f.csv has no rows."),
    ("time,y\n0,1\n0.2,2\n0.1,3\n", "f.csv: time goes back from 0.2 s to 0.1 s in row 3; it must ascend."),
    ("time,y\n0,1\n,2\n", "f.csv: time in row 2 is empty; it must be a number."),
    ("time,y\n0,1\n0.1,nan\n", "f.csv: y in row 2 is nan; it must be a finite number."),
    ("time,y\n0,1\n0.1,inf\n", "f.csv: y in row 2 is inf; it must be a finite number."),
    ("time,y\n0,1\n0.1,high\n", "f.csv: y in row 2 is 'high'; it must be a number."),
    ("y,time\n0,1\n0.1,2\n", "The first column of f.csv must be called time, in seconds; it is called y."),
    ("time,yy\n0,1\n0.1,2\n",
     "f.csv: no column is a signal of the system with a value; its columns are yy; did you mean y?"),
    ("time,a11,text_out\n0,1,2\n0.1,2,3\n",
     "f.csv: no column is a signal of the system with a value; its columns are a11, text_out"),
    ("time,y\n0,\n0.1,\n", "f.csv: no column is a signal of the system with a value; its columns are y"),
    ("time,u\n0,1\n0.1,2\n", "f.csv: no column is a signal of the system with a value; its columns are u"),
    ("time,u,y\n0,,1\n0.1,,2\n", "f.csv: the input small_indirect.u has no value."),
    ("time,truth_in,y\n0,2,1\n0.1,0,2\n",
     "f.csv, small_indirect.truth_in in row 1: small_indirect.truth_in = 2.0 is not allowed: it is "
                                          "true or false."),
    ("time,y\n-1,1\n0.1,2\n", "f.csv begins at -1 s, before the flight, which begins at 0 s; --start sets another."),
    ("time,y\n0,1\n0,2\n", "f.csv ends at 0 s, where the flight begins."),
    ("time,y\n0,1\n0.1,2\n",
     "3 parameters cannot be found from 2 measured values: more values than parameters are needed."),
]
OPTIONS = [  # words, what is said
    (["--parameter", "a21x"], "--parameter a21x: there is no variable a21x; did you mean a21?"),
    (["--parameter", "nobody.a21"], "--parameter nobody.a21: there is no variable nobody.a21"),
    (["--parameter", "y"], "--parameter y: small_indirect.y is a continuous output, which cannot be set."),
    (["--parameter", "fault"],
     "--parameter fault: small_indirect.fault is of type Integer; only real numbers can be fitted."),
    (["--parameter", "a21=-1:-2"], "--parameter a21=-1:-2: the lower bound -1 must be below the upper bound -2."),
    (["--parameter", "a21=-9:-2:-1"], "--parameter a21=-9:-2:-1: the start -9 is not between -2 and -1."),
    (["--parameter", "a21=-9:-5"], "--parameter a21=-9:-5: the start -1 is not between -9 and -5."),
    (["--parameter", "a21="],
     "--parameter a21= is not of the form [FILE:]COMPONENT.VARIABLE[=START|=LOW:HIGH|=START:LOW:HIGH]."),
    (["--parameter", "a21=1:2:3:4"], "--parameter a21=1:2:3:4 is not of the form"),
    (["--parameter", "a21=low"], "small_indirect.a21 = low is not allowed"),
    (["--parameter", "a21=nan"], "small_indirect.a21 = nan is not allowed"),
    (["--parameter", "a21", "--parameter", "a21=3"],
     "--parameter small_indirect.a21: small_indirect.a21 is fitted twice."),
    (["--parameter", "a21", "--parameter", "f.csv:a21"],
     "--parameter f.csv:small_indirect.a21: small_indirect.a21 is fitted twice."),
    (["--parameter", "g.csv:a21"], "g.csv:a21: there is no data file g.csv; did you mean f.csv?"),
    (["--parameter", "a21", "--set", "f.csv:a21=1"],
     "--parameter small_indirect.a21: --set f.csv:small_indirect.a21 sets it for one flight."),
    (["--parameter", "a21", "--set", "g.csv:a22=1"], "g.csv:a22=1: there is no data file g.csv; did you mean f.csv?"),
    (["--parameter", "a21", "--set", "f.csv:a2x=1"], "small_indirect.fmu has no variable a2x; did you mean"),
    (["--parameter", "a21", "--set", "f.csv:a22"], "--set a22 is not of the form VARIABLE=VALUE."),
    (["--parameter", "a21", "--signal", "yy"], "--signal yy: there is no such signal; did you mean y?"),
    (["--parameter", "a21", "--signal", "y", "--signal", "y1"], "--signal y1: no data file has such a column."),
    (["--parameter", "a21", "--signal", "y1"], "f.csv: no column is one of y1; its columns are y, y2."),
    (["--parameter", "a21", "--signal", "u"],
     "--signal u: small_indirect.u is an input that nothing feeds; the data drive it."),
    (["--parameter", "a21", "--signal", "y:0"],
     "--signal y:0: the noise level must be a positive number, in the signal's unit."),
    (["--parameter", "a21", "--signal", "y:loud"], "--signal y:loud: the noise level must be a positive number"),
    (["--parameter", "a21", "--signal", "y", "--signal", "y:1"], "--signal y:1: small_indirect.y is named twice."),
    (["--parameter", "a21", "f.csv"], "f.csv is given twice."),
    (["--parameter", "a21", "g.csv"], "There is no table g.csv."),
    (["--parameter", "a21", "--step", "0"], "--step 0 must be a positive number of seconds."),
    (["--parameter", "a21", "--start", "5"], "f.csv begins at 0 s, before the flight, which begins at 5 s"),
    (["--parameter", "a21", "--time-limit", "0"], "--time-limit 0 must be a positive number of seconds."),
    (["--parameter", "a21", "--tolerance", "-1"], "--tolerance -1 must be a positive number."),
    (["--parameter", "a21", "--algorithm", "magic"], "--algorithm magic is not known"),
    (["--parameter", "a21", "--controller", "resilient"],
     "--controller, --preset, --flavour, --plant and --uncertainty are for scenarios"),
    ([], "A fit needs a table of measured signals, and a parameter to find: --parameter."),
]


def refused(words, capfd):
    """What a refused command line says."""
    assert done(["fit", *words]) == 2
    said = capfd.readouterr().err
    assert said.startswith("ahv: ") and said.count("\n") == 1 and said.endswith((".\n", "?\n")), said
    return said.removeprefix("ahv: ")


@pytest.mark.parametrize("text,sentence", TABLES, ids=[text[:30] for text, _ in TABLES])
def test_tables_that_do_not_fit(place, monkeypatch, capfd, text, sentence):
    monkeypatch.chdir(place)
    (place / "f.csv").write_text(text)
    free = [word for name in ("a21", "a22", "c1") for word in ("--parameter", name)]
    assert refused(["small_indirect.fmu", "f.csv", *free, "--step", "0.02"], capfd).startswith(sentence)


@pytest.mark.parametrize("words,sentence", OPTIONS, ids=[" ".join(words) for words, _ in OPTIONS])
def test_options_that_do_not_fit(place, monkeypatch, capfd, words, sentence):
    monkeypatch.chdir(place)
    (place / "f.csv").write_text(GOOD)
    assert refused(["small_indirect.fmu", "f.csv", *words, *([] if "--step" in words else ["--step", "0.02"])],
                   capfd).startswith(sentence)


@pytest.mark.parametrize("words,sentence", [
    (["chain.yaml", "chain.csv", "--parameter", "b.u"], "--parameter b.u: b.u is an input that a.y feeds."),
    (["chain.yaml", "chain.csv", "--parameter", "a21"], "--parameter a21: there is no variable a21; did you mean "),
    (["nowhere.yaml", "chain.csv", "--parameter", "a21"], "nowhere.yaml is neither a scenario"),
    (["nowhere.fmu", "chain.csv", "--parameter", "a21"], "There is no FMU at nowhere.fmu"),
    (["chain.csv", "chain.csv", "--parameter", "a21"], "chain.csv"),
    (["hold", "chain.csv", "--parameter", "plant.mass"], "chain.csv: no column is a signal of the system"),
    (["hold", "chain.csv", "--parameter", "plant.V_start"],
     "--parameter plant.V_start: the scenario's command would follow"),
    (["hold", "chain.csv", "--parameter", "plant.mass", "--start", "1"],
     "--start and --tolerance are for systems from"),
])
def test_systems_that_do_not_fit(place, monkeypatch, capfd, words, sentence):
    monkeypatch.chdir(place)
    assert refused(words, capfd).startswith(sentence)
    assert not any(path.is_file() for path in (place / "results").rglob("*"))


def test_columns_that_are_left_out_and_flights_that_begin_late_are_told(place, capfd):
    path = place / "g.csv"
    path.write_text("time,a.y,speed,a.a22\n1,1.0,0,1\n1.1,0.9,0,1\n1.2,0.7,0,1\n")
    cosim.fit(one(place / "small_indirect.fmu"), [path], ["a.c1"])
    said = capfd.readouterr().err
    assert f"{path} begins at 1 s, long after the flight, which begins at 0 s; --start sets another." in said
    assert f"{path}: speed is no signal of the system and is left out" in said
    assert f"{path}: a.a22 is a parameter and no signal; it is left out. --set {path}:a.a22=VALUE sets it." in said


def test_a_flight_that_begins_as_long_before_as_it_is_measured_is_not_told(place, capfd):
    path = place / "late.csv"
    path.write_text("time,a.y\n1,1.0\n1.5,0.9\n2,0.7\n")
    cosim.fit(one(place / "small_indirect.fmu"), [path], ["a.c1"])
    assert "long after the flight" not in capfd.readouterr().err
