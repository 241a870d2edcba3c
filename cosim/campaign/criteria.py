"""Success criteria: expressions (master.measures) that are true or false of a run, such as
`altitude_error_ft.max_abs < 20 and elevator_deg.travel < 300`."""
from collections.abc import Mapping
from typing import Annotated

from pydantic import AfterValidator

from ..errors import UsageError
from ..master.course import Course
from ..master.evaluate import TRUTH
from ..master.measures import check, parse
from ..vehicle.metrics import METRICS


def nothing(name: str) -> Course:
    """The signals of a run that shows metrics only. Raises UsageError."""
    raise UsageError(f"there is no {name}")


def judged(text: str, metrics: Mapping[str, float | None]) -> bool:
    """Whether the expression is true. Raises ValueError, with the reason, where it has no value."""
    return bool(parse(text).value(nothing, metrics))


def holds(text: str, metrics: Mapping[str, float | None]) -> bool:
    """Whether the expression is true; one without a value, as where a metric is missing, is not."""
    return parse(text).holds(nothing, metrics)


def metrics_of(text: str) -> tuple[str, ...]:
    """The metrics that the expression uses, in its order. Raises ValueError as `parse` does."""
    return parse(checked(text)).names


def checked(text: str) -> str:
    """`text` itself. Raises ValueError if it is no expression, or not true or false."""
    check(parse(text), (), METRICS, TRUTH)
    return text


Criterion = Annotated[str, AfterValidator(checked)]
