"""Runs an FMU in child processes, so that a crash or a hang is a finding and does not end the check.

The child (child.py) answers one JSON line for each event, by a pipe. When it crashes or hangs, the last "begin" line
names the probe, the mark names the call, and a new child runs the remaining probes.
"""
import contextlib
import json
import time
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

from . import probes  # noqa: F401  (importing the probes registers them)
from .confined import Confined, Limits, sandbox, why
from .fmi2 import MARK_BYTES, Mark
from .job import Job
from .job_of import host_library, make_job
from .probes.registry import FLYING, PROBES
from .report import EVERYTHING, Finding, Report
from .rule import ERROR, FORMAL, REFUSED, RULES, WARNING
from .subject import Fault, Fmu

POLL_S = 0.05
WRONG_USE_S = 5.0  # that a call may take which the standard does not allow
MOST_HANGS = 2  # after wrong use
MOST_DEATHS = 2  # on wrong use of one kind, such as "unknown-reference"
MOST_LIMITS = 4  # a probe whose calls all return is given up after this many time limits
FATAL_RULES = {"dynamic.load": "the FMU cannot be loaded", "dynamic.hang": "the FMU hangs",
               "dynamic.limits": "the FMU passed a limit"}
ONCE = ("dynamic.fatal", "dynamic.log-refusal")  # an FMU that does so does so for any call
IMPLIED = {"dynamic.nonfinite-reset": "dynamic.reset-replay"}  # what says nothing more where another is broken


def run(fmu: Fmu, report: Report, work: Path, limits: Limits, cycles: int) -> None:
    """Run all probes on the FMU and note what they find."""
    library = host_library(fmu)
    if library is None:
        report.skip(EVERYTHING, f"no binary for this platform (binaries/{fmu.version.host})")
        return
    report.sandbox = sandbox() or "none"
    job = make_job(fmu, library, limits.call_s, cycles)
    report.initialized_only = bool(job.clocks)
    run_probes(job, report, work, limits)
    for rule in ONCE:
        report.merge(rule)
    for rule, cause in IMPLIED.items():
        if any((f.rule, f.severity) == (cause, ERROR) for f in report.findings):
            report.findings = [f for f in report.findings if f.rule != rule]


def run_probes(job: Job, report: Report, work: Path, limits: Limits) -> None:
    """Run the job's probes, in a new child process where one has ended."""
    now = time.monotonic()
    deadline, job = now + limits.total_s, replace(job, until=now + limits.budget_s)
    deaths: Counter[str] = Counter()
    while job.probes:
        done, steps, died = run_child(job, report, work, limits, deadline)
        if done == 0:
            reason = (work / "stderr.txt").read_text("utf-8", "replace").strip() or "no reason given"
            raise RuntimeError(f"the checking process did not begin with '{job.probes[0]}': {reason}")
        cause = next((FATAL_RULES[f.rule] for f in report.findings if ends_the_check(f)), None)
        if cause:
            report.skip("the probes after that", cause)
        is_slow = any(item.why == "the FMU is slow" for item in report.not_tested)
        if cause or is_slow or not report.ran:
            return
        left = job.probes[done:]
        if sum(f.rule == "dynamic.hang" for f in report.findings) >= MOST_HANGS:
            left = without(left, [n for n in left if not PROBES[n].legal], "the FMU hangs on wrong use", report)
        if died:
            family = job.probes[done - 1].partition(":")[0]
            deaths[family] += 1
            if deaths[family] >= MOST_DEATHS:
                alike = [n for n in left if n.partition(":")[0] == family]
                left = without(left, alike, "the FMU has crashed on others of this kind", report)
        job = replace(job, probes=left, steps=steps)


def without(names: list[str], dropped: list[str], why: str, report: Report) -> list[str]:
    """The probes `names` but for those that are dropped, which are reported as not tested."""
    if dropped:
        report.skip(", ".join(dropped), why)
    return [name for name in names if name not in dropped]


def ends_the_check(finding: Finding) -> bool:
    """Whether further probes would only find the same again (a hang after an illegal call is only a warning)."""
    always = finding.rule in ("dynamic.load", "dynamic.limits")
    return always or (finding.rule == "dynamic.hang" and finding.severity == ERROR)


def run_child(job: Job, report: Report, work: Path, limits: Limits, deadline: float) -> tuple[int, int, bool]:
    """Run one child until it ends, crashes or is stopped, and note its findings.

    How many probes have been begun, how many steps further runs shall have, and whether the last probe did not end.
    """
    mark = work / "mark.bin"
    mark.write_bytes(bytes(MARK_BYTES))
    child = Confined("cosim.conformance.child", [str(mark)], job.to_json(), work, limits)
    try:
        stopped = wait_for_end(child, mark, limits, deadline)
    finally:
        child.end()
    begun, ended, told = take_answers(child.answers, report)
    died = str(told.get("died", ""))
    if len(begun) > len(ended):
        death = stopped or died or why(child.process.returncode, limits) or "exit code 0"
        report_death(report, job, begun[-1], death, Mark.read(mark)[1], limits)
    return len(begun), told.get("steps", job.steps), len(begun) > len(ended)


