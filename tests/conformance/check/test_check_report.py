"""The report: a JSON-able dict with fixed keys, tables, and a document that is up to date."""

import io
import json
from pathlib import Path

import pytest
import table
from check_cases import CASES
from check_fixture import BASE_XML, members, write
from rich.console import Console

from cosim.conformance import check
from cosim.conformance.report import findings_table, not_tested_table, to_dict
from cosim.conformance.rule import RULES
from cosim.errors import UsageError


def test_json_has_the_documented_keys(tmp_path: Path) -> None:
    xml = BASE_XML.replace('stepSize="0.01"', 'stepSize="0"').replace("03:04:05Z", "03:04:05")
    data = json.loads(json.dumps(to_dict(check(write(tmp_path / "Fixture.fmu", members(xml)), dynamic=False))))
    assert set(data) == {"fmu", "passed", "verdict", "fmi_version", "tool", "counts", "impacts", "findings",
                         "not_tested", "ignored", "sandbox"}
    assert data["passed"] is False
    assert data["counts"] == {"error": 1, "warning": 1, "note": 2}
    assert [finding["rule"] for finding in data["findings"]] == [
        "experiment.step", "header.date", "naive.non-real-output", "naive.needs-inputs"]
    assert data["impacts"] == {"does not load": 0, "wrong results": 1, "other tools refuse it": 1, "formal": 2}
    assert data["verdict"] == ("It was read, not run; 1 finding can give wrong results, 1 finding is formal, "
                               "there are 2 notes (2 on what a naive importer may not bear).")
    assert set(data["findings"][0]) == {"rule", "section", "severity", "variable", "found", "expected", "impact",
                                           "says", "group", "known"}
    assert data["not_tested"] == [{"what": "everything dynamic", "why": "not asked for"}]


@pytest.mark.parametrize("limit", [0.0, -1.0, float("nan")])
def test_a_time_limit_that_is_none_is_refused(tmp_path: Path, limit: float) -> None:
    with pytest.raises(UsageError, match=rf"^--time-limit {limit:g} must be a positive number of seconds\.$"):
        check(tmp_path / "Fixture.fmu", time_limit=limit)


def test_tables_show_names_with_brackets(tmp_path: Path) -> None:
    xml = BASE_XML.replace('name="plant.x[1]"', 'name="plant.x[red]"')
    report = check(write(tmp_path / "Fixture.fmu", members(xml)), dynamic=False)
    console = Console(file=io.StringIO(), width=200)
    console.print(findings_table(report), not_tested_table(report))
    assert isinstance(console.file, io.StringIO)
    text = console.file.getvalue()
    assert "plant.x[red]" in text and "variable.structured-name" in text and "not asked for" in text


def test_document_lists_every_rule() -> None:
    text = table.DOCUMENT.read_text("utf-8")
    assert [name for name in RULES if f"| {name} |" not in text] == []
    assert f"| all | {len(CASES)} |" in text


@pytest.mark.slow
def test_document_agrees_with_a_new_comparison() -> None:
    found = table.compare(CASES)
    text = table.DOCUMENT.read_text("utf-8")
    assert "\n".join(table.summary(found)) in text
    assert "\n".join(table.by_rule(found)) in text
