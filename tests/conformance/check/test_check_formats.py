"""What `ahv check` prints: verdict, lines, JUnit, SARIF, GitHub; what makes it fail; how a rule is explained."""
import io
import json
import re
import subprocess
from pathlib import Path

import jsonschema
import pytest
from check_fixture import library, members, swapped, write
from check_fixture3 import members as members3
from lxml import etree
from places import AHV

from cosim.cli.check import show
from cosim.conformance import check, formats
from cosim.conformance.report import FAILS, Report
from cosim.conformance.rule import IMPACTS, RULES
from cosim.conformance.subject import Fault
from cosim.errors import UsageError

SCHEMAS = Path(__file__).parent / "schemas"
NASTY = 'a<b>&"%\n::error::[red]é, x'


def ahv_check(*words: object) -> subprocess.CompletedProcess[str]:
    return subprocess.run([AHV, "check", *map(str, words)], capture_output=True, text=True)


@pytest.fixture
def report() -> Report:
    """Findings of each impact and severity, with texts that every format must escape."""
    made = Report(Path("folder with space/Plant.fmu"), sandbox="none")
    made.add("xml.encoding", Fault("modelDescription.xml", NASTY, "UTF-8"))
    made.add("dynamic.start-value", Fault(NASTY, "0.6", "0.5"))
    made.add("structure.unique", Fault("y", "2 entries", "one"))
    made.add("header.date", Fault("date", NASTY, "a date"))
    made.add("naive.needs-inputs", Fault("outputs", "2", "none"))
    made.skip("asynchronous steps", NASTY)
    return made


def test_findings_are_sorted_by_impact_and_notes_come_last(report: Report) -> None:
    assert [f.rule for f in report.sorted_findings()] == [
        "dynamic.start-value", "structure.unique", "xml.encoding", "header.date", "naive.needs-inputs"]
    assert report.verdict == ("It loads and flies; 1 finding can give wrong results, other tools may refuse it for "
                              "1 finding, 2 findings are formal, there is 1 note (1 on what a "
                              "naive importer may not bear).")


def test_verdict_of_what_does_not_load(report: Report) -> None:
    report.add("dynamic.load", Fault("binaries", "no", "yes"))
    assert report.verdict.startswith("It does not load or run (1 finding says why); 1 finding can give wrong results")
    assert Report(Path("a.fmu")).verdict == "It was read, not run; no findings."
    assert Report(Path("a.fmu"), sandbox="none").verdict == "It loads and flies; no findings."


@pytest.mark.parametrize("fail_on, failing", [("error", 3), ("wrong-results", 1), ("warning", 4), ("any", 5)])
def test_what_fails_the_check(report: Report, fail_on: str, failing: int) -> None:
    assert sum(map(FAILS[fail_on], report.findings)) == failing
    assert report.fails(fail_on)
    report.ignore([f.rule for f in report.findings])
    assert not report.fails("any") and report.ignored == 5


def test_an_unknown_rule_is_not_ignored(report: Report) -> None:
    with pytest.raises(UsageError, match=r"^There is no rule xml\.encodin; did you mean xml\.encoding\?$"):
        report.ignore(["xml.encodin"])


def test_one_finding_is_one_line(report: Report) -> None:
    told = formats.lines(report, everything=True)
    assert len(told) == 1 + len(report.findings) + len(report.not_tested)
    assert all("\n" not in line and line.startswith("Plant.fmu: ") for line in told)
    assert RULES["dynamic.start-value"].says in told[1]
    brief = formats.lines(report)
    assert [line.split()[2] for line in brief[1:4]] == ["dynamic.start-value", "structure.unique", "xml.encoding"]
    assert brief[4:] == ["Plant.fmu: --all shows 2 more findings and what was not tested."]
    assert "header.date" in " ".join(formats.lines(report, "warning"))


def test_a_terminal_gets_a_page_that_leaves_words_whole(report: Report, monkeypatch: pytest.MonkeyPatch) -> None:
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    def shown(one: Report, everything: bool) -> str:
        monkeypatch.setattr("sys.stdout", terminal := Terminal())
        show(one, "error", everything)
        return terminal.getvalue()

    monkeypatch.setenv("COLUMNS", "60")
    brief, full = shown(report, False), shown(report, True)
    assert " ".join(brief.split()).startswith(f"Plant.fmu: {report.verdict} wrong results error: dynamic.start-value")
    assert "header.date" not in brief and "--explain dynamic.start-value" in brief
    assert [part.splitlines()[0] for part in full.strip().split("\n\n")][1:6] == [
        "wrong results", "other tools refuse it", "formal", "Would a naive importer manage?",
        "not tested (it ran in the sandbox: none)"]
    assert RULES["dynamic.start-value"].says in " ".join(full.split())
    assert shown(Report(Path("a.fmu"), sandbox="none"), True) == "a.fmu: It loads and flies; no findings.\n\n"


def test_junit_is_valid_and_tells_failures_and_skips(report: Report) -> None:
    root = etree.fromstring(formats.as_junit([report, report], "wrong-results").encode())
    etree.XMLSchema(etree.parse(SCHEMAS / "junit.xsd")).assertValid(root)
    suite = root[0]
    assert len(suite) == int(suite.get("tests")) == sum("2.0" in rule.sections for rule in RULES.values()) + 1
    assert [case.get("name") for case in suite.iterfind("testcase[failure]")] == ["dynamic.start-value"]
    assert len(suite.findall("testcase[skipped]")) == int(suite.get("skipped")) == 1
    assert len(suite.findall("testcase[system-out]")) == 4


