"""Reports as text for people and logs, and as JUnit, SARIF and GitHub annotations for CI."""
import json
from collections.abc import Iterable, Sequence
from importlib.metadata import PackageNotFoundError, version
from itertools import groupby
from pathlib import Path
from textwrap import fill
from typing import Any
from xml.etree import ElementTree

from .report import EVERYTHING, FAILS, NAIVE, Finding, Report, to_dict
from .rule import ERROR, NOTE, RULES, SEVERITIES, Rule

SARIF = "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json"
WIDTH = 100
MOST_ROWS = 10  # of one rule, unless all are asked for


def sentence(f: Finding) -> str:
    """A finding in words, without its severity."""
    known = f" ({f.known})" if f.known else ""
    return f"{f.variable}: {f.found}; expected: {f.expected}{known}"


def main_findings(report: Report, fail_on: str, everything: bool) -> list[Finding]:
    """The findings that are shown unasked: what is no formality and no note, and what fails the check."""
    fails = FAILS[fail_on]
    return [f for f in report.sorted_findings()
            if everything or f.weighs or f.severity == ERROR or (fail_on != "error" and fails(f))]


def left_out(report: Report, shown: Sequence[Finding]) -> str:
    """A sentence about what is not shown; empty if there is nothing."""
    hidden = len(report.findings) - len(shown)
    parts = [f"{hidden} more finding{'s' * (hidden != 1)}"] if hidden else []
    parts += ["what was not tested"] if report.not_tested else []
    return f"--all shows {' and '.join(parts)}." if parts else ""


def lines(report: Report, fail_on: str = "error", everything: bool = False) -> list[str]:
    """The report for a log: the verdict, then one line a finding."""
    name, shown = report.fmu.name, main_findings(report, fail_on, everything)
    told = [f"{name}: {report.verdict}"]
    told += [f"{name}: {f.severity}: {f.rule} (FMI {report.fmi_version}, {f.section}; {f.impact}): {sentence(f)}. "
             f"Rule: {f.says}" for f in shown]
    told += [f"{name}: not tested: {n.what}: {n.why}" for n in report.not_tested if everything or n.what == EVERYTHING]
    told += [f"{name}: findings left out by --ignore: {report.ignored}"] if report.ignored else []
    return [*told, f"{name}: {rest}"] if not everything and (rest := left_out(report, shown)) else told


def page(report: Report, width: int, fail_on: str = "error", everything: bool = False) -> list[str]:
    """The report for a terminal: the verdict, then under each impact the rules with their sentences and findings."""
    shown = main_findings(report, fail_on, everything)
    told = [fill(f"{report.fmu.name}: {report.verdict}", width)]
    for heading, findings in groupby(shown, heading_of):
        told += ["", heading]
        for (severity, name), same in groupby(findings, lambda f: (f.severity, f.rule)):
            told.append(indented(f"{severity}: {name} ({RULES[name].sections[report.fmi_version]}): {RULES[name].says}",
                                 2, width))
            rows = [indented(sentence(f), 6, width) for f in same]
            told += rows if everything else rows[:MOST_ROWS]
            if len(rows) > MOST_ROWS and not everything:
                told.append(f"      and {len(rows) - MOST_ROWS} more, which --all shows")
    untested = [item for item in report.not_tested if everything or item.what == EVERYTHING]
    if untested:
        ran = f" (it ran in the sandbox: {report.sandbox})" if report.sandbox else ""
        told += ["", f"not tested{ran}", *(indented(f"{item.what}: {item.why}", 2, width) for item in untested)]
    ends = [f"Findings left out by --ignore: {report.ignored}."] if report.ignored else []
    ends += [rest] if not everything and (rest := left_out(report, shown)) else []
    ends += [f"`ahv check --explain {shown[0].rule}` says why and how to mend it."] if shown else []
    return [*told, *([""] if ends else []), *ends]


def heading_of(f: Finding) -> str:
    """The heading under which a finding is shown."""
    if f.severity != NOTE:
        return f.impact
    return "Would a naive importer manage?" if f.group == NAIVE else "notes"


def indented(text: str, by: int, width: int) -> str:
    """Text in lines of `width`; words are left whole."""
    return fill(text, width, initial_indent=" " * by, subsequent_indent=" " * (by + 4), break_long_words=False,
                break_on_hyphens=False)


