"""What a check hands back: findings, what was not tested, and two ways to show them (a table, a JSON-able dict)."""
from collections import Counter
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from rich.table import Table
from rich.text import Text

from ..text import html_table, html_text, printable
from .rule import ERROR, RULES, SEVERITIES
from .subject import Fault

MOST_ROWS = 100
COLOURS = {"error": "bold red", "warning": "yellow", "note": "dim"}


@dataclass(frozen=True)
class Finding:
    """One breach: `found` is what is there, `expected` what should be; `variable` may also be a unit, type or file."""
    rule: str
    section: str
    severity: str
    variable: str
    found: str
    expected: str


@dataclass(frozen=True)
class NotTested:
    """Something that was left untested, and why (for instance a capability that the FMU does not claim)."""
    what: str
    why: str


@dataclass
class Report:
    """All that is known about one FMU after the check."""
    fmu: Path
    findings: list[Finding] = field(default_factory=list)
    not_tested: list[NotTested] = field(default_factory=list)
    sandbox: str = ""  # what was around the FMU when it ran: bwrap, unshare, none; empty if it did not run

    def add(self, rule: str, fault: Fault, severity: str | None = None) -> None:
        """Note a breach of `rule`; a probe may state a milder `severity` than the rule's own."""
        known = RULES[rule]
        self.findings.append(Finding(rule, known.section, severity or known.severity, *map(printable, fault)))

    def merge(self, rule: str) -> None:
        """Make one finding of all findings of `rule`: the first, and how many more there are."""
        same = [f for f in self.findings if f.rule == rule]
        if len(same) > 1:
            merged = replace(same[0], found=f"{same[0].found}; and {len(same) - 1} more such calls")
            self.findings = [f for f in self.findings if f.rule != rule] + [merged]

    def skip(self, what: str, why: str) -> None:
        """Note that `what` was not tested."""
        self.not_tested.append(NotTested(what, why))

    def count(self, severity: str) -> int:
        """How many findings have this severity."""
        return sum(f.severity == severity for f in self.findings)

    @property
    def passed(self) -> bool:
        """True when there is no error (warnings and notes do not fail an FMU)."""
        return self.count(ERROR) == 0

    def sorted_findings(self) -> list[Finding]:
        """Errors first, then warnings, then notes; within a severity in the order they were found."""
        return sorted(self.findings, key=lambda f: SEVERITIES.index(f.severity))

    def _repr_html_(self) -> str:
        """The findings and what was not tested, as a notebook shows them; texts from the FMU are escaped."""
        headings = ("severity", "rule", "section", "variable", "found", "expected")
        findings = html_table(headings, ([getattr(f, name) for name in headings] for f in self.sorted_findings()))
        untested = html_table(("not tested", "why"), ((n.what, n.why) for n in self.not_tested))
        verdict = html_text(f"{self.fmu.name}: {'passed' if self.passed else 'failed'}, {counted(self)}")
        return f"<p><b>{verdict}</b></p>{findings if self.findings else ''}{untested if self.not_tested else ''}"


def to_dict(report: Report) -> dict[str, Any]:
    """The report as plain data for JSON."""
    counts = Counter(f.severity for f in report.findings)
    return {
        "fmu": str(report.fmu),
        "passed": report.passed,
        "counts": {severity: counts[severity] for severity in SEVERITIES},
        "findings": [asdict(f) for f in report.sorted_findings()],
        "not_tested": [asdict(n) for n in report.not_tested],
        "sandbox": report.sandbox,
    }


def counted(report: Report) -> str:
    """How many findings there are of each severity, in words."""
    return ", ".join(f"{report.count(s)} {s}{'' if report.count(s) == 1 else 's'}" for s in SEVERITIES)


def findings_table(report: Report) -> Table:
    """The findings as a table for a terminal (`rich.print` it): of one rule and severity the first MOST_ROWS."""
    table = Table(title=Text(f"{report.fmu.name}: {counted(report)}"), title_justify="left", show_lines=False)
    for heading in ("severity", "rule", "section", "variable", "found", "expected"):
        table.add_column(heading, overflow="fold")
    seen: Counter[tuple[str, str]] = Counter()
    for f in report.sorted_findings():
        seen[f.severity, f.rule] += 1
        if seen[f.severity, f.rule] <= MOST_ROWS:
            severity = f"[{COLOURS[f.severity]}]{f.severity}[/]"
            table.add_row(severity, f.rule, f.section, *map(Text, (f.variable, f.found, f.expected)))
    for (severity, rule), number in seen.items():
        if number > MOST_ROWS:
            table.add_row(severity, rule, "", f"{number - MOST_ROWS} more", "`ahv check --json` lists them", "")
    return table


def not_tested_table(report: Report) -> Table:
    """What was not tested, and why, as a table for a terminal."""
    ran = f" (it ran in the sandbox: {report.sandbox})" if report.sandbox else ""
    table = Table(title=Text(f"{report.fmu.name}: not tested{ran}"), title_justify="left")
    table.add_column("what")
    table.add_column("why", overflow="fold")
    for item in report.not_tested:
        table.add_row(Text(item.what), Text(item.why))
    return table
