"""Each single-defect FMU: exactly the rule that it breaks is reported, with all that a finding must say."""

import tempfile
from pathlib import Path

import pytest
from check_cases import ARCHIVE, CASES, DYNAMIC, STATIC, Case

from cosim.conformance import check
from cosim.conformance.checker import check as _loaded  # noqa: F401  (registers all rules)
from cosim.conformance.report import Report
from cosim.conformance.rule import RULES

# Crashes after a master's mistake, and a discarded step, are no clear breach; what is lost by rounding to a float is
# less than the FMU's tolerance.
MILDER = {
    "dynamic.crash: a call in the wrong mode aborts",
    "dynamic.crash: a negative step aborts",
    "dynamic.legal-call: fmi2DoStep discards a step",
    "dynamic.serialize-replay: serialization rounds a state",
}
BESIDE = {"dynamic.discard-status": "dynamic.legal-call"}  # a finding that the defect cannot do without
REFUSED, FORMAL = "other tools refuse it", "formal"
IMPACTS_OF = {
    "binary.format: a Linux library for Windows": REFUSED,
    "dynamic.crash: fmi2FreeInstance aborts on a null pointer": FORMAL,
    "dynamic.crash: a call in the wrong mode aborts": FORMAL,
    "dynamic.crash: a negative step aborts": FORMAL,
    "dynamic.serialize-replay: serialization rounds a state": FORMAL,
    "dynamic.legal-call: fmi2Terminate fails": REFUSED,
    "dynamic.legal-call: fmi2Reset fails": REFUSED,
    "dynamic.legal-call: fmi2GetFMUstate fails though claimed": REFUSED,
    "dynamic.legal-call: fmi2DeSerializeFMUstate fails though claimed": REFUSED,
    "dynamic.legal-call: fmi2SetDebugLogging fails": REFUSED,
}


def _assert_only(case: Case, report: Report) -> None:
    beside = BESIDE.get(case.rule)
    findings = [f for f in report.sorted_findings()
                if f.rule == case.rule or not (f.rule.startswith("naive.") or f.rule == beside)]
    assert {f.rule for f in findings} == {case.rule}, [f"{f.rule}: {f.found}" for f in findings]
    for finding in findings:
        assert finding.section == RULES[case.rule].sections["2.0"]
        assert finding.variable and finding.found and finding.expected
        assert "\n" not in finding.found
    worst = findings[0]
    assert worst.severity == ("warning" if str(case) in MILDER else RULES[case.rule].severity)
    assert worst.impact == IMPACTS_OF.get(str(case), RULES[case.rule].impact)


@pytest.mark.parametrize("case", STATIC, ids=str)
def test_static_defect_breaks_one_rule(case: Case, tmp_path: Path) -> None:
    _assert_only(case, check(case.build(tmp_path / "Fixture.fmu"), dynamic=False))


@pytest.mark.parametrize("case", DYNAMIC, ids=str)
def test_dynamic_defect_breaks_one_rule(case: Case, tmp_path: Path) -> None:
    report = check(case.build(tmp_path / "Fixture.fmu"), time_limit=3.0, cycles=200)
    _assert_only(case, report)


@pytest.mark.parametrize("case", ARCHIVE, ids=str)
def test_bad_file_is_one_clear_finding_and_leaves_nothing(
    case: Case, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = case.build(tmp_path / "Fixture.fmu")
    temporary = tmp_path / "a" / "b" / "temporary"
    temporary.mkdir(parents=True)
    monkeypatch.setattr(tempfile, "tempdir", str(temporary))
    before = sorted(tmp_path.rglob("*"))
    _assert_only(case, check(file, dynamic=False))
    assert sorted(tmp_path.rglob("*")) == before
    assert not Path("/outside.txt").exists()


def test_every_rule_of_fmi_2_has_a_defect() -> None:
    own = [name for name, rule in RULES.items() if "2.0" in rule.sections]
    assert sorted({case.rule for case in CASES}) == sorted(own)


def test_there_are_at_least_sixty_distinct_defects() -> None:
    assert len({str(case) for case in CASES}) == len(CASES) >= 60
