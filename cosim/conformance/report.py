"""What a check hands back: findings, what was not tested, a verdict, and two ways to show them (a table, a dict)."""
import re
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from rich.table import Table
from rich.text import Text

from ..errors import UsageError, did_you_mean
from ..text import html_table, html_text, printable
from .rule import DOES_NOT_LOAD, ERROR, FORMAL, IMPACTS, NOTE, RULES, SEVERITIES, WRONG_RESULTS
from .subject import Fault
from .versions import spoken

MOST_ROWS = 100
COLOURS = {"error": "bold red", "warning": "yellow", "note": "dim"}
HEADINGS = ("impact", "severity", "rule", "section", "variable", "found", "expected")
NAIVE = "naive importer"  # the group of what importers need that read the standard in a hurry
EVERYTHING = "everything dynamic"  # what is not tested when the FMU does not run


@dataclass(frozen=True)
class Finding:
    """One breach: `found` is what is there, `expected` what should be; `variable` may also be a unit, type or file.

    `says` is the rule's sentence, `impact` what can happen, `known` what is known of the tool that made the FMU.
    """
    rule: str
    section: str
    severity: str
    variable: str
    found: str
    expected: str
    impact: str = FORMAL
    says: str = ""
    group: str = ""
    known: str = ""

    @property
    def weighs(self) -> bool:
        """Whether it is more than a formality or a note."""
        return self.severity != NOTE and self.impact != FORMAL


# --fail-on: the word -> whether a finding fails the check.
FAILS: dict[str, Callable[[Finding], bool]] = {
    "error": lambda f: f.severity == ERROR,
    "wrong-results": lambda f: f.severity != NOTE and f.impact in (DOES_NOT_LOAD, WRONG_RESULTS),
    "warning": lambda f: f.severity != NOTE,
    "any": lambda f: True,
}


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
    fmi_version: str = "2.0"
    tool: str = ""  # generationTool of the FMU
    ignored: int = 0  # findings that were left out on request
    initialized_only: bool = False  # the FMU has clocks, which nobody ticked

    def add(self, rule: str, fault: Fault, severity: str | None = None, impact: str | None = None) -> None:
        """Note a breach of `rule`; a probe may state a milder `severity` and `impact` than the rule's own."""
        line = RULES[rule]
        variable, found, expected = map(printable, fault[:3])
        if rule.startswith("dynamic."):
            variable = spoken(variable, self.fmi_version)
        found, expected = spoken(found, self.fmi_version), spoken(expected, self.fmi_version)
        known = next((text for pattern, text in line.tools.items() if re.search(pattern, self.tool)), "")
        self.findings.append(Finding(rule, line.sections[self.fmi_version], severity or line.severity, variable, found,
                                     expected, impact or fault.impact or line.impact,
                                     spoken(line.says, self.fmi_version), line.group, known))

    def merge(self, rule: str) -> None:
        """Make one finding of all findings of `rule`: the first, and how many more there are."""
        same = [f for f in self.findings if f.rule == rule]
        if len(same) > 1:
            merged = replace(same[0], found=f"{same[0].found}; and {len(same) - 1} more such calls")
            self.findings = [f for f in self.findings if f.rule != rule] + [merged]

    def skip(self, what: str, why: str) -> None:
        """Note that `what` was not tested."""
        self.not_tested.append(NotTested(spoken(what, self.fmi_version), spoken(printable(why), self.fmi_version)))

    def ignore(self, rules: Iterable[str]) -> None:
        """Leave out the findings of some rules. Raises UsageError for a rule that there is not."""
        wanted = set(rules)
        for rule in wanted - RULES.keys():
            raise UsageError(f"There is no rule {rule}{did_you_mean(rule, RULES)}")
        kept = [f for f in self.findings if f.rule not in wanted]
        self.ignored += len(self.findings) - len(kept)
        self.findings = kept

    def count(self, severity: str) -> int:
        """How many findings have this severity."""
        return sum(f.severity == severity for f in self.findings)

    @property
    def ran(self) -> bool:
        """Whether the FMU was run."""
        return bool(self.sandbox) and all(item.what != EVERYTHING for item in self.not_tested)

    @property
    def passed(self) -> bool:
        """True when there is no error (warnings and notes do not fail an FMU)."""
        return self.count(ERROR) == 0

    def fails(self, fail_on: str = "error") -> bool:
        """Whether there is a finding that fails the check: error, wrong-results, warning, or any."""
        return any(map(FAILS[fail_on], self.findings))

    @property
    def verdict(self) -> str:
        """What the findings mean, in one sentence."""
        loads, wrong, refused, formal = (amount([f for f in self.findings if f.severity != NOTE and f.impact == impact])
                                         for impact in IMPACTS)
        parts = [f"{wrong} can give wrong results"] if wrong else []
        parts += [f"other tools may refuse it for {refused}"] if refused else []
        parts += [f"{formal} {'is' if formal.startswith('1 ') else 'are'} formal"] if formal else []
        if notes := self.count(NOTE):
            naive = sum(f.group == NAIVE and f.severity == NOTE for f in self.findings)
            parts.append(f"there {'is 1 note' if notes == 1 else f'are {notes} notes'}"
                         + (f" ({naive} on what a naive importer may not bear)" if naive else ""))
        state = "It loads and flies" if self.ran else "It was read, not run"
        if self.ran and self.initialized_only:
            state = "It loads and initializes; its clocks were not ticked, so it was not flown"
        if loads:
            state = f"It does not load or run ({loads} say{'s' if loads.startswith('1 ') else ''} why)"
        return f"{state}; {', '.join(parts) or ('nothing else was found' if loads else 'no findings')}."

    def sorted_findings(self) -> list[Finding]:
        """By impact, then errors before warnings before notes; else in the order they were found."""
        return sorted(self.findings, key=lambda f: (f.severity == NOTE, f.severity == NOTE and f.group == NAIVE,
                                                    IMPACTS.index(f.impact), SEVERITIES.index(f.severity)))

    def _repr_html_(self) -> str:
        """The findings and what was not tested, as a notebook shows them; texts from the FMU are escaped."""
        findings = html_table(HEADINGS, ([getattr(f, name) for name in HEADINGS] for f in self.sorted_findings()))
        untested = html_table(("not tested", "why"), ((n.what, n.why) for n in self.not_tested))
        verdict = html_text(f"{self.fmu.name}: {'passed' if self.passed else 'failed'}, {counted(self)}")
        sentence = f"<p>{html_text(self.verdict)}</p>"
        tables = f"{findings if self.findings else ''}{untested if self.not_tested else ''}"
        return f"<p><b>{verdict}</b></p>{sentence}{tables}"


