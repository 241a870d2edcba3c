"""Commands that a signal ends, at random moments: no process and no temporary folder stays, and every file is whole.

Processes are found by a tag in their environment, which whatever they start inherits, and temporary folders by a TMPDIR
of each command's own. A SIGKILL may leave a temporary folder there, which the next command removes, and rows of a
stream, which `ahv recover` makes results of.
"""
import json
import os
import random
import signal
import subprocess
import time
from pathlib import Path

import psutil
import pyarrow.parquet
import pytest
import small
from campaigns import load, written
from places import AHV

from cosim.campaign.resume import prepare
from cosim.campaign.store import Store
from cosim.ssp.write import write

TAG = "AHV_TEST_TAG"
SIGNALS = [signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGKILL]
# What a process may answer. The first is ours; the second is Python's, as long as nothing of ours has begun.
ENDS = {number: {128 + number, -number} for number in SIGNALS} | {signal.SIGKILL: {-signal.SIGKILL}}
LIMIT_S = 10.0  # for what takes a second on a machine that has nothing else to do
MOMENTS = 20


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """Systems that fly for some seconds, or hang in a call."""
    folder = tmp_path_factory.mktemp("systems")
    fmu = small.build(folder)
    for name, values, stop in (("slow", {"substeps": 20_000.0}, 100.0), ("hang", {"fault_time": 0.74}, 1.0),
                               ("hang_init", {}, 1.0), ("hang_terminate", {}, 1.0)):
        fault = small.FAULTS.index(name if name in small.FAULTS else "none")
        write(folder / f"{name}.ssp", name, small.pair(fmu, fault=fault, **values), 0.01, stop)
    written(folder / "campaign", runs=32, stop=40, runs_per_task=1)
    return folder


class Command:
    """A command that runs, tagged, with a temporary folder and a results folder of its own."""

    def __init__(self, folder: Path, *words):
        self.temporary, self.out = folder / "temporary", folder / "out"
        self.temporary.mkdir(exist_ok=True)
        self.environment = os.environ | {TAG: str(folder), "TMPDIR": str(self.temporary)}
        out = () if words[0] == "check" else ("--out", self.out)
        self.process = subprocess.Popen([AHV, *words, "--json", *out], env=self.environment, cwd=folder,
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))

    def end(self, number: int) -> tuple[int, str]:
        """Send the signal; the exit status, and what was said on stderr."""
        self.process.send_signal(number)
        self.answer, said = self.process.communicate(timeout=LIMIT_S)
        return self.process.returncode, said

    def had_answered(self) -> bool:
        """Whether the work was done when the signal came: the one JSON object is on stdout."""
        return self.process.returncode in (0, 1) and isinstance(json.loads(self.answer), dict)

    def alive(self) -> list[str]:
        """The command lines of tagged processes, as soon as there are none or after LIMIT_S."""
        until = time.monotonic() + LIMIT_S
        while (found := list(self.tagged())) and time.monotonic() < until:
            time.sleep(0.02)
        return found

    def tagged(self):
        for process in psutil.process_iter():
            try:
                if process.environ().get(TAG) == self.environment[TAG] and process.status() != psutil.STATUS_ZOMBIE:
                    yield " ".join(process.cmdline())
            except psutil.Error:
                continue

    def left(self) -> list[str]:
        """What is in the temporary folder."""
        return sorted(path.name for path in self.temporary.iterdir())


def commands(native_fmus, files):
    """Name -> words, each of a command that takes some seconds."""
    return {
        "run": ("run", "hold", "--stop", "4", "--real-time"),
        "stream": ("run", "hold", "--stop", "4", "--real-time", "--stream"),
        "isolate": ("run", "hold", "--stop", "4", "--real-time", "--isolate"),
        "python": ("run", "hold", "--stop", "4", "--real-time", "--flavour", "python"),
        "compare": ("compare", "hold", "--stop", "5"),
        "simulate": ("simulate", files / "slow.ssp"),
        "simulate-stream": ("simulate", files / "slow.ssp", "--stream"),
        "check": ("check", native_fmus["AhvPlant"]),
        "campaign": ("campaign", files / "campaign" / "campaign.yaml", "--workers", "2"),
    }


NAMES = ["run", "stream", "isolate", "python", "compare", "simulate", "simulate-stream", "check", "campaign"]


