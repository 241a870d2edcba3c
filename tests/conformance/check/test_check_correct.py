"""FMUs that follow the specification get no error; what is not claimed or cannot be tested is said, not judged."""

import re
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from check_fixture import BASE_XML, library, members, swapped, write
from places import ROOT

from cosim.conformance import check
from cosim.conformance.confined import Limits
from cosim.conformance.report import Report

PATIENT = Limits(budget_s=600.0)  # whatever else the machine does
OURS = sorted(path for flavour in ("native", "native-fmi3", "python")
              for path in ROOT.glob(f"fmus/dist/{flavour}/*.fmu"))
LONG = ("AhvInstrumentedPlant", "AhvResilient", "AhvBackstepping")  # in the Python flavour

# The least that the schema and the specification ask for: no units, no types, no claims, flat names.
MINIMAL = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Fixture" guid="{8c4e810f-3df3-4a00-8276-176fa3c9f001}">
  <CoSimulation modelIdentifier="Fixture"/>
  <ModelVariables>
    <ScalarVariable name="any name" valueReference="3" causality="input"><Real start="0"/></ScalarVariable>
    <ScalarVariable name="y" valueReference="8" causality="output"><Real/></ScalarVariable>
  </ModelVariables>
  <ModelStructure>
    <Outputs><Unknown index="2" dependencies="1"/></Outputs>
    <InitialUnknowns><Unknown index="2"/></InitialUnknowns>
  </ModelStructure>
</fmiModelDescription>
"""


def _told(report: Report) -> list[str]:
    """All findings but the notes about naive importers, which the fixture's types and dependencies get rightly."""
    return [f"{f.severity} {f.rule} {f.variable}: {f.found}" for f in report.findings
            if not f.rule.startswith("naive.")]


def _skipped(report: Report) -> str:
    return "\n".join(f"{item.what}: {item.why}" for item in report.not_tested)


def test_correct_fmu_has_no_finding_at_all(tmp_path: Path) -> None:
    report = check(write(tmp_path / "Fixture.fmu", members()))
    assert _told(report) == []
    assert [item.what for item in report.not_tested] == ["asynchronous steps"]


def test_minimal_fmu_has_no_finding_and_nothing_unclaimed_is_tested(tmp_path: Path) -> None:
    report = check(write(tmp_path / "Fixture.fmu", members(MINIMAL)), cycles=100)
    assert _told(report) == []
    for flag in ("canGetAndSetFMUstate", "canSerializeFMUstate", "providesDirectionalDerivative"):
        assert f"not claimed ({flag})" in _skipped(report)


def test_fmu_for_one_instance_in_a_process_is_tested_with_one_at_a_time(tmp_path: Path) -> None:
    xml = swapped('modelIdentifier="Fixture"', 'modelIdentifier="Fixture" canBeInstantiatedOnlyOncePerProcess="true"')
    report = check(write(tmp_path / "Fixture.fmu", members(xml, defect="ONE_INSTANCE")), cycles=100)
    assert _told(report) == []
    assert "twice: the FMU says that a process may instantiate it once only" in _skipped(report)


def test_fmu_for_both_interfaces_has_no_error(tmp_path: Path) -> None:
    xml = swapped("  <CoSimulation", '  <ModelExchange modelIdentifier="Fixture"/>\n  <CoSimulation')
    assert _told(check(write(tmp_path / "Fixture.fmu", members(xml)), dynamic=False)) == []


def test_model_exchange_alone_is_not_run(tmp_path: Path) -> None:
    begin, end = BASE_XML.index("<CoSimulation"), BASE_XML.index("  <UnitDefinitions")
    xml = BASE_XML[:begin] + '<ModelExchange modelIdentifier="Fixture"/>\n' + BASE_XML[end:]
    report = check(write(tmp_path / "Fixture.fmu", members(xml)))
    assert report.passed
    assert "the FMU is not for co-simulation" in _skipped(report)


def test_fmu_without_a_binary_for_this_platform_is_not_run(tmp_path: Path) -> None:
    content = {"modelDescription.xml": BASE_XML.encode(), "binaries/haiku64/Fixture.so": library()}
    report = check(write(tmp_path / "Fixture.fmu", content))
    assert report.passed
    assert "no binary for this platform" in _skipped(report)


def test_slow_fmu_gets_no_finding_and_the_report_says_what_was_left(tmp_path: Path) -> None:
    report = check(write(tmp_path / "Fixture.fmu", members(defect="SLOW")), time_limit=0.5, cycles=1000)
    assert _told(report) == []
    assert "slow" in _skipped(report)


