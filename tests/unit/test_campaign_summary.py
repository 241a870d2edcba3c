"""What the terminal and the report say of each law: shares of the judged runs, failures of the machinery apart."""
from types import SimpleNamespace

from cosim.campaign.report import side_by_side
from cosim.cli.campaign import table

LAW = {"runs": 1000, "judged": 990, "successes": 330, "failures": {"law": 660, "machinery": 10}, "probability": 1 / 3,
       "interval_95": [0.304, 0.364], "statuses": {"crashed": 1, "departed": 600, "error": 9, "finished": 390},
       "metrics": {}}
NONE = {**LAW, "judged": 0, "successes": 0, "failures": {"law": 0, "machinery": 1000}, "probability": None,
        "interval_95": [0.0, 1.0], "statuses": {"error": 1000}}
ALL = {**LAW, "judged": 1000, "failures": {"law": 670, "machinery": 0}, "statuses": {"finished": 1000}}
SUMMARY = {"campaign": "c", "controllers": {"a": LAW, "b": NONE, "c": ALL}, "interval": "worth", "wall_s": 1.0,
           "judged": ["finished", "departed"], "report": "report.html",
           "paired": {"a and b": {"both": 1, "not judged": 2}}}


def test_the_terminal_says_over_what_and_what_was_not_judged():
    assert table(SUMMARY) == {
        "campaign": "c", "success, a": "33.33 % (30.40 to 36.40), 330 of 990 judged runs",
        "not judged, a": "10 of 1,000 runs: crashed 1, error 9",
        "success, b": "unknown (0.00 to 100.00), 0 of 0 judged runs",
        "not judged, b": "1,000 of 1,000 runs: error 1,000",
        "success, c": "33.33 % (30.40 to 36.40), 330 of 1,000 judged runs",
        "interval": "worth", "wall_s": 1.0, "report": "report.html"}


def test_the_report_says_whose_failures_there_are():
    subject = SimpleNamespace(column="controller", noun="law")
    text = side_by_side(SimpleNamespace(subject=subject, headlines=[]), SUMMARY)
    for row in (("successes", "330 of 990 judged", "0 of 0 judged", "330 of 1,000 judged"),
                ("probability of success", "33.33 %", "unknown", "33.33 %"),
                ("failures of the law", "660", "0", "670"), ("failures of the machinery", "10", "1,000", "0"),
                ("error", "9", "1,000", "0"), ("departed", "600", "0", "0")):
        assert "<tr>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>" in text
    assert "both 1, not judged 2" in text


def test_the_report_counts_runs_whose_metric_is_infinite():
    laws = {"a": {**LAW, "metrics": {"late": {"median": 2.0, "p95": 3.0, "infinite": 1200}}}, "b": LAW}
    plan = SimpleNamespace(subject=SimpleNamespace(noun="law", column="controller"), headlines=["late"],
                           metrics={"late": SimpleNamespace(unit="s")})
    text = side_by_side(plan, {**SUMMARY, "controllers": laws})
    for row in ("late (s), median</td><td>2</td><td>", "late, infinite (in neither)</td><td>1,200</td><td>0"):
        assert row in text
