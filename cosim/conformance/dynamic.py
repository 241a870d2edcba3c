"""Runs an FMU in child processes, so that a crash or a hang is a finding and does not end the check.

The child (child.py) answers one JSON line for each event, by a pipe. When it crashes or hangs, the last "begin" line
names the probe, the mark names the call, and a new child runs the remaining probes.
"""
import contextlib
import json
import os
import platform
import time
from collections import Counter
from dataclasses import replace
from math import prod
from pathlib import Path
from typing import Any

from ..master.declared import Variable, integer, number
from . import probes  # noqa: F401  (importing the probes registers them)
from .confined import Confined, Limits, sandbox, why
from .fmi2 import MARK_BYTES, Mark
from .job import Job, Known
from .probes.registry import FLYING, PROBES
from .report import EVERYTHING, Finding, Report
from .rule import ERROR, FORMAL, REFUSED, RULES, WARNING
from .rules.structure import is_clocked
from .subject import Fault, Fmu

POLL_S = 0.05
STEPS = 20  # of a run
PATIENCE_S = 8.0  # for repetitions
WRONG_USE_S = 5.0  # that a call may take which the standard does not allow
MOST_HANGS = 2  # after wrong use
MOST_DEATHS = 2  # on wrong use of one kind, such as "unknown-reference"
TOLERANCE = 1e-4  # where the file names none
MOST_LIMITS = 4  # a probe whose calls all return is given up after this many time limits
FATAL_RULES = {"dynamic.load": "the FMU cannot be loaded", "dynamic.hang": "the FMU hangs",
               "dynamic.limits": "the FMU passed a limit"}
ONCE = ("dynamic.fatal", "dynamic.log-refusal")  # an FMU that does so does so for any call
IMPLIED = {"dynamic.nonfinite-reset": "dynamic.reset-replay"}  # what says nothing more where another is broken
WITH_CLOCKS = ("load", "free-null", "guid", "event-mode")  # the probes of an FMU with clocks, which nobody ticks
MOST_ELEMENTS = 10_000  # of an array that is read and set
LATE = ("memory", "memory-steps")  # what takes many lives


def run(fmu: Fmu, report: Report, work: Path, limits: Limits, cycles: int) -> None:
    """Run all probes on the FMU and note what they find."""
    library = host_library(fmu)
    if library is None:
        report.skip(EVERYTHING, f"no binary for this platform (binaries/{fmu.version.host})")
        return
    report.sandbox = sandbox() or "none"
    run_probes(make_job(fmu, library, limits.call_s, cycles), report, work, limits)
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


def host_library(fmu: Fmu) -> Path | None:
    """The FMU's shared library for this machine, or None."""
    host = fmu.version.host
    is_foreign = host == "linux64" and platform.machine() not in ("x86_64", "AMD64")
    suffix = fmu.version.platforms.get(host, (".so",))[0]
    return None if is_foreign else fmu.library(host, suffix)


def make_job(fmu: Fmu, library: Path, time_limit: float, cycles: int) -> Job:
    """What the child needs to know about the FMU."""
    given = {key: number(text) for key, text in fmu.description.experiment.items()}
    start, stop, step = given.get("startTime") or 0.0, given.get("stopTime"), given.get("stepSize")
    has_step = bool(step and step > 0)
    if not step or step <= 0:
        step = (stop - start) / 100 if stop is not None and stop > start else 0.01
    fixed = number((fmu.description.co_simulation or {}).get("fixedInternalStepSize")) or 0.0
    if fixed > 0:  # FMI 3.0: steps should be multiples of it
        step = fixed * max(1, round(step / fixed))
    tolerance = given.get("tolerance") or 0.0
    has_tolerance = 0 < tolerance < 1
    fitting = int((stop - start) / step + 1e-9) if stop is not None and stop > start else STEPS
    steps = max(2, min(STEPS, fitting))  # not beyond the default stop time
    claims = {flag: 1 for flag in fmu.version.flags if fmu.description.claims(flag)}
    resources = fmu.folder / "resources"
    variables = [known_variable(v, v.causality == "output" or v.index in fmu.description.states, fmu.description.flat)
                 for v in fmu.description.variables if v.type and v.reference is not None and not is_clocked(v)]
    order = integer((fmu.description.co_simulation or {}).get("maxOutputDerivativeOrder")) or 0
    return Job(
        library=str(library),
        guid=fmu.description.attributes.get(fmu.version.token, ""),
        resources=f"{resources}{os.sep}" if fmu.description.flat else resources.as_uri(),
        start=start,
        stop=stop,
        step=step,
        has_step=has_step,
        tolerance=tolerance if has_tolerance else TOLERANCE,
        has_tolerance=has_tolerance,
        claims=claims | ({"maxOutputDerivativeOrder": order} if order else {}),
        categories=[c.get("name", "") for c in fmu.description.root.iterfind("LogCategories/Category")],
        variables=[v for v in variables if (v.count or 1) <= MOST_ELEMENTS and v.count != 0],
        probes=sorted(served(fmu), key=lambda name: (not PROBES[name].legal, name in LATE)),  # wrong use comes last
        steps=steps,
        cycles=cycles,
        patience=min(time_limit / 2, PATIENCE_S),
        version=fmu.version.name,
        clocks=clocks_of(fmu),
        fixed_step=fixed,
        until=0.0,
    )


def served(fmu: Fmu) -> list[str]:
    """The probes for the FMU's version, and for clocks where it has some."""
    own = [name for name, one in PROBES.items() if fmu.version.name in one.versions]
    return [name for name in own if name in WITH_CLOCKS] if clocks_of(fmu) else own


def clocks_of(fmu: Fmu) -> str:
    """Which clocks the FMU has: see `Job.clocks`."""
    clocks = [v for v in fmu.description.variables if v.type == "Clock"]
    timed = any(v.causality == "input" and v.resolved("intervalVariability") != "triggered" for v in clocks)
    return "timed" if timed else "triggered" if clocks else ""


def known_variable(v: Variable, counts: bool, is_flat: bool) -> Known:
    """The variable as the probes need it."""
    count = None if v.shape is None else prod(v.shape)
    texts = [v.start] if count is None else v.starts * count if len(v.starts) == 1 else v.starts
    starts = [start_value(v, text) for text in texts]
    if count is not None and len(starts) != count:
        starts = []  # rule array.starts
    return Known(
        name=v.name,
        reference=v.reference or 0,
        base="Int64" if v.type == "Enumeration" and is_flat else v.base,
        causality=v.causality,
        variability=v.variability,
        initial=v.initial,
        start=starts[0] if starts else None,
        low=v.min,
        high=v.max,
        nominal=v.nominal,
        counts=counts,
        items=list(v.items.values()),
        count=count,
        starts=[] if count is None else starts,
    )


def start_value(v: Variable, text: str | None) -> float | int | str | None:
    """One start value as the probes need it."""
    if v.family == "Real":
        return number(text)
    if v.type == "Boolean":
        return None if text is None else int(text.strip() in ("true", "1"))
    if v.type == "Binary":
        return None if text is None else text.strip().lower()
    return text if v.type == "String" else integer(text)


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
