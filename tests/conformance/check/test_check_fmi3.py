"""FMI 3.0: a correct FMU gets no finding, and each single-defect FMU exactly the rule that it breaks."""

import re
from pathlib import Path

import pytest
from check_fixture import write
from check_fixture3 import BASE_XML, CLOCK_XML, members
from defects3 import DYNAMIC, STATIC, Defect

from cosim.conformance import check
from cosim.conformance.report import Report
from cosim.conformance.rule import RULES, STATIC_CHECKS
from cosim.conformance.versions import FMI3

# What the defect cannot do without.
BESIDE = {"xml.schema": {"header.guid", "variable.causality", "variable.start-forbidden"},
          "header.interface": {"build.identifier"}, "header.model-identifier": {"build.identifier"},
          "variable.unique": {"terminals.variable"}, "variable.derivative-index": {"dependency.known"},
          "array.dimension": {"array.starts"}, "structure.state": {"dependency.known", "unit.derivative"},
          "binary.exports": {"binary.exports-all"}, "variable.independent-type": {"variable.causality"}}
MILDER = {"dynamic.crash: a call in the wrong mode aborts", "dynamic.crash: a negative step aborts",
          "dynamic.legal-call: fmi3DoStep discards a step", "dynamic.serialize-replay: serialization rounds a state"}


def _findings(report: Report) -> list[str]:
    return [f"{f.severity} {f.rule} {f.variable}: {f.found}" for f in report.findings if f.group != "naive importer"]


def _check(defect: Defect, folder: Path) -> None:
    file = write(folder / "Fixture.fmu", defect.build())
    report = check(file, dynamic=bool(defect.macro), time_limit=3.0, cycles=200)
    beside = BESIDE.get(defect.rule, set())
    found = [f for f in report.sorted_findings()
             if f.rule == defect.rule or not (f.rule.startswith("naive.") or f.rule in beside)]
    assert {f.rule for f in found} == {defect.rule}, _findings(report)
    for finding in found:
        assert finding.variable and finding.found and finding.expected
        assert not re.search(r"fmi2|GUID|Real\b", " ".join((finding.found, finding.expected, finding.says))), finding
    if report.fmi_version == "3.0":
        assert found[0].section == RULES[defect.rule].sections["3.0"]
    assert found[0].severity == ("warning" if str(defect) in MILDER else RULES[defect.rule].severity)


@pytest.mark.parametrize("defect", STATIC, ids=str)
def test_static_defect_breaks_one_rule(defect: Defect, tmp_path: Path) -> None:
    _check(defect, tmp_path)


@pytest.mark.parametrize("defect", DYNAMIC, ids=str)
def test_dynamic_defect_breaks_one_rule(defect: Defect, tmp_path: Path) -> None:
    _check(defect, tmp_path)


def test_correct_fmu_has_no_finding_and_everything_is_tested(tmp_path: Path) -> None:
    report = check(write(tmp_path / "Fixture.fmu", members()))
    assert (_findings(report), report.not_tested, report.fmi_version) == ([], [], "3.0")


def test_clocks_are_read_and_not_ticked(tmp_path: Path) -> None:
    report = check(write(tmp_path / "Fixture.fmu", members(CLOCK_XML)))
    assert _findings(report) == []
    assert [item.why for item in report.not_tested] == ["the FMU has clocks, which this check does not tick"]
    assert report.verdict.startswith("It loads and initializes; its clocks were not ticked, so it was not flown; ")


def test_what_is_not_claimed_is_not_tested(tmp_path: Path) -> None:
    plain = re.sub(r"<CoSimulation [^>]*>", '<CoSimulation modelIdentifier="Fixture"/>', BASE_XML)
    report = check(write(tmp_path / "Fixture.fmu", members(plain)), cycles=100)
    assert _findings(report) == []
    skipped = " ".join(item.why for item in report.not_tested)
    for flag in ("canGetAndSetFMUState", "canSerializeFMUState", "providesDirectionalDerivatives", "hasEventMode"):
        assert f"not claimed ({flag})" in skipped


def test_a_patch_version_is_checked(tmp_path: Path) -> None:
    xml = BASE_XML.replace('fmiVersion="3.0"', 'fmiVersion="3.0.1"')
    report = check(write(tmp_path / "Fixture.fmu", {"modelDescription.xml": xml.encode(), "sources/a.c": b""}))
    assert {f.rule for f in report.findings} <= {"build.present", "naive.needs-inputs"} and report.fmi_version == "3.0"


def test_every_rule_of_fmi_3_has_a_defect_here_or_is_of_the_archive() -> None:
    defective = {defect.rule for defect in (*STATIC, *DYNAMIC)}
    own = {name for name, rule in RULES.items() if "3.0" in rule.sections}
    assert defective <= own
    left = {name for name in own - defective if not name.startswith(("archive.", "naive."))}
    assert left == {"binary.present", "binary.exports-all", "dynamic.limits"}
    assert len({str(defect) for defect in (*STATIC, *DYNAMIC)}) == len(STATIC) + len(DYNAMIC) >= 60


def test_every_static_rule_of_fmi_3_has_a_function() -> None:
    found_otherwise = {"archive.", "xml.", "dynamic.", "naive.zero-inputs"}
    for name, rule in RULES.items():
        if "3.0" in rule.sections and not name.startswith(tuple(found_otherwise)):
            assert name in STATIC_CHECKS
    assert len(FMI3.always.split()) > 30
