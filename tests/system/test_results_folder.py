"""Folders of results: one for each kind, one writer at a time, all files together or none."""
import errno
import gc
import hashlib
import json
import os
import signal
import subprocess
import time
from contextlib import contextmanager
from itertools import permutations
from pathlib import Path

import numpy as np
import pyarrow.parquet
import pytest

from cosim.cli import show
from cosim.cli.options import place
from cosim.errors import RunError, UsageError
from cosim.master import publish as publishing
from cosim.master.folder import claimed, expanded
from cosim.master.publish import KINDS, OWN, ROWS, publish
from cosim.master.system import Component, System
from cosim.ssp.write import write as write_ssp
from cosim.systems.simulate import simulate
from cosim.vehicle import scenarios
from cosim.vehicle.closed_loop import closed_loop
from cosim.vehicle.compare import compare
from cosim.vehicle.figures import PICTURES, draw
from cosim.vehicle.run import recover, run
from cosim.vehicle.scenarios import Scenario
from tests.places import AHV

CAMPAIGN = """
name: hold
scenario: hold
stop: 0.5
runs: 2
seed: 1
dispersions: {plant.mass: {distribution: uniform, low: 290, high: 310}}
success: {altitude: altitude_error_ft.max_abs < 20}
"""


def fly_run(out: Path | None = None):
    run("hold", stop=0.5, out=out)


def fly_compare(out: Path | None = None):
    compare("hold", ["neural", "resilient"], stop=0.5, out=out)


def fly_simulate(out: Path | None = None):
    simulate(Path("hold.ssp"), None, 0.5, "gauss-seidel", out)


def fly_campaign(out: Path | None = None):
    from campaigns import campaign

    campaign(Path("hold.yaml"), out, resume=Path("results/campaign/hold").exists(), workers=1)


FLY = {"run": fly_run, "compare": fly_compare, "simulate": fly_simulate, "campaign": fly_campaign}


def ours(folder: Path) -> dict[str, str]:
    """Every file of a folder that a reader looks at, with its SHA-256."""
    return {path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
            for path in sorted(folder.rglob("*")) if path.is_file()}


def consistent(folder: Path, head: str = "run.json") -> dict:
    """The head of the results, once every file that it names was found to be the one that it names."""
    record = json.loads((folder / head).read_text())
    assert record["files"] == {name: found for name, found in ours(folder).items() if name in record["files"]}
    return record


@pytest.fixture(scope="module")
def work(tmp_path_factory, native_fmus):
    """A working directory in which one of each kind, all called `hold`, was flown."""
    folder, before = tmp_path_factory.mktemp("work"), Path.cwd()
    os.chdir(folder)
    Path("hold.yaml").write_text(CAMPAIGN)
    write_ssp(Path("hold.ssp"), "hold", closed_loop(scenarios.load("hold")).system, 0.01, 60.0)
    for fly in FLY.values():
        fly()
    yield folder
    os.chdir(before)


@pytest.mark.parametrize("kind", FLY)
def test_results_of_one_kind_leave_those_of_the_others_as_they_were(work, kind):
    """Each after all others, so every order of two is there."""
    before = {other: ours(work / "results" / other / "hold") for other in FLY}
    assert all(before.values()) and {path.name for path in (work / "results").iterdir()} == set(FLY)
    FLY[kind]()
    after = {other: ours(work / "results" / other / "hold") for other in FLY}
    assert {other for other in FLY if after[other] != before[other]} <= {kind}
    assert after[kind].keys() == before[kind].keys()


@pytest.mark.parametrize("there,comes", [*permutations(FLY, 2)])
def test_a_folder_of_another_kind_is_refused_by_name(work, there, comes):
    folder = Path("results") / there / "hold"
    before = ours(folder)
    with pytest.raises(UsageError, match=f"holds {KINDS[there].words}; give --out another folder"):
        FLY[comes](folder)
    assert ours(folder) == before


@pytest.mark.parametrize("there", ["run", "simulate", "campaign"])
def test_the_head_says_the_kind_where_the_mark_is_missing(work, tmp_path, there):
    kind = KINDS[there]
    head = json.loads((work / "results" / there / "hold" / kind.head).read_text())
    for record in (head, {key: value for key, value in head.items() if key != "kind"}):  # as former versions wrote it
        (tmp_path / kind.head).write_text(json.dumps(record))
        with pytest.raises(UsageError, match=f"holds {kind.words}"), claimed(tmp_path, "compare", ""):
            pass


