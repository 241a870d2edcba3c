"""Runs the process of a checked FMU apart: what it may use is limited, and all that it starts ends with it.

Two processes: a guard, and the worker that loads the FMU. The guard watches the worker and everything that it started,
ends them all when a limit is passed, when the worker has ended, or when the checking process is gone. Around both is
a sandbox where the machine has one: see `SANDBOXES`.
"""
import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from ..processes import PARENT_DEATH, SUBREAPER, below, end_all, prctl

MB = 1 << 20
PAGE = os.sysconf("SC_PAGE_SIZE") if hasattr(os, "sysconf") else 4096
LOOK_S = 0.05
MOST_ANSWERS = 256 * MB  # an FMU that writes where the answers go cannot fill the memory
# Tried in this order. bwrap: nothing but `work` can be written, no network, processes of its own. unshare: processes
# of its own, so that none outlives the guard.
SANDBOXES: dict[str, Callable[[str], list[str]]] = {
    "bwrap": lambda work: ["bwrap", "--die-with-parent", "--unshare-pid", "--unshare-net", "--unshare-ipc", "--ro-bind",
                           "/", "/", "--dev", "/dev", "--proc", "/proc", "--bind", work, work, "--"],
    "unshare": lambda _: ["unshare", "--user", "--map-root-user", "--pid", "--fork", "--kill-child", "--mount-proc"],
    "unshare as root": lambda _: ["unshare", "--pid", "--fork", "--kill-child", "--mount-proc"],
}


@dataclass(frozen=True)
class Limits:
    """What the FMU may use: seconds for one call and for the whole check, memory and size of one file (MB), processes.

    Memory and processes are those of the FMU and all that it started, together. After `budget_s` no probe begins.
    """
    call_s: float = 30.0
    total_s: float = 1800.0
    memory_mb: int = 4096
    file_mb: int = 1024
    processes: int = 64
    budget_s: float = 30.0


@cache
def sandbox() -> str | None:
    """The first sandbox that works here, or None."""
    return next(filter(works, SANDBOXES), None)


def works(name: str) -> bool:
    """Whether this machine has a sandbox and lets us use it."""
    try:
        return subprocess.run([*SANDBOXES[name]("/tmp"), "true"], capture_output=True, timeout=10).returncode == 0
    except (OSError, subprocess.SubprocessError):
        return False


class Confined:
    """A running guard with its worker. `answers` grows by the lines that the worker writes."""

    def __init__(self, module: str, arguments: list[str], job: str, work: Path, limits: Limits):
        scratch = work / "scratch"
        scratch.mkdir(exist_ok=True)
        root = str(Path(__file__).parents[2])
        environment = os.environ | {"PYTHONPATH": os.pathsep.join([root, os.environ.get("PYTHONPATH", "")]),
                                    "HOME": str(scratch), "TMPDIR": str(scratch)}
        found = sandbox()
        command = [*(SANDBOXES[found](str(work)) if found else []), sys.executable, "-P", "-m", module,
                   json.dumps(vars(limits)), *arguments]
        with (work / "stderr.txt").open("wb") as errors:
            self.process = subprocess.Popen(command, cwd=scratch, env=environment, stdin=subprocess.PIPE,
                                            stdout=subprocess.PIPE, stderr=errors, start_new_session=True)
        self.answers: list[str] = []
        self.flooded = False
        self.reader = threading.Thread(target=self.read, daemon=True)
        self.reader.start()
        assert self.process.stdin is not None
        with contextlib.suppress(BrokenPipeError):
            self.process.stdin.write(job.encode() + b"\n")
            self.process.stdin.flush()

    def read(self) -> None:
        """Collect the worker's lines until its end."""
        assert self.process.stdout is not None
        left = MOST_ANSWERS
        while line := self.process.stdout.readline(left):
            left -= len(line)
            self.answers.append(line.decode("utf-8", "replace"))
            if left <= 0:
                self.flooded = True
                self.process.kill()
                return

    def end(self) -> None:
        """End the guard, the worker, and all that it started."""
        assert self.process.stdin is not None
        with contextlib.suppress(OSError):
            self.process.stdin.close()  # the guard ends everything when it sees that
        with contextlib.suppress(subprocess.TimeoutExpired):
            self.process.wait(1.0)
        if os.name == "posix":
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.killpg(self.process.pid, signal.SIGKILL)
        self.process.kill()
        self.process.wait()
        self.reader.join(5.0)


# --- in the guard's process -----------------------------------------------------------------------------------------

def guarded(work: Callable[[str, int], None]) -> None:
    """What the guard's process does: fork the worker, which runs `work(job, where its answers go)`, and watch it.

    The last answer is {"died": why}. Where there is no fork, the worker runs alone. Does not return.
    """
    limits = Limits(**json.loads(sys.argv[1]))
    answers = os.dup(1)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # what the FMU prints is no answer
    job = sys.stdin.buffer.readline().decode()
    worker = os.fork() if hasattr(os, "fork") else 0
    if worker == 0:
        os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
        limit_files(limits)
        work(job, answers)
        os._exit(0)
    prctl(SUBREAPER, 1)  # orphans below come to the guard
    reason: list[str] = []
    threading.Thread(target=wait_for_parent, daemon=True).start()
    threading.Thread(target=watch, args=(limits, reason), daemon=True).start()
    ended, status = 0, 0
    while ended != worker:
        ended, status = os.wait()
    died = reason[0] if reason else why(os.waitstatus_to_exitcode(status), limits)
    end_all()
    with contextlib.suppress(BrokenPipeError):
        os.write(answers, (json.dumps({"died": died}) + "\n").encode())
    os._exit(0)


def limit_files(limits: Limits) -> None:
    """In the worker: no file above the limit, no core dump, and no life without the guard."""
    prctl(PARENT_DEATH, signal.SIGKILL)
    with contextlib.suppress(ImportError):
        import resource  # not on Windows

        resource.setrlimit(resource.RLIMIT_FSIZE, (limits.file_mb * MB, limits.file_mb * MB))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        signal.signal(signal.SIGXFSZ, signal.SIG_DFL)


def why(code: int, limits: Limits) -> str:
    """How the worker ended, in words; an empty text for an end that it chose."""
    if code == 0:
        return ""
    if code < 0 and -code in signal.valid_signals():
        name = signal.Signals(-code).name
        return f"limit: a file of more than {limits.file_mb} MB" if name == "SIGXFSZ" else f"signal {name}"
    return f"exit code {code}"


def watch(limits: Limits, reason: list[str]) -> None:
    """End the worker and all that it started when they use too much; `reason` then has one text."""
    while not reason:
        time.sleep(LOOK_S)
        found = below(os.getpid())
        memory = sum(map(resident_mb, found))
        if len(found) > limits.processes:
            reason.append(f"limit: more than {limits.processes} processes")
        elif memory > limits.memory_mb:
            reason.append(f"limit: more than {limits.memory_mb} MB of memory")
    end_all()


def wait_for_parent() -> None:
    """End everything once the checking process has closed our standard input, or is gone."""
    while os.read(0, 4096):
        pass
    end_all()
    os._exit(1)


def resident_mb(pid: int) -> float:
    """Memory of a process that is its own (MB); 0 if it has ended."""
    with contextlib.suppress(OSError, ValueError, IndexError):
        _, resident, shared = Path("/proc", str(pid), "statm").read_text().split()[:3]
        return (int(resident) - int(shared)) * PAGE / MB
    return 0.0
