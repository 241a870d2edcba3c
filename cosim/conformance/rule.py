"""The rules: one table, `rules.yaml`, for all versions of FMI; and small functions that find what breaks them.

`@static(name)` registers the function that checks a rule by reading the FMU. All others are found by something else:
opening the archive, the XML schema, a dynamic probe.
"""
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, fields
from pathlib import Path

import yaml

from .subject import Fault, Fmu

ERROR = "error"  # clearly against the specification
WARNING = "warning"  # bad practice, or against a "should"
NOTE = "note"  # a hint
SEVERITIES = (ERROR, WARNING, NOTE)

DOES_NOT_LOAD = "does not load"  # nor run
WRONG_RESULTS = "wrong results"
REFUSED = "other tools refuse it"
FORMAL = "formal"
IMPACTS = (DOES_NOT_LOAD, WRONG_RESULTS, REFUSED, FORMAL)

TABLE = Path(__file__).with_name("rules.yaml")


@dataclass(frozen=True)
class Rule:
    """A line of the table. `sections` has, for each version of FMI that knows the rule, the section that asks for it.

    `impact` is what can happen when the rule is broken. `why`, `c` and `pythonfmu` explain: why the standard asks for
    it, how to mend it in C (or in a modelDescription.xml of one's own), and how in pythonfmu. `group` gathers notes;
    `tools` has, for a pattern of generationTool, what is known of that tool.
    """
    name: str
    says: str
    sections: dict[str, str]
    severity: str
    impact: str
    why: str
    c: str
    pythonfmu: str
    group: str = ""
    tools: dict[str, str] = field(default_factory=dict)


def read_table() -> dict[str, Rule]:
    """The rules by name. Raises ValueError for a line of the table that is not a rule."""
    known = {known.name for known in fields(Rule)}
    rules = {}
    for name, line in yaml.load(TABLE.read_text("utf-8"), Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader)).items():
        if line.keys() - known or line["severity"] not in SEVERITIES or line["impact"] not in IMPACTS:
            raise ValueError(f"{TABLE.name}: '{name}' is no rule")
        rules[name] = Rule(name, **line)
    return rules


Check = Callable[[Fmu], Iterator[Fault]]

RULES = read_table()
STATIC_CHECKS: dict[str, Check] = {}


def static(name: str) -> Callable[[Check], Check]:
    """Register the function that yields one `Fault` for each breach of the rule `name`."""
    if name not in RULES or name in STATIC_CHECKS:
        raise ValueError(f"rule '{name}' is not in {TABLE.name}, or has a function already")

    def register(check: Check) -> Check:
        STATIC_CHECKS[name] = check
        return check

    return register
