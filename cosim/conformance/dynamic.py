"""Runs an FMU in child processes, so that a crash or a hang is a finding and does not end the check.

The child (child.py) writes one JSON line for each event. When it crashes or hangs, the last "begin" line names the
probe, the mark names the call, and a new child runs the remaining probes.
"""
import contextlib
import json
import os
import platform
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

from . import probes  # noqa: F401  (importing the probes registers them)
from .description import Variable, integer, number
from .fmi2 import MARK_BYTES, Mark
from .job import Job, Known
from .probes.bench import PROBES
from .report import Finding, Report
from .rule import ERROR, WARNING
from .subject import Fault, Fmu

POLL_S = 0.05
MOST_LIMITS = 4  # a probe whose calls all return is given up after this many time limits
FATAL_RULES = {"dynamic.load": "the FMU cannot be loaded", "dynamic.hang": "the FMU hangs"}
ONCE = ("dynamic.fatal", "dynamic.log-refusal")  # an FMU that does so does so for any call
FLAGS = ("canHandleVariableCommunicationStepSize", "canInterpolateInputs", "canRunAsynchronuously",
         "needsExecutionTool", "canBeInstantiatedOnlyOncePerProcess", "canGetAndSetFMUstate", "canSerializeFMUstate",
         "providesDirectionalDerivative")


def run(fmu: Fmu, report: Report, work: Path, time_limit: float, cycles: int) -> None:
    """Run all probes on the FMU and note what they find. A single call may take `time_limit` seconds."""
    library = host_library(fmu)
    if library is None:
        report.skip("everything dynamic", f"no binary for this platform (binaries/{host_platform()})")
        return
    run_probes(make_job(fmu, library, time_limit, cycles), report, work, time_limit)
    for rule in ONCE:
        report.merge(rule)


def run_probes(job: Job, report: Report, work: Path, time_limit: float) -> None:
    """Run the job's probes, in a new child process where one has ended."""
    while job.probes:
        done = run_child(job, report, work, time_limit)
        if done == 0:
            reason = (work / "stderr.txt").read_text("utf-8", "replace").strip() or "no reason given"
            raise RuntimeError(f"the checking process did not begin with '{job.probes[0]}': {reason}")
        why = next((FATAL_RULES[f.rule] for f in report.findings if ends_the_check(f)), None)
        if why:
            report.skip("the probes after that", why)
            return
        job = replace(job, probes=job.probes[done:])


def ends_the_check(finding: Finding) -> bool:
    """Whether further probes would only find the same again (a hang after an illegal call is only a warning)."""
    return finding.rule == "dynamic.load" or (finding.rule == "dynamic.hang" and finding.severity == ERROR)


def host_platform() -> str:
    """The name of the folder below binaries/ that holds this machine's library (2.3)."""
    system = {"Windows": "win", "Darwin": "darwin"}.get(platform.system(), "linux")
    return f"{system}{'64' if sys.maxsize > 2**32 else '32'}"


def host_library(fmu: Fmu) -> Path | None:
    """The FMU's shared library for this machine, or None."""
    suffix = {"win": ".dll", "dar": ".dylib"}.get(host_platform()[:3], ".so")
    file = fmu.folder / "binaries" / host_platform() / f"{fmu.identifier}{suffix}"
    is_foreign = host_platform() == "linux64" and platform.machine() not in ("x86_64", "AMD64")
    return file if file.is_file() and not is_foreign else None


def make_job(fmu: Fmu, library: Path, time_limit: float, cycles: int) -> Job:
    """What the child needs to know about the FMU."""
    experiment = fmu.description.root.find("DefaultExperiment")
    given = {} if experiment is None else {str(key): number(str(text)) for key, text in experiment.attrib.items()}
    start, stop, step = given.get("startTime") or 0.0, given.get("stopTime"), given.get("stepSize")
    if not step or step <= 0:
        step = (stop - start) / 100 if stop is not None and stop > start else 0.01
    claims = {flag: 1 for flag in FLAGS if fmu.description.claims(flag)}
    order = integer((fmu.description.co_simulation or {}).get("maxOutputDerivativeOrder")) or 0
    return Job(
        library=str(library),
        guid=fmu.description.attributes.get("guid", ""),
        resources=(fmu.folder / "resources").as_uri(),
        start=start,
        stop=stop,
        step=step,
        claims=claims | ({"maxOutputDerivativeOrder": order} if order else {}),
        categories=[c.get("name", "") for c in fmu.description.root.iterfind("LogCategories/Category")],
        variables=[known_variable(v) for v in fmu.description.variables if v.kind and v.reference is not None],
        probes=list(PROBES),
        cycles=cycles,
        patience=time_limit / 2,
    )


