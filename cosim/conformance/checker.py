"""The check: unpacks an FMU, reads it, applies the static rules, runs the probes, and removes its temporary files."""
import math
from pathlib import Path

from ..errors import UsageError
from ..master.unpack import BadArchive, safe_extract
from ..temporary import Folder, troubles
from . import dynamic, rules  # noqa: F401  (importing the rules registers them)
from .confined import Limits
from .reading import Unusable, read
from .report import EVERYTHING, Finding, Report
from .rule import DOES_NOT_LOAD, REFUSED, RULES, STATIC_CHECKS
from .subject import Fault, Fmu


def check(path: Path, run_probes: bool, limits: Limits, cycles: int) -> Report:
    """See `cosim.conformance.check`."""
    for option, value, unit in (("--time-limit", limits.call_s, " of seconds"),
                                ("--total-time-limit", limits.total_s, " of seconds"),
                                ("--time-budget", limits.budget_s, " of seconds"),
                                ("--memory-limit", limits.memory_mb, ""), ("--file-limit", limits.file_mb, ""),
                                ("--process-limit", limits.processes, "")):
        if not 0 < value < math.inf:
            raise UsageError(f"{option} {value:g} must be a positive number{unit}.")
    report = Report(Path(path))
    with Folder() as temporary, troubles(temporary.path):
        work = temporary.path
        try:
            folder = work / "fmu"
            folder.mkdir()
            fmu = read(report.fmu, folder, safe_extract(report.fmu, folder))
            report.fmi_version = fmu.version.name
            report.tool = fmu.description.attributes.get("generationTool", "")
        except BadArchive as problem:
            report.add(problem.rule, Fault(report.fmu.name, str(problem), "an FMU that can be unpacked"))
            return report
        except Unusable as problem:
            report.fmi_version = problem.version
            report.add(problem.rule, problem.fault)
            return report
        check_static(fmu, report)
        check_dynamic(fmu, report, work, run_probes, limits, cycles)
    return report


def check_static(fmu: Fmu, report: Report) -> None:
    """Add what the schema and the static rules find."""
    for fault in fmu.schema_faults:
        report.add("xml.schema", fault)
    for name, find in STATIC_CHECKS.items():
        if report.fmi_version in RULES[name].sections:
            for fault in find(fmu):
                report.add(name, fault, impact=REFUSED if is_foreign(name, fault, fmu) else None)


def is_foreign(rule: str, fault: Fault, fmu: Fmu) -> bool:
    """Whether a fault is in a binary of another platform, which is nothing to this machine."""
    of_binary = rule.startswith("binary.") and fault.variable.startswith("binaries/")
    return of_binary and RULES[rule].impact == DOES_NOT_LOAD and fault.variable != here(fmu)


def here(fmu: Fmu) -> str:
    """The folder of the binary for this machine, as findings name it."""
    return f"binaries/{fmu.version.host}"


def check_dynamic(fmu: Fmu, report: Report, work: Path, run_probes: bool, limits: Limits, cycles: int) -> None:
    """Add what the probes find, or why they were not run."""
    if not run_probes:
        report.skip(EVERYTHING, "not asked for")
    elif fmu.description.co_simulation is None:
        report.skip(EVERYTHING, "the FMU is not for co-simulation")
    elif any(prevents_running(finding, fmu) for finding in report.findings):
        report.skip(EVERYTHING, "the description or the binary is too broken to run the FMU by it")
    else:
        dynamic.run(fmu, report, work, limits, cycles)


def prevents_running(finding: Finding, fmu: Fmu) -> bool:
    """Whether the FMU cannot be run because of this finding. Annotations are nothing to those who run it."""
    is_broken = finding.rule in ("binary.format", "binary.exports") and finding.variable == here(fmu)
    return is_broken or (finding.rule == "xml.schema" and "'Annotation" not in finding.found)
