"""Options of `ahv simulate`, what memory does not hold, and a TMPDIR that takes nothing."""
import json
import os
import shutil
import subprocess

import pyarrow.parquet
import pytest
import small
from places import AHV

from cosim.errors import UsageError
from cosim.master.fly import MOST_TICKS, make_recorder, tick_count
from cosim.master.isolated import fly_isolated
from cosim.master.memory import free_memory
from cosim.master.recording import batches
from cosim.ssp.write import write


@pytest.fixture
def ssp(tmp_path):
    def make(fault="none", **values):
        system = small.pair(small.build(tmp_path), fault=small.FAULTS.index(fault), **values)
        write(tmp_path / "pair.ssp", "pair", system, 0.01, 1.0)
        return tmp_path / "pair.ssp"
    return make


def simulate(*words, status=0, **environment):
    done = subprocess.run([AHV, "simulate", *words], capture_output=True, text=True, env=os.environ | environment)
    assert done.returncode == status, done.stderr
    return done.stderr


@pytest.mark.parametrize("fault,call", [("hang", "fmi2DoStep at t = 0.74 s"), ("hang_terminate", "fmi2Terminate")])
def test_a_call_that_takes_too_long_ends_the_simulation(ssp, tmp_path, fault, call):
    said = simulate(ssp(fault, fault_time=0.74), "--time-limit", "0.5", "--out", tmp_path / "out", status=1)
    assert said == f"ahv: left (small_indirect.fmu) did not come back within 0.5 s from {call}\n"
    record = json.loads((tmp_path / "out" / "run.json").read_text())
    assert record["ticks"] == {"hang": 74, "hang_terminate": 100}[fault] and not record["finished"]
    assert pyarrow.parquet.read_table(tmp_path / "out" / "signals.parquet").num_rows == record["ticks"] + 1


@pytest.mark.parametrize("fault", ["crash_terminate", "crash_free"])
def test_a_crash_at_the_end_is_named_and_all_ticks_are_kept(ssp, tmp_path, fault):
    said = simulate(ssp(fault), "--out", tmp_path / "out", status=1)
    call = {"crash_terminate": "fmi2Terminate", "crash_free": "fmi2FreeInstance"}[fault]
    assert f"ahv: left (small_indirect.fmu) crashed (SIGSEGV) in {call}" in said
    assert json.loads((tmp_path / "out" / "run.json").read_text())["ticks"] == 100


def test_a_stream_has_the_same_rows(ssp, tmp_path):
    simulate(ssp(), "--out", tmp_path / "memory")
    simulate(ssp(), "--stream", "--out", tmp_path / "stream")
    tables = [pyarrow.parquet.read_table(tmp_path / name / "signals.parquet") for name in ("memory", "stream")]
    assert tables[0].equals(tables[1]) and not (tmp_path / "stream" / "signals.csv").exists()


@pytest.mark.parametrize("words", [(), ("--stream",)])
def test_outputs_that_are_no_numbers_are_told(ssp, tmp_path, words):
    said = simulate(ssp("not_a_number", fault_time=0.745), *words, "--out", tmp_path / "out")
    assert "are nan or infinite, first at t = 0.76 s" in said


def complete(rows):
    """How many rows of a stream that is being written can be read."""
    try:
        return sum(batch.num_rows for batch in batches(rows)[1])
    except (OSError, pyarrow.ArrowInvalid):
        return 0


def test_a_killed_stream_is_recovered(ssp, tmp_path):
    file = ssp(substeps=20_000.0)
    process = subprocess.Popen([AHV, "simulate", file, "--stop", "100", "--stream", "--out", tmp_path / "out"])
    rows = tmp_path / "out" / ".ahv" / "rows.arrows"
    while complete(rows) <= 10:
        assert process.poll() is None
    process.kill()
    process.wait()
    said = subprocess.run([AHV, "recover", tmp_path / "out", "--json"], capture_output=True, text=True)
    assert said.returncode == 0 and "were recovered" in said.stderr, said.stderr
    record = json.loads((tmp_path / "out" / "run.json").read_text())
    table = pyarrow.parquet.read_table(tmp_path / "out" / "signals.parquet")
    assert record["kind"] == "simulate" and not record["finished"] and table.num_rows == record["ticks"] + 1 > 10
    assert record["fmus"]["left"]["file"].startswith(f"{file}/") and json.loads(said.stdout)["system"] == "pair"


