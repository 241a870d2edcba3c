"""A mistake in a model's file is told with its line, before anything is built."""
import sys
from pathlib import Path
from zipfile import ZipFile

import pytest
from one_platform import one_platform

import cosim
import fmus

TABLE = '''"""Where a table's rows come from."""
SHARED = [
    ("gain", "parameter", "1", 2.0, 0.0, 5.0, None, "gain"),
    ("bias", "parameter", "m", 0.5, None, None, None, "bias"),
]
'''
MODEL = '''"""A gain."""
import math
from gain_table import SHARED

NAME = "Gain"
DESCRIPTION = "A gain and a limit"
VARIABLES = [
    ("u", "input", "m", 0.0, None, None, 1.0, "input"),
    ("y", "output", "m", None, None, None, 1.0, "output"),
    *SHARED,
    *((f"limit_{side}", "parameter", "m", value, None, None, None, "limit") for side, value in
      (("low", -1.0), ("high", 1.0))),
]
PRESETS = {
    "double": {"gain": 4.0},
}


def start(m, u, p):
    return []


def advance(m, t, h, x, u, p, c):
    return x


def outputs(m, t, x, u, p):
    limited = m.clip(p.gain * u.u, p.limit_low, p.limit_high)
    return {"y": limited + p.bias}
'''
U = '("u", "input", "m", 0.0, None, None, 1.0, "input")'


@pytest.fixture
def written(tmp_path):
    """Writes the model and its table with a piece of the text replaced; returns the model's file."""
    def write(old: str = "", new: str = "", table: str = TABLE) -> Path:
        if old in table:
            table = table.replace(old, new) if old else table
        else:
            assert MODEL.count(old) == 1, old
        (tmp_path / "gain_table.py").write_text(table)
        (tmp_path / "gain.py").write_text(MODEL.replace(old, new) if old else MODEL)
        return tmp_path / "gain.py"

    return write


def told(file: Path, flavour: str = "python") -> str:
    with pytest.raises(fmus.ModelError) as caught:
        fmus.build(file, flavour, file.parent / "dist")
    assert not (file.parent / "dist").exists()
    sentence = str(caught.value)
    assert sentence.endswith(".") and "\n" not in sentence and str(file.parent) not in sentence
    return sentence


PLACES = {
    "a row": (U, U.replace("input", "in"), "Gain: u: causality 'in' is none of ", "(gain.py, line 8)."),
    "a row that is none": (U, "7", "Gain: row 1 of VARIABLES, 7, is not a tuple;", "(gain.py, line 8)."),
    "a row of another file": ("2.0, 0.0", "6.0, 0.0", "Gain: gain: start 6.0 is outside [0.0, 5.0]",
                              "(gain_table.py, line 3)."),
    "another row of it": ('"bias", "parameter", "m"', '"bias", "parameter", "mm^"', "Gain: bias: in the unit 'mm^', ",
                          "(gain_table.py, line 4)."),
    "a keyword of C": ('"bias"', '"register"', "Gain: the variable name 'register' is not allowed; ",
                       "(gain_table.py, line 4)."),
    "a name that C keeps": ('"bias"', '"_Bias"', "Gain: the variable name '_Bias' is not allowed; ",
                            "(gain_table.py, line 4)."),
    "a file that Windows has not": ('NAME = "Gain"', 'NAME = "Aux"', "Aux: NAME 'Aux' is not allowed; Windows ",
                                    "has no files of that name."),
    "a preset": ('{"gain": 4.0}', '{"gain": 7.0}', "Gain: the preset double sets gain, but the value 7.0 is outside",
                 "(gain.py, line 15)."),
    "a unit of its own that is none": ("VARIABLES = [", 'UNITS = {\n    "ell": (1, "elle"),\n}\nVARIABLES = [',
                                       "Gain: UNITS: ell: in the unit 'elle', 'elle' is not known; ",
                                       "(gain.py, line 8)."),
    "a unit that there is": ("VARIABLES = [", 'UNITS = {"mm": (2, "m")}\nVARIABLES = [', "Gain: UNITS names 'mm'; a ",
                             "(gain.py, line 7)."),
    "a worth that is none": ("VARIABLES = [", 'UNITS = {"ell": 1.1}\nVARIABLES = [', "Gain: UNITS gives 1.1 for ell; ",
                             "(gain.py, line 7)."),
    "a display unit of something else": ('"u", "input", "m"', '"u", "input", "m in kN"',
        "Gain: u: in the unit 'm in kN', kN is no unit of the same quantity as m", "(gain.py, line 8)."),
    "a display unit that there is not": ('"u", "input", "m"', '"u", "input", "m in ell"',
        "Gain: u: in the unit 'm in ell', 'ell' is not known; ", "shown as it is (gain.py, line 8)."),
    "a terminal of what is no port": ("PRESETS = {", 'TERMINALS = {"all": ["u", "yy"]}\nPRESETS = {',
                                      "Gain: the terminal all has 'yy', which is no input or output (did you mean y?)",
                                      "(gain.py, line 14)."),
    "a function that is missing": ("def start(", "def begin(", "Gain: there is no function start(m, u, p)",
                                   "(gain.py)."),
    "other arguments": ("def advance(m, t, h, x, u, p, c)", "def advance(m, t, h, x)", "Gain: advance(m, t, h, x) has ",
                        "(gain.py, line 23)."),
    "an output that is missing": ('{"y": limited + p.bias}', "{}", "Gain: outputs() does not return y; ",
                                  "(gain.py, line 27)."),
    "a number that is none": ("return []", "return [math.inf]", "Gain: start() gives inf for the state 0, ",
                              "(gain.py, line 19)."),
    "an if on a symbol": ("m.clip(p.gain * u.u, p.limit_low, p.limit_high)", "max(u.u, p.limit_low)",
                          "Gain: outputs() in gain.py, line 28, decides on a symbol", "m.fmin and m.fmax instead."),
    "an import that does not travel": ("import math", "import numpy", "Gain: gain.py, line 2, imports numpy, which "
                                       "would not travel in the FMU; a model imports its own ", "may import others."),
    "a name that does not travel": ('"""Where', 'from numpy import pi\n"""Where', "Gain: gain_table.py, line 1, "
                                    "imports pi from numpy, which would not travel in the FMU; ", "may import others."),
    "a file that fails": ("import math", "import math\nmath.sqrt(-1)", "gain: <module>() in gain.py, line 3, fails "
                          "with ValueError: ", "."),
    "a file that is no Python": ("import math", "import math math", "gain: gain.py, line 2, is no Python: ", "."),
    "an import that there is not": ("import math", "import mathematics", "gain: <module>() in gain.py, line 2, "
                                    "fails with ModuleNotFoundError: No module named 'mathematics'", "."),
}


