"""`import cosim` as a library: systems, flights, SSP files."""
import gc
import inspect
import os
import pickle
import signal
import subprocess
import sys
import threading
from dataclasses import FrozenInstanceError, replace
from pathlib import Path

import numpy as np
import pyarrow.parquet
import pytest
import small
import ssp_files
from places import ROOT

import cosim

HEAVY = ("numpy", "fmpy", "numba", "matplotlib", "dask", "casadi", "pandas", "pyarrow", "rich", "scipy", "IPython")


def modules_after(code):
    """Which of HEAVY a fresh interpreter has imported after `code`."""
    tell = f"{code}\nimport sys\nprint(*(m for m in {HEAVY} if m in sys.modules))"
    return subprocess.run([sys.executable, "-c", tell], check=True, capture_output=True, text=True).stdout.split()


@pytest.fixture(scope="module")
def fmu(tmp_path_factory):
    return small.build(tmp_path_factory.mktemp("small"))


# --- what is imported when ------------------------------------------------------------------------------

@pytest.mark.parametrize("code", [
    "import cosim",
    "import cosim; cosim.System([cosim.Component('a', 'a.fmu')], [cosim.Connection('a.y', 'a.u')]); cosim.UsageError",
    "import cosim; cosim.fly, cosim.check, cosim.Report, dir(cosim)"])
def test_nothing_heavy_is_imported_before_it_is_needed(code):
    assert not {*modules_after(code)} - {"rich" if "Report" in code else ""}


@pytest.mark.parametrize("words", [["--version"], ["--help"], ["simulate", "--help"], ["campaign", "--help"],
                                   ["check", "--explain", "archive.extension"]], ids=" ".join)
def test_commands_that_only_tell_something_import_nothing_heavy(words):
    code = f"""
import contextlib, io
from cosim.cli.app import done
with contextlib.suppress(SystemExit), contextlib.redirect_stdout(io.StringIO()):
    done({words})"""
    assert not {*modules_after(code)} - {"rich"}  # which typer prints its help with


def test_a_worker_of_a_campaign_needs_nothing_that_reads_or_draws_tables():
    assert not {"matplotlib", "numba", "pandas", "pyarrow", "scipy"} & {*modules_after("import cosim.campaign.worker")}


def test_a_flight_needs_no_package_of_others_rooms(fmu):
    code = f"import cosim; cosim.fly(cosim.System([cosim.Component('a', {str(fmu)!r})]), step=0.1, stop=1, plain=True)"
    assert modules_after(code) == ["numpy", "fmpy"]
    assert modules_after(code.replace(", plain=True", "")) == ["numpy", "fmpy"]


def test_every_name_is_there_and_documented():
    for name in cosim.WHERE:
        assert name in dir(cosim) and inspect.getdoc(getattr(cosim, name)), name
    with pytest.raises(AttributeError, match="no attribute 'flie'"):
        cosim.flie  # noqa: B018


def test_editors_see_every_name():
    stubs = inspect.getsource(cosim).partition("if TYPE_CHECKING:")[2].partition("WHERE")[0]
    assert {line.split()[-1] for line in stubs.splitlines() if " as " in line} == {*cosim.WHERE}
    for line in stubs.split("\n"):
        if " as " in line:
            _, room, _, name, *_ = line.split()
            assert cosim.WHERE[name] == room.removeprefix("."), line


# --- systems --------------------------------------------------------------------------------------------

def test_a_system_takes_lists_and_paths_as_text():
    component = cosim.Component("a", "folder/a.fmu")
    system = cosim.System([component], [cosim.Connection("a.y", "a.u")])
    assert component.fmu == Path("folder/a.fmu") and component.values == {}
    assert system.components == (component,) and isinstance(system.connections, tuple)
    assert hash(cosim.Connection("a.y", "a.u")) == hash(system.connections[0])
    with pytest.raises(FrozenInstanceError):
        component.name = "b"
    assert replace(system, step=0.5).step == 0.5 and pickle.loads(pickle.dumps(system)) == system


def test_a_component_keeps_its_own_values():
    values = {"mass": 300.0}
    component = cosim.Component("a", "a.fmu", values)
    values["mass"] = 1.0
    assert component.values == {"mass": 300.0}
    assert component.with_values({"k": 2.0}).values == {"mass": 300.0, "k": 2.0}


A = cosim.Component("a", "a.fmu")
WRONG_SYSTEMS = {
    "a dot in a name": (lambda: cosim.Component("a.b", "a.fmu"), "'a.b' is not allowed: it must be a text without"),
    "no path": (lambda: cosim.Component("a", 3), "3 is not the path of a file"),
    "values that are no dict": (lambda: cosim.Component("a", "a.fmu", [1]), r"The values of a are \[1\]"),
    "one component alone": (lambda: cosim.System(A), "components must be a list of cosim.Component"),
    "a component that is none": (lambda: cosim.System(["a.fmu"]), "must be cosim.Component each; 'a.fmu' is not"),
    "a connection that is none": (lambda: cosim.System([A], [("a.y", "a.u")]), "must be cosim.Connection each"),
    "two of a name": (lambda: cosim.System([A, A]), "Two components are called a"),
}