def amount(findings: list[Finding]) -> str:
    """How many findings there are, in words: a rule counts once, wherever it is broken; empty for none."""
    rules = len({f.rule for f in findings})
    places = f" (in {len(findings)} places)" if len(findings) > rules else ""
    return f"{rules} finding{'s' * (rules != 1)}{places}" if rules else ""


def to_dict(report: Report) -> dict[str, Any]:
    """The report as plain data for JSON."""
    counts = Counter(f.severity for f in report.findings)
    impacts = Counter(f.impact for f in report.findings)
    return {
        "fmu": str(report.fmu),
        "passed": report.passed,
        "verdict": report.verdict,
        "fmi_version": report.fmi_version,
        "tool": report.tool,
        "counts": {severity: counts[severity] for severity in SEVERITIES},
        "impacts": {impact: impacts[impact] for impact in IMPACTS},
        "findings": [asdict(f) for f in report.sorted_findings()],
        "not_tested": [asdict(n) for n in report.not_tested],
        "ignored": report.ignored,
        "sandbox": report.sandbox,
    }


def counted(report: Report) -> str:
    """How many findings there are of each severity, in words."""
    return ", ".join(f"{report.count(s)} {s}{'' if report.count(s) == 1 else 's'}" for s in SEVERITIES)


def findings_table(report: Report) -> Table:
    """The findings as a table for a terminal (`rich.print` it): of one rule and severity the first MOST_ROWS."""
    table = Table(title=Text(f"{report.fmu.name}: {counted(report)}"), title_justify="left", show_lines=False)
    for heading in HEADINGS:
        table.add_column(heading, overflow="fold", no_wrap=heading in ("severity", "section"))
    seen: Counter[tuple[str, str]] = Counter()
    for f in report.sorted_findings():
        seen[f.severity, f.rule] += 1
        if seen[f.severity, f.rule] <= MOST_ROWS:
            severity = f"[{COLOURS[f.severity]}]{f.severity}[/]"
            table.add_row(f.impact, severity, f.rule, f.section, *map(Text, (f.variable, f.found, f.expected)))
    for (severity, rule), number in seen.items():
        if number > MOST_ROWS:
            table.add_row("", severity, rule, "", f"{number - MOST_ROWS} more", "`ahv check --json` lists them", "")
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