@pytest.mark.parametrize("command", ["run", "simulate"])
def test_rows_that_do_not_fit_in_memory_are_refused(ssp, tmp_path, command):
    words = ("hold",) if command == "run" else (ssp(),)
    done = subprocess.run([AHV, command, *words, "--stop", "1e9", "--out", tmp_path / "out"], capture_output=True,
                          text=True)
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1
    assert "GB of memory, and" in done.stderr and done.stderr.endswith("Use --stream.\n")


def test_the_limit_is_what_is_free(tmp_path, monkeypatch):
    assert 1e7 < free_memory() < 1e15
    columns = fly_isolated(small.pair(small.build(tmp_path)), 0.01, 0.01, "jacobi").columns
    monkeypatch.setattr("cosim.master.fly.free_memory", lambda: 3.0 * 8 * 1000 * (len(columns) + 1))
    make_recorder(columns, None, 1000)
    make_recorder(columns, tmp_path / "rows.parquet", 1001)
    with pytest.raises(UsageError, match=r"^--step and --stop give 1e\+03 rows of 10 signals\..* Use --stream\.$"):
        make_recorder(columns, None, 1001)


def test_more_ticks_than_anybody_flies_are_refused():
    assert tick_count(1.0, float(MOST_TICKS)) == MOST_TICKS
    with pytest.raises(UsageError, match=r"is more than 1e\+12 communication steps of 0\.01 s"):
        tick_count(0.01, 1e300)


# --- TMPDIR -----------------------------------------------------------------------------------------------

COMMANDS = {"check": ("check", "{fmu}"), "info": ("info", "{fmu}"), "simulate": ("simulate", "{ssp}", "--out", "{out}"),
            "run": ("run", "hold", "--stop", "1", "--out", "{out}"),
            "compare": ("compare", "hold", "--stop", "1", "--out", "{out}"), "linearize": ("linearize",)}


@pytest.mark.parametrize("command", COMMANDS)
def test_a_full_tmpdir_is_named_and_nobody_is_blamed(native_fmus, ssp, tmp_path, command):
    """A file system of 100 kB in a name space of its own, where the machine allows that."""
    full = tmp_path / "full"
    full.mkdir()
    inside = ["unshare", "--mount", *(() if os.geteuid() == 0 else ("--user", "--map-root-user")), "sh", "-c",
              f'mount -t tmpfs -o size=100k tmpfs {full} && exec "$@"', "sh"]
    if not shutil.which("unshare") or subprocess.run([*inside, "true"], capture_output=True).returncode:
        pytest.skip("needs namespaces with mounts of their own")
    places = {"fmu": native_fmus["AhvPlant"], "ssp": ssp(), "out": tmp_path / "out"}
    words = [word.format(**places) for word in COMMANDS[command]]
    if command == "simulate":  # its small FMUs fit into 100 kB
        inside[-2] = inside[-2].replace("100k", "8k")
    done = subprocess.run([*inside, AHV, *words], capture_output=True, text=True,
                          env=os.environ | {"TMPDIR": str(full)})
    assert (done.returncode, done.stdout, done.stderr) == (2, "", f"ahv: TMPDIR {full} is full.\n")


@pytest.mark.parametrize("command", COMMANDS)
def test_a_tmpdir_that_is_none_is_named(native_fmus, ssp, tmp_path, command):
    places = {"fmu": native_fmus["AhvPlant"], "ssp": ssp(), "out": tmp_path / "out"}
    words = [word.format(**places) for word in COMMANDS[command]]
    done = subprocess.run([AHV, *words], capture_output=True, text=True,
                          env=os.environ | {"TMPDIR": str(tmp_path / "none")})
    sentence = f"ahv: TMPDIR {tmp_path / 'none'} cannot be written to: No such file or directory.\n"
    assert (done.returncode, done.stdout, done.stderr) == (2, "", sentence)