@pytest.mark.parametrize("build,sentence", WRONG_SYSTEMS.values(), ids=WRONG_SYSTEMS)
def test_a_wrong_system_is_refused_by_name(build, sentence):
    with pytest.raises(cosim.UsageError, match=sentence):
        build()


# --- flying ---------------------------------------------------------------------------------------------

WRONG_ARGUMENTS = {
    "step": ({"step": "a"}, "step = 'a' is not allowed: it must be a number above 0"),
    "stop": ({"stop": -1}, "stop = -1 is not allowed"),
    "truth": ({"step": True}, "step = True is not allowed"),
    "not a number": ({"stop": float("nan")}, "stop = nan is not allowed"),
    "a stop that does not fit": ({"stop": 1.05}, "^stop 1.05 s is not a whole number of communication steps of 0.1 s"),
    "algorithm": ({"algorithm": "magic"}, "^algorithm magic is not known; there are gauss-seidel"),
    "algorithm's type": ({"algorithm": 3}, "algorithm = 3 is not allowed"),
    "record as text": ({"record": "a.*"}, r"record = 'a.\*' is not allowed: it must be a list of texts"),
    "record as a number": ({"record": 3}, "record = 3 is not allowed"),
    "record": ({"record": ["left.z*"]}, r"^record left.z\* fits no numeric variable of left, right"),
    "decimate": ({"decimate": 0}, "decimate = 0 is not allowed: it must be 1, 2, 3"),
    "time limit": ({"time_limit": 0}, "time_limit = 0 is not allowed"),
    "stream": ({"stream": "nowhere/signals.parquet"}, "it must be a file in a folder that exists"),
    "progress": ({"progress": "yes"}, "progress = 'yes' is not allowed: it must be True, False or a function"),
    "pace": ({"real_time": "fast"}, "real_time = 'fast' is not allowed"),
}


@pytest.mark.parametrize("arguments,sentence", WRONG_ARGUMENTS.values(), ids=WRONG_ARGUMENTS)
def test_a_wrong_argument_is_refused_in_one_sentence(arguments, sentence, fmu):
    with pytest.raises(cosim.UsageError, match=sentence) as caught:
        cosim.fly(small.pair(fmu), **{"step": 0.1, "stop": 1.0, **arguments})
    assert "--" not in str(caught.value)


@pytest.mark.parametrize("value", [[1.0], None, "heavy"])
def test_a_value_that_is_no_number_is_refused_by_name(value, fmu):
    system = cosim.System([cosim.Component("a", fmu, {"x1": value})])
    with pytest.raises(cosim.UsageError, match=r"a.x1 = .* is not allowed: it must be a number"):
        cosim.fly(system, step=0.1, stop=1)


def test_what_is_no_system_or_has_nothing_in_it_is_refused():
    with pytest.raises(cosim.UsageError, match=r"system = 'loop.ssp' is not allowed: it must be a cosim.System"):
        cosim.fly("loop.ssp", step=0.1, stop=1)
    with pytest.raises(cosim.UsageError, match="no components"):
        cosim.fly(cosim.System([]), step=0.1, stop=1)


def test_a_step_that_nobody_gives_is_asked_for(fmu):
    with pytest.raises(cosim.UsageError, match="step is missing: give it in seconds"):
        cosim.fly(small.pair(fmu), stop=1)


def test_the_systems_own_step_and_stop_are_taken_where_none_is_given(fmu):
    system = replace(small.pair(fmu), step=0.25, stop=1.0)
    assert cosim.fly(system).time.tolist() == [0, 0.25, 0.5, 0.75, 1]
    assert cosim.fly(system, 0.5, stop=2).time.tolist() == [0, 0.5, 1, 1.5, 2]


def test_options_reach_the_master(fmu):
    system = small.pair(fmu)
    flight = cosim.fly(system, step=0.1, stop=1, algorithm="jacobi", record=("left.*",), decimate=5)
    assert list(flight.time) == [0, 0.5, 1] and all(name.startswith("left.") for name in flight)
    gauss = cosim.fly(system, step=0.1, stop=1, record=["left.y"])
    assert not np.array_equal(gauss["left.y"][::5], flight["left.y"])


def test_a_hang_ends_the_flight_and_not_the_program(fmu):
    system = small.pair(fmu, fault=small.FAULTS.index("hang"), fault_time=0.5)
    flight = cosim.fly(system, step=0.1, stop=1, time_limit=0.5, progress=False)
    assert not flight.finished and "did not come back within 0.5 s" in flight.message
    assert flight.time[-1] == 0.5