def wait_for_end(child: Confined, mark: Path, limits: Limits, deadline: float) -> str:
    """Wait for the end; "hang", "slow" or "limit: ..." when waiting was given up, else an empty text."""
    seen: tuple[int, int] = (0, 0)
    call_began = probe_began = time.monotonic()
    while child.process.poll() is None:
        time.sleep(POLL_S)
        now = time.monotonic()
        calls, answers = Mark.read(mark)[0], len(child.answers)
        if calls != seen[0]:
            call_began = now
        if answers != seen[1]:
            call_began = probe_began = now
        seen = calls, answers
        if child.flooded:
            return "limit: its answers do not end"
        if now > deadline:
            return f"limit: {limits.total_s:g} s for the whole check"
        if now - call_began > call_limit(child.answers, limits):
            return "hang"
        if now - probe_began > MOST_LIMITS * limits.call_s:
            return "slow"
    return ""


def call_limit(answers: list[str], limits: Limits) -> float:
    """Seconds that a call may take in the probe that runs; after wrong use it is not worth to wait as long."""
    begun = (json.loads(line)["begin"] for line in reversed(answers) if line.startswith('{"begin"'))
    with contextlib.suppress(ValueError, KeyError):
        if not PROBES[next(begun, "load")].legal:
            return min(limits.call_s, WRONG_USE_S)
    return limits.call_s


def take_answers(lines: list[str], report: Report) -> tuple[list[str], list[str], dict[str, Any]]:
    """Put the child's lines into the report; the probes that began, those that ended, and what else it told."""
    begun: list[str] = []
    ended: list[str] = []
    told: dict[str, Any] = {}
    known = {(f.rule, f.variable, f.found) for f in report.findings}
    for text in lines:
        line = answer(text, begun)
        if "rule" in line:
            fault = Fault(*line["fault"])
            if (line["rule"], fault.variable, fault.found) not in known:
                known.add((line["rule"], fault.variable, fault.found))
                report.add(line["rule"], fault, line["severity"], line.get("impact"))
        elif "skip" in line:
            report.skip(*line["skip"])
        elif "begin" in line:
            begun.append(line["begin"])
        elif "end" in line:
            ended.append(line["end"])
        else:
            told |= line
    return begun, ended, told


def answer(text: str, begun: list[str]) -> dict[str, Any]:
    """A line of the child; a line that it cannot have written (the FMU wrote where the answers go) is a finding."""
    try:
        line: dict[str, Any] = json.loads(text)
        ended = "end" in line and line["end"] == begun[-1]
        found_one = line.get("rule") in RULES and Fault(*line["fault"])
        fewer = isinstance(line.get("steps"), int) and line["steps"] > 0
        if ended or found_one or fewer or line.keys() & {"begin", "skip", "died"}:
            return line
    except (ValueError, IndexError, TypeError, AttributeError):
        pass
    found = "it wrote to a file that it did not open, where the answers of its check go"
    return {"rule": "dynamic.limits", "fault": ["file descriptors", found, "its own files only"], "severity": None}


def report_death(report: Report, job: Job, probe: str, death: str, call: str, limits: Limits) -> None:
    """Report why a probe did not end. After an illegal call that is a warning only, since the caller is at fault."""
    severity, impact = (None, None) if PROBES[probe].legal else (WARNING, FORMAL)
    if probe not in FLYING:
        impact = impact or REFUSED
    if probe == "free-null":
        impact = FORMAL  # no master needs that call
    if death == "slow":
        report.skip(probe, f"slow: not finished within {MOST_LIMITS * limits.call_s:g} s")
    elif death.startswith("limit: "):
        found = f"{death.removeprefix('limit: ')}, in {call} (probe '{probe}')"
        is_late = death.endswith("whole check")  # a slow FMU, or a slow machine
        report.add("dynamic.limits", Fault(call, found, "what the check's limits allow"), WARNING if is_late else None,
                   FORMAL if is_late else None)
    elif death == "hang" and call.endswith("DoStep") and not job.has_step and severity is None:
        report.skip(probe, f"slow: a step of {job.step:g} s did not end within {limits.call_s:g} s (the file names no "
                           "preferred step)")
        report.skip("the probes after that", "the FMU is slow")
    elif death == "hang":
        seconds = limits.call_s if PROBES[probe].legal else min(limits.call_s, WRONG_USE_S)
        found = f"{call} did not return within {seconds:g} s (probe '{probe}')"
        report.add("dynamic.hang", Fault(call, found, "a status, in time"), severity, impact)
    else:
        found = f"{call} ended the process with {death} (probe '{probe}')"
        if not any((f.rule, f.variable) == ("dynamic.crash", call) for f in report.findings):
            report.add("dynamic.crash", Fault(call, found, "a status"), severity, impact)