@pytest.mark.parametrize("mistake", PLACES)
def test_a_mistake_is_told_with_its_line(mistake, written):
    old, new, begins, ends = PLACES[mistake]
    sentence = told(written(old, new))
    assert sentence.startswith(begins) and sentence.endswith(ends), sentence


def test_a_row_in_another_folder_has_its_line_and_a_broken_file_nearby_is_no_hindrance(tmp_path):
    room = tmp_path / "gain_home" / "room"
    room.mkdir(parents=True)
    for folder in (room, room.parent):
        (folder / "__init__.py").write_text("")
    (room / "broken.py").write_text("def (")
    (room.parent / "gain_table.py").write_text(TABLE.replace("2.0, 0.0", "6.0, 0.0"))
    (room / "gain.py").write_text(MODEL.replace("from gain_table", "from ..gain_table"))
    assert told(room / "gain.py").endswith("start 6.0 is outside [0.0, 5.0] (gain_table.py, line 3).")


def test_the_native_flavour_may_import_what_does_not_travel(written):
    file = written("import math", "import numpy")
    with one_platform():
        assert fmus.build(file, "native", file.parent / "dist").is_file()


def test_a_file_is_built_and_forgotten_so_that_another_may_have_files_of_the_same_names(written, tmp_path):
    file, before = written(), {name for name in sys.modules if name in ("gain", "gain_table")}  # other tests have one
    first = fmus.build(file, "python", tmp_path / "first").read_bytes()
    (tmp_path / "other").mkdir()
    for source in (file, tmp_path / "gain_table.py"):
        (tmp_path / "other" / source.name).write_text(source.read_text().replace("2.0, 0.0", "3.0, 0.0"))
    other = fmus.build(str(tmp_path / "other" / "gain.py"), "python", tmp_path / "second").read_bytes()
    assert first != other
    assert fmus.build(file, "python", tmp_path / "third").read_bytes() == first
    assert {name for name in sys.modules if name in ("gain", "gain_table")} == before


def test_a_unit_of_its_own_is_written_with_its_worth(written, tmp_path):
    file = written('"u", "input", "m"', '"u", "input", "ell/s"')
    file.write_text(file.read_text().replace("PRESETS", 'UNITS = {"ell": (1.143, "m")}\nPRESETS'))
    with ZipFile(fmus.build(file, "python", tmp_path / "dist")) as archive:
        text = archive.read("modelDescription.xml").decode()
    assert '<Unit name="ell/s">\n      <BaseUnit m="1" s="-1" factor="1.143" />' in text


@pytest.mark.parametrize("flavour", ["native", "python"])
def test_a_display_unit_stands_in_the_description_and_in_sentences(flavour, written, tmp_path):
    file = written('"m", None, None, None, 1.0', '"m in mm", None, -0.5, 1.5, 1.0')
    with one_platform():
        path = fmus.build(file, flavour, tmp_path / "dist")
    with ZipFile(path) as archive:
        text = archive.read("modelDescription.xml").decode()
    assert '<DisplayUnit name="mm" factor="1000.0" />' in text and 'unit="m" displayUnit="mm"' in text
    with pytest.raises(cosim.RunError, match=r"y = 2000 mm .*1500 mm"):
        cosim.fly(cosim.System([cosim.Component("gain", path, {"bias": 2.0})]), step=0.1, stop=1)


def test_a_model_in_a_package_knows_its_neighbours(tmp_path):
    room = tmp_path / "gain_house" / "room"
    room.mkdir(parents=True)
    for folder in (room, room.parent):
        (folder / "__init__.py").write_text("")
    (room / "gain_table.py").write_text(TABLE)
    (room / "gain.py").write_text(MODEL.replace("from gain_table", "from .gain_table"))
    path = fmus.build(room / "gain.py", "python", tmp_path / "dist")
    assert path == tmp_path / "dist" / "python" / "Gain.fmu"
    assert not [name for name in sys.modules if name.startswith("gain_house")]


def test_what_is_not_there_is_told(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(fmus.ModelError, match=r"^nowhere: there is no file nowhere.py in "):
        fmus.build("nowhere.py")
    with pytest.raises(fmus.ModelError, match=r"^nowhere.model: there is no module nowhere, neither in .* installed"):
        fmus.build("nowhere.model")