def known_variable(v: Variable) -> Known:
    """The variable as the probes need it."""
    start: float | int | str | None
    if v.kind == "Real":
        start = number(v.start)
    elif v.kind == "Boolean":
        start = None if v.start is None else int(v.start.strip() in ("true", "1"))
    else:
        start = v.start if v.kind == "String" else integer(v.start)
    items = [] if v.declared is None else [integer(item.get("value")) for item in v.declared.items]
    return Known(
        name=v.name,
        reference=v.reference or 0,
        base=v.base,
        causality=v.causality,
        variability=v.variability,
        initial=v.initial,
        start=start,
        low=number(v.resolved("min")),
        high=number(v.resolved("max")),
        nominal=number(v.resolved("nominal")),
        items=[value for value in items if value is not None],
    )


def run_child(job: Job, report: Report, work: Path, time_limit: float) -> int:
    """Run one child until it ends, crashes or is stopped, and note its findings; how many probes have been begun."""
    files = [work / name for name in ("job.json", "results.jsonl", "mark.bin")]
    files[0].write_text(job.to_json(), encoding="utf-8")
    files[1].write_text("", encoding="utf-8")
    files[2].write_bytes(bytes(MARK_BYTES))
    root = str(Path(__file__).parents[2])
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([root, os.environ.get("PYTHONPATH", "")])}
    command = [sys.executable, "-P", "-m", "cosim.conformance.child", *map(str, files)]
    with (work / "stderr.txt").open("wb") as errors:
        child = subprocess.Popen(command, cwd=work, env=environment, stdin=subprocess.DEVNULL,
                                 stdout=subprocess.DEVNULL, stderr=errors,
                                 start_new_session=True)  # so that whatever the FMU starts ends with it
        try:
            stopped = wait_for_end(child, files[1], files[2], time_limit)
        finally:
            end_child(child)
    begun, ended = take_results(files[1], report)
    if len(begun) > len(ended):
        report_death(report, begun[-1], stopped or cause_of_death(child.returncode), Mark.read(files[2])[1], time_limit)
    return len(begun)


def end_child(child: subprocess.Popen[bytes]) -> None:
    """End the child and the processes that its FMU started."""
    if os.name == "posix":
        with contextlib.suppress(ProcessLookupError):
            os.killpg(child.pid, signal.SIGKILL)
    child.kill()
    child.wait()


def wait_for_end(child: subprocess.Popen[bytes], results: Path, mark: Path, time_limit: float) -> str:
    """Wait for the end; "hang" or "slow" when waiting was given up, else an empty text."""
    seen: tuple[int, int] = (0, 0)
    call_began = probe_began = time.monotonic()
    while child.poll() is None:
        time.sleep(POLL_S)
        now = time.monotonic()
        calls, size = Mark.read(mark)[0], results.stat().st_size
        if calls != seen[0]:
            call_began = now
        if size != seen[1]:
            call_began = probe_began = now
        seen = calls, size
        if now - call_began > time_limit:
            return "hang"
        if now - probe_began > MOST_LIMITS * time_limit:
            return "slow"
    return ""


def take_results(results: Path, report: Report) -> tuple[list[str], list[str]]:
    """Put the child's lines into the report; the probes that began, and those that ended."""
    begun, ended = [], []
    for text in results.read_text("utf-8").splitlines():
        line = json.loads(text)
        if "rule" in line:
            fault = Fault(*line["fault"])
            known = {(f.rule, f.variable, f.found) for f in report.findings}
            if (line["rule"], fault.variable, fault.found) not in known:
                report.add(line["rule"], fault, line["severity"])
        elif "skip" in line:
            report.skip(*line["skip"])
        elif "begin" in line:
            begun.append(line["begin"])
        else:
            ended.append(line["end"])
    return begun, ended


def report_death(report: Report, probe: str, death: str, call: str, time_limit: float) -> None:
    """Report why a probe did not end. After an illegal call that is a warning only, since the caller is at fault."""
    severity = None if PROBES[probe].legal else WARNING
    if death == "slow":
        report.skip(probe, f"slow: not finished within {MOST_LIMITS * time_limit:g} s")
    elif death == "hang":
        found = f"{call} did not return within {time_limit:g} s (probe '{probe}')"
        report.add("dynamic.hang", Fault(call, found, "a status, in time"), severity)
    else:
        found = f"{call} ended the process with {death} (probe '{probe}')"
        if not any((f.rule, f.variable) == ("dynamic.crash", call) for f in report.findings):
            report.add("dynamic.crash", Fault(call, found, "a status"), severity)


def cause_of_death(returncode: int) -> str:
    """The signal, or the exit code, with which the child ended."""
    if returncode < 0 and -returncode in signal.valid_signals():
        return f"signal {signal.Signals(-returncode).name}"
    return f"exit code {returncode}"