@pytest.mark.parametrize("macro", ["UNRESOLVED", "NO_INSTANCE"])
def test_missing_tool_of_an_fmu_that_needs_one_is_no_error(tmp_path: Path, macro: str) -> None:
    xml = swapped('modelIdentifier="Fixture"', 'modelIdentifier="Fixture" needsExecutionTool="true"')
    report = check(write(tmp_path / "Fixture.fmu", members(xml, defect=macro)), cycles=100)
    assert [finding.severity for finding in report.findings if finding.severity != "note"] == ["warning"]


def test_stored_instead_of_deflated_is_no_error(tmp_path: Path) -> None:
    assert _told(check(write(tmp_path / "Fixture.fmu", members(), zipfile.ZIP_STORED), dynamic=False)) == []


def test_path_with_spaces_and_letters_beyond_ascii(tmp_path: Path) -> None:
    folder = tmp_path / "größe 100 % #1"
    folder.mkdir()
    assert _told(check(write(folder / "Fixture.fmu", members()), cycles=100)) == []


@pytest.mark.parametrize("fmu", [
    pytest.param(path, id=f"{path.parent.name}/{path.name}",
                 marks=[pytest.mark.slow] if path.parent.name == "python" and path.stem in LONG else [])
    for path in OURS])
def test_our_own_fmus_have_no_error(fmu: Path) -> None:
    report = check(fmu, cycles=100, limits=PATIENT)
    assert report.passed, _told(report)
    assert fmu.parent.name == "python" or _told(report) == []  # for the python flavour see the next test


def test_what_is_wrong_with_the_python_flavour_is_named(python_fmus: dict[str, Path]) -> None:
    """All are properties of pythonfmu's binary: see contract.py."""
    report = check(python_fmus["AhvPlant"], cycles=100, limits=PATIENT)
    found = {f.rule: (f.severity, f.found) for f in report.findings if not f.rule.startswith("naive.")}
    assert found.keys() - {"dynamic.memory"} == {
        "dynamic.fatal", "dynamic.stop-time", "dynamic.log-refusal", "dynamic.guid", "dynamic.state-free"}
    severity, text = found["dynamic.fatal"]
    assert severity == "warning"
    assert re.fullmatch(r"fmi2Fatal in the state 'instantiated'.*; and 21 more such calls", text)
    assert found["dynamic.stop-time"] == ("warning", "fmi2Fatal for a step beyond the stop time 0.05")


def test_pythonfmu_example_has_its_known_errors_and_no_others(tmp_path: Path) -> None:
    """FMI-NOTES: stock pythonfmu writes no InitialUnknowns and leaves the default variability to non-Reals."""
    builder = pytest.importorskip("pythonfmu.builder")
    slave = Path(builder.__file__).parent / "tests" / "slaves" / "pythonslave.py"
    if not slave.is_file():
        pytest.skip("this pythonfmu comes without its test slaves")
    report = check(Path(builder.FmuBuilder.build_FMU(slave, dest=tmp_path)), cycles=100, limits=PATIENT)
    errors = {finding.rule for finding in report.findings if finding.severity == "error"}
    assert errors == {"structure.initial-complete", "variable.continuous-real"}


def test_fmu_of_another_make_has_no_error(tmp_path: Path) -> None:
    """fmucontainer's runtime around two FMUs: it hangs on a step of NaN, which is a warning, and has no error."""
    for name in ("one.fmu", "two.fmu"):
        write(tmp_path / name, members(MINIMAL.replace("any name", "u")))
    (tmp_path / "both.csv").write_text(
        "rule;from_fmu;from_port;to_fmu;to_port\nFMU;one.fmu;;;\nFMU;two.fmu;;;\nLINK;one.fmu;y;two.fmu;u\n"
        "INPUT;;u;one.fmu;u\nOUTPUT;two.fmu;y;;y\n"
    )
    command = [
        sys.executable,
        "-c",
        "from fmu_manipulation_toolbox.cli.fmucontainer import fmucontainer; fmucontainer()",
    ]
    options = ["-container", "both.csv:0.01", "-fmu-directory", str(tmp_path)]
    subprocess.run([*command, *options], check=True, capture_output=True, cwd=tmp_path)
    report = check(tmp_path / "both.fmu", cycles=100, limits=Limits(call_s=2.0, budget_s=600.0))
    assert report.passed, _told(report)
