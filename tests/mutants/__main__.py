"""Do the tests notice a mistake? A sample of single-point mutants, each tried by its room's tests: `make mutants`.

    .venv/bin/python tests/mutants [--sample 406] [--seed 1] [--room NAME]... [--workers 1] [--retry] [--table]

Why a driver of our own: mutmut 3 rewrites functions into trampolines, which no traced model and no source file inside
an FMU stands, and leaves tables of numbers alone; cosmic-ray has one test command for all. Neither knows C, a mutant
that needs an FMU built again, nor tests that differ between rooms.

Nothing is changed in the checkout. Each worker has a copy of it, where one file at a time is mutated and put back. A
trial is a fork of the worker, which has the big libraries loaded already, so it costs what the tests cost. What came
out is a line in results/mutants.jsonl: a run that was stopped goes on where it was, `--retry` tries survivors
again (after tests were added), and the table in docs/mutants.md has the first verdict beside the last one. judged.yaml
holds the mutants that change nothing that can be observed, with the reason.
"""
import argparse
import compileall
import ctypes
import json
import multiprocessing
import os
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from importlib import import_module
from importlib.util import cache_from_source, find_spec
from pathlib import Path
from typing import NoReturn

import yaml
from page import head, write_table
from points import Mutant, mutants
from quick_build import recompiled
from rooms import FMUS, ROOMS, tests

ROOT = Path(__file__).parents[2]
RESULTS = ROOT / "results" / "mutants.jsonl"
JUDGED = Path(__file__).with_name("judged.yaml")
LIBRARIES = ("pytest", "casadi", "fmpy.fmi2", "lxml.etree", "pythonfmu", "pyarrow.parquet", "pydantic", "scipy.stats",
             "scipy.signal", "hypothesis.strategies", "matplotlib.figure", "typer", "rich.console",
             "distributed")
PYTEST = ["-x", "-q", "--no-header", "--tb=line", "-p", "no:cacheprovider", "-m", "not slow and not peers"]
PDEATHSIG = 1
SECONDS = {"processor": 90, "asleep": 600}  # of a stage; what computes longer, or does nothing for so long, hangs
BYTES = 6 << 30  # what fills more memory fails


def judged() -> dict[tuple, str]:
    """The reason why a mutant changes nothing, by its key."""
    listed = yaml.safe_load(JUDGED.read_text()) or []
    return {(j["file"], j["function"], j["from"], j["to"]): j["reason"] for j in listed}


def recorded() -> dict[tuple, list[dict]]:
    """Trials so far, by the mutant's key, the first one first."""
    found: dict[tuple, list[dict]] = {}
    for line in RESULTS.read_text().splitlines() if RESULTS.exists() else []:
        trial = json.loads(line)
        found.setdefault(tuple(trial["key"]), []).append(trial)
    return found


def listed(*options: str) -> list[str]:
    """Files of the checkout, as git lists them."""
    return subprocess.run(["git", "ls-files", *options], cwd=ROOT, capture_output=True, text=True,
                          check=True).stdout.splitlines()


def sampled(room: str, size: int, seed: int) -> tuple[list[Mutant], int]:
    """The room's sample, and how many mutants there are."""
    every = [mutant for file in listed("*.py", "*.c") if tests(room, file) for mutant in mutants(ROOT, file)]
    return sorted(every, key=lambda mutant: mutant.drawn(seed))[:size], len(every)


def asleep(group: int) -> bool:
    """Whether all processes of a group wait; one that a busy machine keeps from running does not."""
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            state, _, its_group, *_ = stat.read_text().rpartition(")")[2].split()
            if int(its_group) == group and state not in "SZ":
                return False
    return True


