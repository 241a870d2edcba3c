"""The child process: loads the FMU, runs the probes one after the other, and answers one JSON line for each event.

    python -m cosim.conformance.child LIMITS MARK       (the job comes by its standard input, see confined.py)

A crash or a hang ends this process only. The parent then knows the probe from the last "begin" line and the call from
the mark, and starts a new child for the remaining probes.
"""
import re
import sys
import time
from pathlib import Path

from . import probes  # noqa: F401  (importing the probes registers them)
from .confined import guarded
from .fmi2 import DISCARD, FATAL, PENDING, Mark
from .job import Job
from .probes.bench import Bench
from .probes.registry import FLYING, PROBES, CallFailed, EndedItself, NoInstance, Stopped

LACKING = r"cannot open shared object file|version `.*' not found"  # what dlopen says of other libraries
LICENCE = r"licen[cs]e"


def work(text: str, answers: int) -> None:
    """Run the probes of the job until one needs a fresh process; lines go to the file descriptor `answers`."""
    job = Job.read(text)
    bench = Bench(job, Mark(Path(sys.argv[2])), answers)
    for number, name in enumerate(job.probes):
        if time.monotonic() > job.until:
            bench.skip(", ".join(job.probes[number:]), "slow: there was no time left for this")
            for left in job.probes[number:]:
                bench.note("begin", left)
                bench.note("end", left)
            return
        bench.note("begin", name)
        is_loaded = loads(bench)
        if is_loaded:
            run_probe(bench, name)
        bench.note("end", name)
        if not is_loaded or bench.is_over or bench.library.is_corrupt or bench.is_single:
            return  # the parent starts a new process for the remaining probes


def loads(bench: Bench) -> bool:
    """Whether the library loads; if not, that is reported."""
    try:
        return bench.library is not None
    except OSError as problem:
        reason = str(problem).replace(bench.job.library, Path(bench.job.library).name)
    if re.search(LACKING, reason):
        bench.skip("everything dynamic", f"this machine lacks what the binary needs: {reason}")
    else:
        severity = "warning" if bench.job.claims.get("needsExecutionTool") else None
        bench.fault("dynamic.load", "binaries", reason, "a library that loads", severity)
    return False


def run_probe(bench: Bench, name: str) -> None:
    """Run one probe and report how it failed, if it did."""
    if PROBES[name].many and bench.is_single:
        bench.skip(name, "the FMU says that a process may instantiate it once only")
        return
    try:
        PROBES[name].run(bench)
    except CallFailed as failure:
        report_failure(bench, name, failure)
    except Stopped:
        pass
    except EndedItself as ended:
        bench.skip(name, str(ended))
    except NoInstance:
        report_no_instance(bench, name)
    except Exception as problem:  # a fault of this checker is no finding about the FMU
        bench.skip(name, f"this checker failed with {type(problem).__name__}: {problem}")


def report_no_instance(bench: Bench, name: str) -> None:
    """Report a null pointer instead of an instance; without a licence or the tool that it needs, that is no breach."""
    words = f": '{bench.library.words}'" if bench.library.words else ""
    if re.search(LICENCE, words, re.IGNORECASE):
        bench.skip("everything dynamic", f"this machine lacks a licence for the FMU{words}")
        bench.is_over = True
        return
    severity = "warning" if bench.job.claims.get("needsExecutionTool") else None
    lived = bench.library.lived
    found, impact = f"a null pointer{words}", None
    if lived:
        found += f" after {lived} instances in one process, of which at most two lived at a time (probe '{name}')"
        impact = "other tools refuse it"
        bench.is_over = True  # a fresh process may do better
    bench.fault("dynamic.instantiate", "fmi2Instantiate", found, "an instance", severity, impact)


def report_failure(bench: Bench, name: str, failure: CallFailed) -> None:
    """Report a legal call that the FMU refused."""
    if failure.status == PENDING and bench.job.claims.get("canRunAsynchronuously"):
        bench.skip(name, "the FMU steps asynchronously")
        return
    expected = "fmi2OK" if failure.status != FATAL else "fmi2OK; fmi2Fatal makes every instance unusable"
    # A slave may discard a step that it cannot take (4.2.2), but then it does not run by its own default experiment.
    severity = "warning" if (failure.call, failure.status) == ("fmi2DoStep", DISCARD) else None
    impact = None if name in FLYING and failure.call != "fmi2Terminate" else "other tools refuse it"
    words = f": '{bench.library.words}'" if bench.library.words else ""
    bench.fault("dynamic.legal-call", failure.call, f"{failure}{words}", expected, severity, impact)


if __name__ == "__main__":
    guarded(work)