def consistent(out: Path) -> None:
    """Every file of results can be read, and all are of one run."""
    assert not list(out.rglob("*.partial")) and not list(out.rglob("staged"))
    if (out / "run.json").exists():
        record = json.loads((out / "run.json").read_text())
        table = pyarrow.parquet.read_table(out / "signals.parquet")
        assert table.num_rows == record["ticks"] + 1 and len(table.column_names) == len(record["signals"]) + 1


def resumable(out: Path, file: Path, killed: bool) -> None:
    """Nothing of the campaign's is damaged: --resume would go on with all that is there, but for the one task whose
    parts were being written when the program was killed."""
    said = prepare(Store(out, load(file)), True, file.read_text()) if out.exists() else []
    torn = killed and len(said) == 1 and said[0].endswith("json is missing: these runs are flown again.")
    assert said == [] or torn


def interrupted_at(moment: float, number: int, words, folder: Path) -> None:
    """Start a command, send it a signal after `moment` seconds, and look at what is left."""
    command = Command(folder, *words)
    time.sleep(moment)
    status, said = command.end(number)
    early = "init_import_site" in said  # before Python itself had begun
    assert status in ENDS[number] or early or command.had_answered(), (status, said)
    assert "Traceback" not in said or status == -number or early, said
    assert command.alive() == []
    if number != signal.SIGKILL:
        assert command.left() == [], said
        consistent(command.out)
    else:
        subprocess.run([AHV, "info", words[1] if words[0] == "check" else small.build(folder)], check=True,
                       env=command.environment, stdout=subprocess.DEVNULL)
        assert command.left() == []
    if words[0] == "campaign":
        resumable(command.out, words[1], number == signal.SIGKILL)
    elif number == signal.SIGKILL and words[0] in ("run", "simulate") and command.out.exists():
        done = subprocess.run([AHV, "recover", command.out], env=command.environment, capture_output=True, text=True)
        assert done.returncode in ((0, 1, 2) if "--stream" in words else (2,)), done.stderr
        assert len(done.stderr.splitlines()) <= 3, done.stderr
        consistent(command.out)


@pytest.mark.parametrize("number", SIGNALS, ids=lambda number: number.name)
@pytest.mark.parametrize("name", ["run", "simulate", "check"])
def test_nothing_is_left_of_a_command_that_a_signal_ends(name, number, native_fmus, files, tmp_path):
    moment = random.Random(f"{name} {number}").uniform(0.2, 3.0)
    interrupted_at(moment, number, commands(native_fmus, files)[name], tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGKILL], ids=lambda number: number.name)
@pytest.mark.parametrize("name", NAMES)
def test_nothing_is_left_at_many_moments(name, number, native_fmus, files, tmp_path):
    draw = random.Random(f"{name} {number} many")
    for k in range(MOMENTS):
        folder = tmp_path / str(k)
        folder.mkdir()
        interrupted_at(draw.uniform(0.0, 6.0), number, commands(native_fmus, files)[name], folder)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT], ids=lambda number: number.name)
@pytest.mark.parametrize("name, call", [("hang", "fmi2DoStep at t = 0.74 s"), ("hang_terminate", "fmi2Terminate"),
                                        ("hang_init", "fmi2EnterInitializationMode")])
def test_a_call_that_does_not_return_is_ended_and_what_was_flown_is_kept(name, call, number, files, tmp_path):
    command = Command(tmp_path, "simulate", files / f"{name}.ssp")
    wait_for_hang(command)
    status, said = command.end(number)
    assert status == 128 + number and said.startswith(f"ahv: left (small_indirect.fmu) was interrupted in {call}")
    assert len(said.splitlines()) == 1
    assert command.alive() == [] and command.left() == []
    if name != "hang_init":
        consistent(command.out)
        record = json.loads((command.out / "run.json").read_text())
        assert record["ticks"] == {"hang": 74, "hang_terminate": 100}[name] and not record["finished"]


def wait_for_hang(command: Command) -> None:
    """Until the process that calls the FMUs has loaded what it needs and used no time for a while: it hangs."""
    deadline, seen = time.monotonic() + 60, [-1.0]
    while time.monotonic() < deadline:
        time.sleep(0.1)
        try:
            workers = [p for p in psutil.Process(command.process.pid).children(recursive=True) if not p.children()]
            seen.append(sum(p.cpu_times().user for p in workers) if workers else -1.0)
        except psutil.NoSuchProcess:  # it ended while it was looked at
            continue
        if seen[-1] >= 0 and len(seen) > 30 and seen[-1] == seen[-30]:
            return
    raise AssertionError("The process of the flight does not hang.")
