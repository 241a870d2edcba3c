"""The nominal flight of each law, which shows success expressions that have no value."""
from dataclasses import replace
from types import SimpleNamespace

import pytest
from distributed import KilledWorker
from flights import made

from cosim.campaign.criteria import judged
from cosim.campaign.nominal import check
from cosim.campaign.worker import Outcome, Request
from cosim.errors import RunError, UsageError
from cosim.yaml_file import Source

SHOWN = {"altitude_error_ft.max_abs": 3.0, "protected_s": 0.0, "elevator_deg.min": -4.0}


class Future:
    """A task that is done."""

    def __init__(self, outcome):
        self.outcome = outcome

    def exception(self):
        return self.outcome if isinstance(self.outcome, Exception) else None

    def result(self):
        return self.outcome


def flown(status="finished", metrics=SHOWN, message=""):
    return Outcome(Request(-1, "", {}, {}, False, False), status, message, metrics=metrics)


def valued(text, outcome):
    """`outcome` with what the worker says of the criterion `text`."""
    if isinstance(outcome, Exception):
        return outcome
    flight = made([0.0, 1.0], {"plant.x": 0.0})
    _, success, reasons = judged(lambda flight: outcome.metrics, {}, {"good": text}, flight)
    return replace(outcome, success=success, reasons=reasons)


def tried(tmp_path, text, **outcomes):
    """`check` of a campaign with the success expression `text`, whose laws end like `outcomes`."""
    path = tmp_path / "file.yaml"
    path.write_text(f"name: small\nsuccess:\n  good: {text}\n")
    source = Source(path)
    plan = SimpleNamespace(source=source, laws=list(outcomes), job=SimpleNamespace(key="key"),
                           campaign=SimpleNamespace(success=source.data["success"]))
    client = SimpleNamespace(submit=lambda function, key, law, pure: Future(valued(text, outcomes[law])))
    return check(client, plan)


@pytest.mark.parametrize("status", ["finished", "departed"])
@pytest.mark.parametrize("text,reason", [
    ("altitude_error_ft.max_abs / protected_s < 3", "division by zero"),
    ("elevator_deg.min ** 0.5 < 3", "-4 ** 0.5 is not a real number"),
    ("phi_hat.velocity_max < 3", "there is no phi_hat.velocity_max"),
])
def test_an_expression_without_a_value_is_refused_with_line_field_and_law(tmp_path, text, reason, status):
    with pytest.raises(UsageError) as error:
        tried(tmp_path, text, one=flown(metrics={**SHOWN, "protected_s": 1.0, "elevator_deg.min": 4.0,
                                                 "phi_hat.velocity_max": 1.0}), other=flown(status))
    said = str(error.value)
    assert f"file.yaml, line 3: success.good: '{text}' has no value on the nominal flight of other" in said
    assert reason in said and len(said.splitlines()) == 1


def test_an_expression_that_is_false_on_the_nominal_flight_is_none_of_our_business(tmp_path):
    assert tried(tmp_path, "altitude_error_ft.max_abs < 1", one=flown()) == []
    assert tried(tmp_path, "protected_s == 0 or altitude_error_ft.max_abs / protected_s < 3", one=flown()) == []


@pytest.mark.parametrize("status", ["error", "timed-out", "crashed"])
def test_a_nominal_flight_that_shows_nothing_is_told_and_refuses_nothing(tmp_path, status):
    said = tried(tmp_path, "phi_hat.velocity_max < 3", one=flown(status, {}, "plant.mass = -1 is not allowed."))
    assert said == ["The success expressions could not be tried on the nominal flight of one: plant.mass = -1 is not "
                    "allowed."]


def test_a_nominal_flight_that_kills_its_workers_is_told(tmp_path):
    killed = KilledWorker("task", None, 1)
    assert ["each worker that flew it died" in s for s in tried(tmp_path, "protected_s < 3", one=killed)] == [True]


def test_a_cluster_that_cannot_fly_is_told(tmp_path):
    with pytest.raises(RunError, match="cannot fly this campaign: KeyError"):
        tried(tmp_path, "protected_s < 3", one=KeyError("job"))