def test_files_of_the_user_stay_and_are_never_replaced(work, tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    fly_run(tmp_path)
    (tmp_path / "figures" / "mine.png").write_text("mine")
    fly_run(tmp_path)
    assert (tmp_path / "notes.txt").read_text() == (tmp_path / "figures" / "mine.png").read_text() == "mine"
    consistent(tmp_path)


@pytest.mark.parametrize("name", ["signals.csv", "run.json", "figures"])
def test_a_file_of_the_user_that_would_be_replaced_is_refused(work, tmp_path, name):
    (tmp_path / name).write_text("{}")
    with pytest.raises(UsageError, match=f"has {name}, which ahv did not write"):
        fly_run(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == [name] and (tmp_path / name).read_text() == "{}"


def test_nothing_is_left_of_the_former_run(work, tmp_path):
    run("case1", stop=0.1, out=tmp_path)
    run("hold", stop=0.1, out=tmp_path, stream=True)  # no CSV, other figures
    record = consistent(tmp_path)
    assert record["kind"] == "run" and set(ours(tmp_path)) - set(record["files"]) == {"run.json", ".ahv/kind.json"}
    assert "signals.csv" not in record["files"] and "figures/velocity.png" in record["files"]


def test_a_request_that_cannot_be_flown_leaves_no_folder(work, tmp_path):
    with pytest.raises(UsageError):
        run("hold", stop=0.123456, out=tmp_path / "new")
    assert list(tmp_path.iterdir()) == []


def test_two_runs_into_one_folder(work, tmp_path):
    with claimed(tmp_path, "run", ""):
        done = subprocess.run([AHV, "run", "hold", "--stop", "1", "--out", tmp_path], capture_output=True, text=True)
    assert done.returncode == 2 and len(done.stderr.strip().splitlines()) == 1
    assert f"Another ahv is writing to {tmp_path}" in done.stderr
    fly_run(tmp_path)
    consistent(tmp_path)


def test_the_home_folder_is_meant_in_one_place(work, tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.chdir(tmp_path)
    assert run("hold", stop=0.1, out=Path("~/x"), stream=True).out == tmp_path / "home" / "x"
    consistent(tmp_path / "home" / "x")
    assert [path.name for path in tmp_path.iterdir()] == ["home"]
    with pytest.raises(UsageError, match="no such home folder"):
        run("hold", stop=0.1, out=Path("~nobody_here/x"))


@pytest.mark.parametrize("word, path", [("~/x", "home/x"), ("./~/x", "here/~/x"), ("x/~", "x/~"),
                                        ("~nobody_here/x", "")])
def test_a_folder_called_tilde_is_not_the_home_folder(word, path, tmp_path, monkeypatch):
    (tmp_path / "here").mkdir()
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.chdir(tmp_path / "here")
    if path:
        expected = tmp_path / path if "e/" in path else Path(path)
        assert place(word) == expected == expanded(place(word))
    else:
        with pytest.raises(UsageError, match="no such home folder"):
            place(word)


def test_a_stream_that_a_signal_ended_gets_no_figures(tmp_path):
    with claimed(tmp_path, "run", "") as folder:
        rows = folder / OWN / ROWS
        rows.write_bytes(b"rows")
        done = publish(folder, "run", {}, lambda place: (place / "signals.parquet").write_text("new"),
                       [lambda place: pytest.fail("It was begun.")], rows=rows, interrupted=signal.SIGTERM)
    assert done.trouble.endswith("interrupted: only signals.parquet and run.json could be written.")
    assert (tmp_path / "signals.parquet").read_text() == "new" and not rows.exists()


# What a program that is ended leaves. The former results have files a and b, the new ones a and c.

def write_former(place: Path):
    (place / "signals.parquet").write_text("former")
    (place / "signals.csv").write_text("former")


def write_new(place: Path):
    (place / "signals.parquet").write_text("new")
    (place / "figures").mkdir()
    (place / "figures" / "x.png").write_text("new")


FORMER = {"signals.parquet": "former", "signals.csv": "former"}
NEW = {"signals.parquet": "new", "figures/x.png": "new"}


def published(folder: Path):
    with claimed(folder, "run", "") as place:
        publish(place, "run", {"controller": "new"}, write_new)


def killed_at(call: int, folder: Path) -> bool:
    """Publish in a process that is gone at its nth change of the disk; False if it has fewer."""
    child = os.fork()
    if child == 0:
        left = iter(range(call))

        def dying(function):
            def called(*words, **options):
                if next(left, None) is None:
                    os._exit(9)
                return function(*words, **options)
            return called

        for name in ("replace", "unlink", "mkdir", "rmdir", "fsync"):
            setattr(os, name, dying(getattr(os, name)))
        published(folder)
        os._exit(0)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 9


def test_a_kill_at_any_moment_leaves_the_former_results_or_the_new(tmp_path):
    seen, call = set(), 0
    while True:
        folder = tmp_path / str(call)
        with claimed(folder, "run", "") as place:
            publish(place, "run", {"controller": "former"}, write_former)
        killed = killed_at(call, folder)
        if (folder / "run.json").exists():
            consistent(folder)
        with claimed(folder, "run", ""):
            pass
        record = consistent(folder)
        there = {name: (folder / name).read_text() for name in record["files"]}
        seen.add(record["controller"])
        assert there == {"former": FORMER, "new": NEW}[record["controller"]]
        assert set(ours(folder)) == {*there, "run.json", ".ahv/kind.json"}
        if not killed:
            break
        call += 1
    assert seen == {"former", "new"} and call > 15


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_waits_until_the_results_are_there(tmp_path, number):
    class Ended(BaseException):
        pass

    def end(*_):
        raise Ended

    def signalled(place):
        signal.raise_signal(number)
        write_new(place)

    before = signal.signal(number, end)
    try:
        with pytest.raises(Ended), claimed(tmp_path, "run", "") as folder:
            publish(folder, "run", {"controller": "new"}, signalled, [lambda place: pytest.fail("begun after that")])
    finally:
        signal.signal(number, before)
    assert set(consistent(tmp_path)["files"]) == set(NEW)


def test_a_head_that_names_files_elsewhere_removes_nothing_there(tmp_path):
    (tmp_path / "mine").write_text("mine")
    folder = tmp_path / "results"
    published(folder)
    record = json.loads((folder / "run.json").read_text())
    record["files"] = {"../mine": "", str(tmp_path / "mine"): "", "figures/../../mine": "", "notes.txt": ""}
    (folder / "run.json").write_text(json.dumps(record))
    (folder / "notes.txt").write_text("mine")
    published(folder)
    assert (tmp_path / "mine").exists() and (folder / "notes.txt").exists()


# --stream

def rows_of(folder: Path) -> Path:
    return folder / publishing.OWN / publishing.ROWS


@pytest.mark.parametrize("isolate", [[], ["--isolate"]])
def test_rows_of_a_stream_outlast_a_kill(work, tmp_path, isolate):
    folder = tmp_path / "out"
    child = subprocess.Popen([AHV, "run", "case1", "--stop", "99999", "--stream", *isolate, "--out", folder],
                             stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)
    try:
        deadline = time.monotonic() + 120
        while not (rows_of(folder).exists() and rows_of(folder).stat().st_size > 5e6):
            assert child.poll() is None and time.monotonic() < deadline
            time.sleep(0.02)
    finally:
        os.killpg(child.pid, signal.SIGKILL)
        child.wait()
    with pytest.raises(UsageError, match=f"killed: `ahv recover {folder}` makes results"):
        unlocked(lambda: fly_run(folder))
    done = unlocked(lambda: recover(folder))
    table, record = pyarrow.parquet.read_table(folder / "signals.parquet"), consistent(folder)
    rows = table.num_rows
    assert rows > 5000 and np.allclose(table["time"], 0.01 * np.arange(rows), atol=1e-6)
    whole = run("case1", stop=0.01 * 4096, out=tmp_path / "whole")
    assert table.slice(0, 4097).equals(pyarrow.parquet.read_table(whole.out / "signals.parquet"))
    assert not record["finished"] and record["departed_at_s"] == table["time"][-1].as_py() == done.flight.reached
    assert record["altitude_error_ft"]["max_abs"] > 0 and record["parameters"]["plant"]["mass"] == 300
    assert not rows_of(folder).exists()
    with pytest.raises(UsageError, match="has no rows of a flight that was killed"):
        recover(folder)


def unlocked(do):
    """What `do` gives, once no process of the killed run is left that has the folder."""
    deadline = time.monotonic() + 20
    while True:
        try:
            return do()
        except UsageError as error:
            if "Another ahv" not in str(error) or time.monotonic() > deadline:
                raise
            time.sleep(0.1)


def test_recovered_results_may_go_elsewhere(work, tmp_path):
    folder = tmp_path / "killed"
    cut_short(folder)
    recover(folder, tmp_path / "kept")
    assert consistent(tmp_path / "kept")["departed_at_s"] == 1.0 and not rows_of(folder).exists()
    assert not folder.exists()


def test_rows_of_which_none_is_complete(work, tmp_path):
    cut_short(tmp_path / "out")
    with open(rows_of(tmp_path / "out"), "r+b") as rows:
        rows.truncate(6000)  # in the schema
    with pytest.raises(RunError, match="no complete rows"):
        recover(tmp_path / "out")
    assert not (tmp_path / "out").exists()


def cut_short(folder: Path):
    """A streamed second in a process that is killed before it writes results."""
    child = os.fork()
    if child == 0:
        from cosim.vehicle import run as module

        module.kept = lambda *words: os._exit(9)
        module.run("hold", stop=1.0, out=folder, stream=True)
        os._exit(0)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 9


# A full disk

@pytest.fixture
def small_disk(tmp_path):
    """A folder on a disk of its own, and a function that changes the size of that disk."""
    disk = tmp_path / "disk"
    disk.mkdir()
    if os.geteuid() or subprocess.run(["mount", "-t", "tmpfs", "-o", "size=16m", "tmpfs", disk],
                                      capture_output=True).returncode:
        pytest.skip("mounting a small disk needs to be root")

    def resize(kilobytes: int):
        subprocess.run(["mount", "-o", f"remount,size={kilobytes}k", disk], check=True)

    yield disk / "out", resize
    gc.collect()  # a failed write's traceback may keep its file open
    subprocess.run(["umount", disk], check=True)


@pytest.fixture
def temporary(tmp_path, monkeypatch):
    """A folder for temporary files."""
    (tmp_path / "tmp").mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "tmp"))
    return tmp_path / "tmp"


@contextmanager
def no_temporary():
    raise OSError(errno.ENOSPC, "full")
    yield


@pytest.mark.parametrize("isolate", [False, True])
def test_a_full_disk_keeps_signals_and_leaves_out_the_rest(work, small_disk, isolate):
    folder, resize = small_disk
    resize(600)
    done = run("case1", stop=10, out=folder, isolate=isolate)  # signals.parquet has about 340 kB, all has 1,500
    assert done.trouble == (f"{folder}: No space left on device: only signals.parquet and run.json could be written.")
    assert list(consistent(folder)["files"]) == ["signals.parquet"] and done.out == folder
    assert pyarrow.parquet.read_table(folder / "signals.parquet").num_rows == 1001


def test_a_full_disk_leaves_the_former_results_and_the_new_ones_are_elsewhere(work, small_disk, temporary):
    folder, resize = small_disk
    run("hold", stop=0.1, out=folder)
    before = ours(folder)
    resize(sum(path.stat().st_size for path in folder.rglob("*")) // 1024 + 100)
    done = run("case1", stop=10, out=folder)
    assert ours(folder) == before
    assert f"{folder}: No space left on device: the results are in {done.out} instead." == done.trouble
    assert done.out.parent == temporary and len(consistent(done.out)["files"]) == 10
    assert done.summary["out"] == consistent(done.out)["out"] == str(done.out)


def test_without_room_anywhere_the_first_rows_are_kept(work, small_disk, monkeypatch):
    folder, resize = small_disk
    monkeypatch.setattr(publishing, "temporary", no_temporary)
    resize(300)
    done = run("case1", stop=10, out=folder)
    assert done.trouble == f"{folder}: No space left on device: only the first rows could be written."
    assert consistent(folder)["left_out"] == "the later rows"
    assert pyarrow.parquet.read_table(folder / "signals.parquet").num_rows in (500, 250)


@pytest.mark.parametrize("isolate", [False, True])
def test_a_full_disk_ends_a_stream_and_its_rows_are_recovered(work, small_disk, isolate, tmp_path):
    folder, resize = small_disk
    resize(2000)
    done = run("case1", stop=100, out=folder, isolate=isolate, stream=True)
    assert not done.flight.finished and "No space left on device; rows from t = " in done.flight.message
    assert done.trouble.endswith(f"make room or choose another folder with --out, then `ahv recover {folder}`.")
    assert recover(folder).trouble == done.trouble  # there is still no room, and nothing is lost by that
    resize(16000)
    kept = recover(folder)
    assert not kept.trouble and 1024 <= pyarrow.parquet.read_table(folder / "signals.parquet").num_rows < 10001
    consistent(folder)


def test_a_full_disk_for_the_other_commands(work, small_disk, temporary):
    folder, resize = small_disk
    resize(200)
    summary, _, _, trouble = compare("hold", ["neural", "resilient"], stop=0.5, out=folder)
    assert trouble == f"{folder}: No space left on device: only compare.json could be written."
    assert consistent(folder, "compare.json")["controllers"].keys() == summary["controllers"].keys()
    found = simulate(Path("hold.ssp"), None, 10.0, "gauss-seidel", folder.parent / "simulated")
    assert "No space left on device: only signals.parquet and run.json could be" in found[-1]
    assert consistent(folder.parent / "simulated")["kind"] == "simulate"
    done = subprocess.run([AHV, "ssp", "hold", "--out", folder.parent / "x.ssp"], capture_output=True, text=True)
    assert done.returncode == 2 and "cannot be written: No space left on device." in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    assert {path.name for path in folder.parent.iterdir()} == {"out", "simulated"}


def test_a_disk_that_is_full_is_noticed_before_flying(work, small_disk):
    folder, resize = small_disk
    resize(100)
    with pytest.raises(OSError, match="No space"), open(folder.parent / "filling", "wb", buffering=0) as file:
        while file.write(bytes(4096)):
            pass
    done = subprocess.run([AHV, "run", "hold", "--out", folder], capture_output=True, text=True)
    assert done.returncode == 2
    assert done.stderr == f"ahv: --out {folder} cannot be written to: No space left on device.\n"


def test_results_that_do_not_fit_are_no_success(work, small_disk, tmp_path):
    folder, resize = small_disk
    resize(200)
    done = subprocess.run([AHV, "run", "case1", "--stop", "10", "--json", "--out", folder], capture_output=True,
                          text=True, env={**os.environ, "TMPDIR": str(tmp_path)})
    assert done.returncode == 1 and len(done.stderr.strip().splitlines()) == 1
    assert json.loads(done.stdout)["out"].startswith(str(tmp_path / "ahv_kept_"))


# Names

BAD = ["", ".", "..", "../../esc", "a/b", "/abs", "~", "~root", "-x", ".hidden", "a\0b", "a\nb", "a" * 65, "ä" * 33,
       "a" * 300, r"$\frac$", "[red]", "a b ", " a", "a.", "*", "CON:", "a\\b", "a\u202eb"]


@pytest.mark.parametrize("name", BAD)
def test_bad_names_are_refused_everywhere(tmp_path, name):
    sentence = "name .* is not allowed: it must have 1 to 64 letters"
    with pytest.raises(ValueError, match=sentence):
        Scenario(name=name, stop=1)
    (tmp_path / "x.yaml").write_text(json.dumps({"name": name, "scenario": "hold", "runs": 1, "seed": 1,
                                                 "dispersions": {}, "success": {"a": "1 < 2"}}))
    from campaigns import load

    from cosim.vehicle.campaigns import Law

    with pytest.raises(UsageError, match=rf"x.yaml, line 1: name: the {sentence}"):
        load(tmp_path / "x.yaml")
    if name:
        with pytest.raises(ValueError, match=sentence):
            Law(law="neural", name=name)
        system = System((Component(name.replace(".", "/"), "x.fmu"),))
        with pytest.raises(UsageError, match=r"The component name .* is not allowed"):
            write_ssp(tmp_path / "x.ssp", "x", system, 0.1, 1.0)
        with pytest.raises(UsageError, match=f"The controller {sentence}"):
            closed_loop(scenarios.load("hold"), f"{name}=AhvController.fmu")


@pytest.mark.parametrize("name", ["case1", "a", "own-2.b_c d", "größe", "x" * 64, "_", "1"])
def test_good_names_are_taken(name):
    assert Scenario(name=name, stop=1).name == name


@pytest.mark.parametrize("file,name", [
    ("My law (2)", "My law _2_"), ("..", "unnamed"), ("[red]", "_red_"), ("~", "_"), ("a" * 200, "a" * 64),
    (".hidden", "hidden"), ("$x$", "_x_"), ("neural", "neural"), ("a" * 63 + "é", "a" * 63)])
def test_files_of_others_get_names_that_follow_the_rule(file, name):
    from cosim.names import is_name, safe

    assert safe(file) == name and is_name(name)


def test_a_table_shows_names_as_they_are(capsys):
    show.report({"[red]": "[/]", "b": "[bold]x"}, False)
    show.report_rows({"[red]": {"[/x]": "[/]"}})
    shown = capsys.readouterr().out
    assert all(text in shown for text in ("[red]", "[/]", "[bold]x", "[/x]"))


def test_a_title_is_no_formula(work, tmp_path):
    flight = run("hold", stop=0.1, out=tmp_path / "out").flight
    draw(flight, r"$\frac$ and $5", PICTURES[0][2]).savefig(tmp_path / "x.png")