def test_ctrl_c_keeps_what_was_flown(fmu):
    threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
    flight = cosim.fly(small.pair(fmu, substeps=200.0), step=0.001, stop=3000, record=["left.y"])
    assert not flight.finished and flight.message.startswith("Interrupted at t = ")
    assert len(flight.time) == flight.ticks + 1 > 1 and "ended early: Interrupted" in repr(flight)


def test_progress_is_told_the_time_and_a_bar_shows_in_a_terminal_only(fmu, capsys):
    told = []
    cosim.fly(small.pair(fmu), step=0.1, stop=10, progress=told.append)
    assert told == sorted(told) and told[-1] == pytest.approx(10)
    cosim.fly(small.pair(fmu), step=0.1, stop=10)
    assert capsys.readouterr() == ("", "")


def test_a_bar_shows_in_a_terminal(fmu):
    import pty

    ours, theirs = pty.openpty()
    code = ("import sys; sys.path.insert(0, sys.argv[1]); import small, cosim, pathlib\n"
            "cosim.fly(small.pair(pathlib.Path(sys.argv[2])), step=0.1, stop=10)")
    environment = {**os.environ, "TERM": "xterm", "COLUMNS": "80"}
    subprocess.run([sys.executable, "-c", code, ROOT / "benchmarks", fmu], check=True, stderr=theirs,
                   env=environment)
    os.close(theirs)
    assert b"left, right" in os.read(ours, 10000)
    os.close(ours)


def test_a_stream_writes_every_row(fmu, tmp_path):
    flight = cosim.fly(small.pair(fmu), step=0.1, stop=10, stream=str(tmp_path / "signals.parquet"))
    table = pyarrow.parquet.read_table(tmp_path / "signals.parquet")
    assert np.array_equal(table["left.y"].to_numpy(), flight["left.y"]) and table.num_rows == 101


# --- SSP ------------------------------------------------------------------------------------------------

def folder_of(loaded):
    return loaded.components[0].fmu.parents[1]


@pytest.fixture
def ssp(tmp_path):
    inner = ssp_files.system("root", ssp_files.component("a", bindings=ssp_files.inline(ssp_files.parameter("u", 2))))
    return ssp_files.write(tmp_path / "test.ssp", ssp_files.ssd(inner))


def test_an_ssp_is_a_system_with_its_own_stop(ssp):
    loaded = cosim.load_ssp(str(ssp))
    assert isinstance(loaded, cosim.System) and (loaded.name, loaded.stop, loaded.step) == ("test", 1.0, None)
    flight = cosim.fly(loaded, step=0.25)
    assert flight.time.tolist() == [0, 0.25, 0.5, 0.75, 1] and flight["a.y"].tolist() == [0, 2, 2, 2, 2]


def test_its_fmus_stay_as_long_as_it_is_used(ssp):
    loaded = cosim.load_ssp(ssp)
    folder = folder_of(loaded)
    other = replace(loaded, components=[loaded.components[0].with_values({"k": 3.0})])
    del loaded
    gc.collect()
    assert folder.is_dir() and cosim.fly(other, step=0.5)["a.y"][-1] == 6
    del other
    gc.collect()
    assert not folder.exists()


def test_its_fmus_go_with_a_block_or_with_the_program(ssp):
    with cosim.load_ssp(ssp) as loaded:
        assert folder_of(loaded).is_dir()
    assert not folder_of(loaded).exists()
    code = "import cosim, sys; kept = cosim.load_ssp(sys.argv[1]); print(kept.components[0].fmu)"
    said = subprocess.run([sys.executable, "-W", "error", "-c", code, ssp], check=True, capture_output=True, text=True)
    assert said.stderr == "" and not Path(said.stdout.strip()).exists()


def test_a_broken_ssp_leaves_nothing_behind(tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    broken = ssp_files.write(tmp_path / "broken.ssp", ssp_files.ssd('<ssd:System name="root"/>'))
    with pytest.raises(cosim.UsageError, match="no components"):
        cosim.load_ssp(broken)
    assert list(tmp_path.iterdir()) == [broken]


def test_a_flight_starts_as_the_system_or_the_call_says(fmu):
    system = replace(small.pair(fmu), start=5.0)
    assert cosim.fly(system, step=0.1, stop=6).time[[0, -1]].tolist() == [5, 6]
    assert cosim.fly(system, step=0.1, stop=1, start=-1).time[[0, -1]].tolist() == [-1, 1]
    for wrong, words in (({"stop": 5}, "^stop = 5 is not allowed: it must be a number of seconds after the start at 5"),
                         ({"start": "now"}, "^start = 'now' is not allowed"), ({"tolerance": 0}, "^tolerance = 0 is")):
        with pytest.raises(cosim.UsageError, match=words):
            cosim.fly(system, **{"step": 0.1, "stop": 6, **wrong})