class Copy:
    """A copy of the checkout, with the FMUs that are built, to try mutants in."""

    def __init__(self, folder: str) -> None:
        self.root, self.sound = Path(tempfile.mkdtemp(dir=folder)), set[str]()
        for name in listed("--cached", "--others", "--exclude-standard"):
            if (ROOT / name).is_file():
                (self.root / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(ROOT / name, self.root / name)
                compiled = Path(cache_from_source(name))
                if name.endswith(".py") and (ROOT / compiled).is_file():
                    (self.root / compiled).parent.mkdir(exist_ok=True)
                    shutil.copy2(ROOT / compiled, self.root / compiled)
        self.dist, self.built = self.root / "fmus" / "dist", self.root / "results" / "dist"
        shutil.copytree(ROOT / "fmus" / "dist", self.dist)
        shutil.copytree(self.dist, self.built, ignore=shutil.ignore_patterns(".*"))

    def run(self, room: str, stage: str) -> tuple[bool, str]:
        """Whether the tests of a stage pass, and if not, what ended it."""
        for built in self.built.glob("*/*"):
            shutil.copy2(built, self.dist / built.relative_to(self.built))
        pid = os.fork()
        if not pid:
            self.child(room, stage)
        awake = time.monotonic()
        while not (ended := os.waitpid(pid, os.WNOHANG))[0] and time.monotonic() < awake + SECONDS["asleep"]:
            time.sleep(0.1)
            if time.monotonic() > awake + 5 and not asleep(pid):
                awake = time.monotonic()
        with suppress(ProcessLookupError):  # what the tests started and left
            os.killpg(pid, signal.SIGKILL)
        status = ended[1] if ended[0] else os.waitpid(pid, 0)[1]
        said = (self.root / "results" / "said.txt").read_text(errors="replace").splitlines()
        if not ended[0] or os.WTERMSIG(status) == signal.SIGXCPU:
            return False, "time"
        failed = [line.split(" - ")[0].split("/")[-1] for line in said if line.startswith(("FAILED", "ERROR"))]
        return status == 0, failed[0] if failed else f"status {status}"

    def child(self, room: str, stage: str) -> NoReturn:
        """In the forked process: pytest in the copy, in a process group of its own."""
        try:
            os.setsid()
            ctypes.CDLL(None).prctl(PDEATHSIG, signal.SIGKILL)  # it ends with its worker
            os.chdir(self.root)
            out = os.open("results/said.txt", os.O_WRONLY | os.O_CREAT | os.O_TRUNC)
            os.dup2(out, 1)
            os.dup2(out, 2)
            resource.setrlimit(resource.RLIMIT_CPU, (SECONDS["processor"], SECONDS["processor"] + 5))
            resource.setrlimit(resource.RLIMIT_DATA, (BYTES, BYTES))
            os.environ.update(PYTHONPATH=str(self.root), PYTHONDONTWRITEBYTECODE="1", CI="1")
            sys.dont_write_bytecode = True  # bytecode is taken for a file's if time and size agree
            sys.path[:1] = [str(self.root), str(self.root / "benchmarks")]
            self.narrow(room, stage)
            names, _, chosen = stage.removeprefix("platforms ").partition(" -k ")
            files = [f"tests/{name}.py" for name in names.split()]
            os._exit(int(import_module("pytest").main([*PYTEST, "-k", chosen, *files])))
        except BaseException as error:
            print(f"ERROR {error!r}", file=sys.stderr, flush=True)
            os._exit(99)

    def narrow(self, room: str, stage: str) -> None:
        """Build no FMUs but those that the stage needs, and as cheaply as it allows; small.c once only."""
        building, flavour = import_module("fmus.builder"), import_module("fmus.native_flavour")
        assert str(building.__file__).startswith(str(self.root)), "the tests would not try the copy"
        every, small = stage.startswith("platforms "), import_module("small")
        compiled = small.library
        small.library = lambda folder, *flags: compiled(self.root / "results" / "small", *flags)
        if room not in FMUS:
            return
        registry = import_module("cosim.vehicle.registry")
        wanted = ("AhvScenario",) if every else FMUS[room] or registry.MODELS
        registry.MODELS = {name: registry.MODELS[name] for name in wanted}
        if not every:
            flavour.PLATFORMS = {"x86_64-linux": flavour.PLATFORMS["x86_64-linux"]}
        names, make = {module: name for name, module in registry.MODELS.items()}, building.build

        def built(model: str, flavour: str, *more: object, fmi: str = "2") -> Path:
            if flavour == "native" and model in names:
                file = self.dist / building.folder(flavour, fmi) / f"{names[model]}.fmu"
                return recompiled(file, self.root / "fmus" / "wrapper")
            return make(model, flavour, *more, fmi=fmi)

        if room == "wrapper":
            building.build = built

    def trial(self, room: str, mutant: Mutant) -> dict:
        """A mutant's verdict, by what, and after how long. Raises RuntimeError where a test fails without it."""
        began, by = time.monotonic(), ""
        for stage in tests(room, mutant.file) or []:
            passed, by = self.mutated(room, stage, mutant)
            if passed:
                continue
            if stage not in self.sound:
                sound, reason = self.run(room, stage)
                if not sound:
                    raise RuntimeError(f"{stage} fails on the tree as it is, by {reason}")
                self.sound.add(stage)
            break
        else:
            by = ""
        seconds = round(time.monotonic() - began, 1)
        return {"room": room, "key": mutant.key, "killed": bool(by), "by": by, "seconds": seconds}

    def mutated(self, room: str, stage: str, mutant: Mutant) -> tuple[bool, str]:
        """What `run` says while the file is mutated; it is put back with its date, which its bytecode goes by."""
        target = self.root / mutant.file
        original, state = target.read_bytes(), target.stat()
        try:
            target.write_text(mutant.text, encoding="utf-8")
            return self.run(room, stage)
        finally:
            target.write_bytes(original)
            os.utime(target, ns=(state.st_atime_ns, state.st_mtime_ns))


copy: Copy


def begin(folder: str) -> None:
    """A worker begins: with its copy below `folder`, and with what all trials need."""
    global copy
    os.nice(max(0, 10 - os.nice(0)))  # no more than others of this machine that compute in the background
    copy = Copy(folder)
    compileall.compile_dir(copy.root, quiet=2)
    for library in LIBRARIES:
        if find_spec(library.split(".")[0]):
            import_module(library)


def attempt(task: tuple[str, Mutant]) -> dict:
    """One trial in this worker's copy."""
    return copy.trial(*task)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sample", type=int, default=406, help="mutants in all, the same number of every room")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--room", choices=ROOMS, action="append", help="this room only; may be repeated")
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--retry", action="store_true", help="try survivors again")
    parser.add_argument("--table", action="store_true", help="write docs/mutants.md from what is recorded, and end")
    options = parser.parse_args()
    share = -(-options.sample // len(ROOMS))
    samples = {room: sampled(room, share, options.seed) for room in options.room or ROOMS}
    known, equivalent = recorded(), judged()
    if options.table:
        return write_table(ROOT, samples, known, equivalent)
    tasks = [(room, mutant) for room, (sample, _) in samples.items() for mutant in sample
             if mutant.key not in equivalent
             and (mutant.key not in known or (options.retry and not known[mutant.key][-1]["killed"]))]
    RESULTS.parent.mkdir(exist_ok=True)
    commit = head(ROOT)
    with (tempfile.TemporaryDirectory(prefix="mutants.") as folder, RESULTS.open("a") as results,
          multiprocessing.get_context("fork").Pool(options.workers, begin, (folder,)) as pool):
        for count, found in enumerate(pool.imap_unordered(attempt, tasks), 1):
            results.write(json.dumps({**found, "commit": commit}) + "\n")
            results.flush()
            verdict = f"killed by {found['by']}" if found["killed"] else "SURVIVED"
            print(f"{count}/{len(tasks)} {found['seconds']} s", verdict, *found["key"], sep=" | ", flush=True)


if __name__ == "__main__":
    main()