def test_sarif_is_valid_and_points_to_its_rules(report: Report) -> None:
    data = json.loads(formats.as_sarif([report]))
    checker = jsonschema.Draft202012Validator(json.loads((SCHEMAS / "sarif.json").read_text()))
    assert [error.message for error in checker.iter_errors(data)] == []
    run = data["runs"][0]
    assert [run["tool"]["driver"]["rules"][r["ruleIndex"]]["id"] for r in run["results"]] == [
        r["ruleId"] for r in run["results"]]
    place = run["results"][0]["locations"][0]["physicalLocation"]["artifactLocation"]["uri"]
    assert place == "folder%20with%20space/Plant.fmu"


def test_github_has_one_command_a_finding(report: Report) -> None:
    told = formats.as_github([report]).splitlines()
    assert len(told) == len(report.findings)
    assert [line.split(" ")[0] for line in told] == ["::error", "::error", "::error", "::warning", "::notice"]
    assert all(re.match(r"::\w+ file=folder with space/Plant\.fmu,title=[a-z.-]+::\S", line) for line in told)


def test_json_of_the_command_line(tmp_path: Path) -> None:
    file = write(tmp_path / "Fixture.fmu", members(swapped('stepSize="0.01"', 'stepSize="0"')))
    done = ahv_check("--json", "--no-dynamic", file, "--ignore", "naive.needs-inputs")
    data = json.loads(done.stdout)
    assert (done.returncode, data["passed"], data["fmus"][0]["ignored"]) == (1, False, 1)
    assert data["fmus"][0]["impacts"].keys() == set(IMPACTS)
    assert done.stderr == "ahv: Fixture.fmu breaks FMI 2.0.\n"
    assert json.loads(ahv_check("--format", "json", "--no-dynamic", file).stdout)["passed"] is False


def test_a_log_has_no_table_and_ends_with_the_status(tmp_path: Path) -> None:
    file = write(tmp_path / "Fixture.fmu", members())
    done = ahv_check("--no-dynamic", file)
    assert done.returncode == 0 and done.stdout.splitlines() == [
        "Fixture.fmu: It was read, not run; there are 2 notes (2 on what a naive importer may not bear).",
        "Fixture.fmu: not tested: everything dynamic: not asked for",
        "Fixture.fmu: --all shows 2 more findings and what was not tested."]
    done = ahv_check("--no-dynamic", "--fail-on", "any", file)
    assert done.returncode == 1 and "naive.needs-inputs" in done.stdout
    assert done.stderr == "ahv: Fixture.fmu has findings that --fail-on any rules out.\n"


@pytest.mark.parametrize("words, said", [
    (["--explain", "xml.encodin"], "There is no rule xml.encodin; did you mean xml.encoding?"),
    (["x.fmu", "--ignore", "xml.encodin"], "There is no rule xml.encodin; did you mean xml.encoding?"),
    ([], "Name the FMUs to check, or a rule with --explain."),
])
def test_wrong_use_is_one_sentence(words: list[str], said: str) -> None:
    done = ahv_check(*words)
    assert (done.returncode, done.stderr) == (2, f"ahv: {said}\n")


def test_fmi_3_is_checked_with_its_own_sections_and_words(tmp_path: Path) -> None:
    file = write(tmp_path / "Fixture.fmu", members3(defect="STEP_FAILS"))
    done = ahv_check(file, "--json")
    told = json.loads(done.stdout)["fmus"][0]
    assert (done.returncode, told["fmi_version"]) == (1, "3.0")
    found = next(f for f in told["findings"] if f["rule"] == "dynamic.legal-call")
    assert (found["section"], found["variable"], found["expected"]) == ("4.2", "fmi3DoStep", "fmi3OK")


@pytest.mark.parametrize("rule", RULES.values(), ids=lambda rule: rule.name)
def test_every_rule_is_explained(rule) -> None:
    text = formats.explain(rule)
    assert all(part for part in (rule.says, rule.why, rule.c, rule.pythonfmu))
    assert rule.says.endswith(".") and all(part.endswith((".", "!")) for part in (rule.why, rule.c, rule.pythonfmu))
    assert all(f"FMI {version}, section {section}" in text for version, section in rule.sections.items())
    assert rule.sections and "mend it in C" in text
    assert max(map(len, text.splitlines())) <= 120


def test_what_is_known_of_a_tool_is_said() -> None:
    made = Report(Path("a.fmu"), tool="PythonFMU 0.7.0")
    made.add("dynamic.guid", Fault("fmi2Instantiate", "an instance", "none"))
    assert made.findings[0].known == "pythonfmu 0.7.0's binary; not yours to mend"
    assert "not yours to mend" in formats.lines(made, everything=True)[1]


def test_a_missing_licence_is_not_tested_with_the_words_of_the_fmu(tmp_path: Path) -> None:
    report = check(write(tmp_path / "Fixture.fmu", members(defect="NO_LICENCE")))
    assert report.passed and not report.ran
    assert [n.why for n in report.not_tested] == ["this machine lacks a licence for the FMU: 'no licence: 7'"]
    assert report.verdict.startswith("It was read, not run; ")


def test_a_library_that_the_machine_lacks_is_not_tested(tmp_path: Path) -> None:
    from fmus.native_compiler import cc

    (tmp_path / "other.c").write_text("int nobody(void) { return 0; }\n")
    other = tmp_path / "libnobodyhas.so.3"
    cc("-shared", "-fPIC", tmp_path / "other.c", "-o", other, "-Wl,-soname,libnobodyhas.so.3")
    content = members() | {"binaries/linux64/Fixture.so": library(None, ("-Wl,--no-as-needed", str(other)))}
    report = check(write(tmp_path / "Fixture.fmu", content))
    assert report.passed and not report.ran
    assert [n.why for n in report.not_tested] == ["this machine lacks what the binary needs: libnobodyhas.so.3: cannot "
                                                  "open shared object file: No such file or directory"]
