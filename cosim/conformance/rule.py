"""The registry: every rule is one line of data, and at most one small function that looks for what breaks it.

A rule has an identifier, the section of the FMI 2.0.x specification that it enforces, a severity and one sentence.
`@static(...)` registers a rule with the function that checks it; `declare(...)` registers a rule that is found by
something else (opening the archive, the XML schema, a dynamic probe).
"""
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from .subject import Fault, Fmu

ERROR = "error"  # clearly against the specification
WARNING = "warning"  # bad practice, or against a "should"
NOTE = "note"  # a hint
SEVERITIES = (ERROR, WARNING, NOTE)


@dataclass(frozen=True)
class Rule:
    """One rule of the FMI 2.0.x specification: `section` is the section that it enforces."""
    name: str
    section: str
    severity: str
    summary: str


Check = Callable[[Fmu], Iterator[Fault]]

RULES: dict[str, Rule] = {}
STATIC_CHECKS: dict[str, Check] = {}


def declare(name: str, section: str, severity: str, summary: str) -> Rule:
    """Register a rule that no static function checks."""
    if name in RULES:
        raise ValueError(f"rule '{name}' is declared twice")
    RULES[name] = Rule(name, section, severity, summary)
    return RULES[name]


def static(name: str, section: str, severity: str, summary: str) -> Callable[[Check], Check]:
    """Register a rule together with the function that yields one `Fault` for each breach."""

    def register(check: Check) -> Check:
        declare(name, section, severity, summary)
        STATIC_CHECKS[name] = check
        return check

    return register