def explain(rule: Rule) -> str:
    """What the standard asks, why, and how to mend it."""
    asked = ", ".join(f"FMI {number}, section {section}" for number, section in rule.sections.items())
    parts = [("asked by", asked), ("severity", rule.severity), ("if broken", rule.impact), ("why", rule.why),
             ("mend it in C", rule.c), ("in pythonfmu", rule.pythonfmu)]
    parts += [("known", text) for text in rule.tools.values()]
    told = [f"{rule.name}: {rule.says}", ""]
    for heading, text in parts:
        told.append(fill(text, WIDTH, initial_indent=f"{heading:14}", subsequent_indent=" " * 14))
    return "\n".join(told)


def as_json(reports: Iterable[Report]) -> str:
    """One JSON object of all reports."""
    done = list(reports)
    return json.dumps({"passed": all(r.passed for r in done), "fmus": [to_dict(r) for r in done]})


def as_github(reports: Iterable[Report]) -> str:
    """Workflow commands that GitHub shows at the file."""
    words = {"error": "error", "warning": "warning", "note": "notice"}

    def escaped(text: str) -> str:
        return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")

    def field(text: str) -> str:
        return escaped(text).replace(":", "%3A").replace(",", "%2C")

    return "\n".join(f"::{words[f.severity]} file={field(str(report.fmu))},title={field(f.rule)}::"
                     f"{escaped(f'{sentence(f)}. {f.says}')}" for report in reports for f in report.sorted_findings())


def as_junit(reports: Iterable[Report], fail_on: str = "error") -> str:
    """JUnit's XML: a suite for each FMU, a case for each rule; a rule fails by what `fail_on` says."""
    root = ElementTree.Element("testsuites", name="ahv check")
    for report in reports:
        applied = [rule for rule in RULES.values() if report.fmi_version in rule.sections
                   and (report.ran or not rule.name.startswith("dynamic."))]
        failed = {f.rule for f in report.findings if FAILS[fail_on](f)}
        suite = ElementTree.SubElement(root, "testsuite", name=str(report.fmu), errors="0", time="0",
                                       tests=str(len(applied) + len(report.not_tested)), failures=str(len(failed)),
                                       skipped=str(len(report.not_tested)))
        for rule in applied:
            case = ElementTree.SubElement(suite, "testcase", classname=report.fmu.name, name=rule.name, time="0")
            found = [f for f in report.findings if f.rule == rule.name]
            text = "\n".join(f"{f.severity}: {sentence(f)}" for f in found)
            if rule.name in failed:
                failure = ElementTree.SubElement(case, "failure", message=rule.says, type=found[0].severity)
                failure.text = text
            elif found:
                ElementTree.SubElement(case, "system-out").text = text
        for number, item in enumerate(report.not_tested, 1):
            case = ElementTree.SubElement(suite, "testcase", classname=report.fmu.name, time="0",
                                          name=f"not tested {number}: {item.what}")
            ElementTree.SubElement(case, "skipped", message=item.why)
    ElementTree.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ElementTree.tostring(root, "unicode")


def as_sarif(reports: Iterable[Report]) -> str:
    """SARIF 2.1.0: one run, a result for each finding."""
    done = list(reports)
    used = sorted({f.rule for report in done for f in report.findings})
    driver = {"name": "ahv check", "rules": [sarif_rule(RULES[name]) for name in used]} | own_version()
    results = [{
        "ruleId": f.rule, "ruleIndex": used.index(f.rule), "level": f.severity,
        "message": {"text": f"{sentence(f)}. {f.says}"},
        "locations": [{"physicalLocation": {"artifactLocation": {"uri": uri(report.fmu)}},
                       "logicalLocations": [{"name": f.variable}]}],
        "properties": {"impact": f.impact},
    } for report in done for f in report.sorted_findings()]
    return json.dumps({"$schema": SARIF, "version": "2.1.0",
                       "runs": [{"tool": {"driver": driver}, "results": results}]}, indent=1)


def sarif_rule(rule: Rule) -> dict[str, Any]:
    """A rule as SARIF describes it."""
    assert set(SEVERITIES) == {ERROR, "warning", NOTE}  # SARIF's own levels
    return {"id": rule.name, "shortDescription": {"text": rule.says}, "fullDescription": {"text": rule.why},
            "help": {"text": f"In C: {rule.c} In pythonfmu: {rule.pythonfmu}"},
            "defaultConfiguration": {"level": rule.severity}, "properties": {"impact": rule.impact}}


def uri(path: Path) -> str:
    """A relative reference for a path below here, else a file URI."""
    from urllib.parse import quote

    return path.as_uri() if path.is_absolute() else quote(path.as_posix())


def own_version() -> dict[str, str]:
    """This program's version, where it is installed."""
    try:
        return {"version": version("ahv")}
    except PackageNotFoundError:
        return {}
