"""Writes the tables of docs/conformance.md: all rules, and which of fmpy, fmutool and this checker finds which defect.

python tests/conformance/check/table.py
"""

import json
import subprocess
import sys
import tempfile
from collections import defaultdict
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[2]
DOCUMENT = ROOT / "docs" / "conformance.md"
sys.path.insert(0, str(ROOT))

from check_cases import CASES, Case  # noqa: E402
from check_fixture import members, write  # noqa: E402

from cosim.conformance import check  # noqa: E402
from cosim.conformance.rule import RULES  # noqa: E402

_PATIENCE = 15.0  # seconds for fmpy to simulate an FMU
_TOOLS = ("fmpy", "fmutool", "ours")


class Found(NamedTuple):
    fmpy: bool
    fmutool: bool
    ours: bool


def compare(cases: Sequence[Case]) -> dict[Case, Found]:
    """Let all tools judge all defects. fmpy validates, and simulates where the defect is in the binary."""
    with tempfile.TemporaryDirectory(prefix="ahv-table-") as folder:
        files = {}
        for number, case in enumerate(cases):
            (Path(folder) / str(number)).mkdir()
            files[case] = case.build(Path(folder) / str(number) / "Fixture.fmu")
        sound = Path(folder) / "Fixture.fmu"
        write(sound, members())
        validated = _validate([*files.values(), sound])
        if any(validated[str(sound)]) or _simulation_fails(sound):
            raise RuntimeError("a tool complains of the correct FMU, so its complaints of the others mean nothing")
        return {case: _judge(case, file, validated[str(file)]) for case, file in files.items()}


def _validate(files: Sequence[Path]) -> dict[str, list[bool]]:
    command = [sys.executable, str(HERE / "other_tools.py"), "validate", *map(str, files)]
    output = subprocess.run(command, check=True, capture_output=True, text=True, timeout=600).stdout
    return dict(json.loads(output.splitlines()[-1]))


def _simulation_fails(file: Path) -> bool:
    command = [sys.executable, str(HERE / "other_tools.py"), "simulate", str(file)]
    try:
        return subprocess.run(command, capture_output=True, timeout=_PATIENCE).returncode != 0
    except subprocess.TimeoutExpired:
        return True


def _judge(case: Case, file: Path, validated: list[bool]) -> Found:
    is_dynamic = case.kind == "dynamic"
    report = check(file, dynamic=is_dynamic, time_limit=3.0, cycles=200)
    ours = any(finding.rule == case.rule for finding in report.findings)
    return Found(validated[0] or (is_dynamic and _simulation_fails(file)), validated[1], ours)


def summary(found: dict[Case, Found]) -> list[str]:
    """How many defects each tool finds, by kind."""
    own = [name for name, rule in RULES.items() if "2.0" in rule.sections]
    dynamic = sum(name.startswith("dynamic.") for name in own)
    lines = [f"{len(own)} rules of FMI 2.0, {dynamic} of them dynamic; {len(found)} defects:", ""]
    lines += ["| defects | number | fmpy | fmutool | ours |", "|---|---|---|---|---|"]
    for kind in ("static", "archive", "dynamic", "all"):
        chosen = [f for case, f in found.items() if kind in (case.kind, "all")]
        lines.append(f"| {kind} | {len(chosen)} | " + " | ".join(_sums(chosen)) + " |")
    return lines


def _sums(chosen: Sequence[Found]) -> list[str]:
    return [str(sum(getattr(f, tool) for f in chosen)) for tool in _TOOLS]


def by_rule(found: dict[Case, Found]) -> list[str]:
    """One line for each rule: sections, severity, what it says, how many of its FMI 2.0 defects each tool finds."""
    groups: dict[str, list[Found]] = defaultdict(list)
    for case, f in found.items():
        groups[case.rule].append(f)
    lines = [
        "| rule | FMI 2.0 | FMI 3.0 | severity | impact | says | defects | fmpy | fmutool | ours |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for name, rule in sorted(RULES.items(), key=lambda item: (item[1].sections.get("2.0", "9"), item[0])):
        counts = [str(len(groups[name])), *_sums(groups[name])] if "2.0" in rule.sections else [""] * 4
        sections = " | ".join(rule.sections.get(version, "") for version in ("2.0", "3.0"))
        words = f"{sections} | {rule.severity} | {rule.impact} | {rule.says}"
        lines.append(f"| {name} | {words} | {' | '.join(counts)} |")
    return lines


def replace_part(text: str, name: str, lines: Sequence[str]) -> str:
    """Put lines between the markers of one generated part of the document."""
    begin, end = f"<!-- {name} -->\n", f"<!-- end of {name} -->"
    head, rest = text.split(begin)
    return head + begin + "\n".join(lines) + "\n" + end + rest.split(end)[1]


def main() -> None:
    """Judge everything and write the document."""
    found = compare(CASES)
    text = DOCUMENT.read_text("utf-8")
    text = replace_part(text, "summary", summary(found))
    DOCUMENT.write_text(replace_part(text, "rules", by_rule(found)), "utf-8")
    print("\n".join(summary(found)))


if __name__ == "__main__":
    main()
