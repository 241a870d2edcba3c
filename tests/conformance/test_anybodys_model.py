"""A model that lies anywhere becomes an FMU of both flavours, in which its own files travel."""
import sys
import zipfile
from importlib import import_module, invalidate_caches

import numpy as np
import pytest
from flying import running, step

import cosim.cli.app as cli
from fmus.builder import build
from fmus.check_model import ModelError

EQUATIONS = '''"""A tank drains through a valve."""


def drained(m, level, rate, h):
    return level * m.exp(-rate * h)
'''
MODEL = '''"""A tank."""
{import_line}

NAME = "Tank"
DESCRIPTION = "A tank with a valve"
VARIABLES = [
    ("flow", "input", "1/s", 0.0, None, None, None, "inflow"),
    ("open", "input", "", False, None, None, None, "valve open"),
    ("level", "output", "1", None, 0.0, None, 1.0, "level"),
    ("rate", "parameter", "1/s", 2.0, 0.0, 5.0, None, "rate of the outflow"),
]
PRESETS = {{"slow": {{"rate": 1.0}}}}


def start(m, u, p):
    return [1.0]


def advance(m, t, h, x, u, p, c):
    return [m.where(u.open, drained(m, x[0], p.rate, h), x[0]) + u.flow * h]


def outputs(m, t, x, u, p):
    return {{"level": x[0]}}
'''
LAYOUTS = {
    "tank_alone": ("tank_alone.py", "tank_equations.py", "from tank_equations import drained"),
    "tank_room.model": ("tank_room/model.py", "tank_room/equations.py", "from .equations import drained"),
    "tank_house.room.model": ("tank_house/room/model.py", "tank_house/equations.py",
                              "from tank_house.equations import drained"),
}


def written(folder, name, import_line=None):
    """The model `name` in its layout below `folder`; the names of its two files."""
    model, equations, line = LAYOUTS[name]
    for file, text in ((model, MODEL.format(import_line=import_line or line)), (equations, EQUATIONS)):
        (folder / file).parent.mkdir(parents=True, exist_ok=True)
        (folder / file).write_text(text)
    return model, equations


@pytest.fixture
def elsewhere(tmp_path, monkeypatch):
    """A folder that modules are imported from, all of them forgotten afterwards."""
    before = set(sys.modules)
    monkeypatch.syspath_prepend(tmp_path)
    invalidate_caches()
    yield tmp_path
    for name in set(sys.modules) - before:
        if name.startswith("tank_"):
            del sys.modules[name]


@pytest.mark.parametrize("flavour", ["python", "native"])
@pytest.mark.parametrize("name", LAYOUTS)
def test_a_model_from_anywhere_flies(name, flavour, elsewhere, tmp_path):
    model, equations = written(elsewhere, name)
    path = build(import_module(name), flavour, tmp_path / "dist")
    assert path == tmp_path / "dist" / flavour / "Tank.fmu"
    with zipfile.ZipFile(path) as archive:
        page = archive.read("documentation/index.html").decode()
    assert all(f"<h3>{file.removesuffix('.py').replace('/', '.')}</h3>" in page for file in (model, equations))
    for file in (model, equations):
        (elsewhere / file).unlink()
    for module in [name for name in sys.modules if name.startswith("tank_")]:
        del sys.modules[module]
    with running(path) as tank:
        step(tank, 0.0, 0.1)
        assert tank.get(["level"])[0] == 1.0
        tank.set({"open": True, "flow": 0.5})
        step(tank, 0.1, 0.1)
        assert tank.get(["open"])[0]
        assert tank.get(["level"])[0] == pytest.approx(np.exp(-0.2) + 0.05, rel=1e-12)


def test_both_flavours_of_one_model_are_alike(elsewhere, tmp_path):
    written(elsewhere, "tank_room.model")
    levels = []
    for flavour in ("python", "native"):
        with running(build("tank_room.model", flavour, tmp_path / "dist")) as tank:
            tank.set({"open": True})
            for k in range(5):
                step(tank, 0.1 * k, 0.1)
            levels.append(tank.get(["level"])[0])
    assert levels[0] == pytest.approx(levels[1], rel=1e-15)


def test_a_file_imported_as_a_whole_is_a_mistake_with_its_line(elsewhere, tmp_path):
    written(elsewhere, "tank_alone", "import tank_equations\nfrom tank_equations import drained")
    with pytest.raises(ModelError, match=r"^Tank: tank_alone\.py, line 2, imports tank_equations, a file of the model, "
                                         r"as a whole; write from tank_equations import NAME\.$"):
        build("tank_alone", "python", tmp_path / "dist")


def test_the_command_says_the_mistake_and_ends_with_2(elsewhere, monkeypatch, capsys):
    written(elsewhere, "tank_room.model")
    file = elsewhere / "tank_room" / "model.py"
    file.write_text(file.read_text().replace('"1/s", 2.0', '"1/furlong", 2.0'))
    monkeypatch.setattr("cosim.cli.build.MODELS", {"Tank": "tank_room.model"})
    assert cli.done(["build", "--flavour", "python"]) == 2
    assert capsys.readouterr().err.startswith("ahv: Tank: rate: in the unit '1/furlong', 'furlong' is not known; ")
