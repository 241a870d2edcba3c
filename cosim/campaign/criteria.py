"""Metrics and success criteria of a campaign file: expressions (master.measures), such as
`altitude_error_ft.max_abs < 20 and elevator_deg.travel < 300`. They are checked before anything flies, and valued in
the worker."""
import ast
from collections.abc import Collection, Mapping
from functools import cache

from ..errors import UsageError, did_you_mean
from ..master.course import Course
from ..master.evaluate import NUMBER, TRUTH, Courses, word
from ..master.flight import Flight
from ..master.measures import check, parse, shown, values
from ..yaml_file import Source
from .spec import Campaign
from .subject import Measure, Subject


def check_measures(source: Source, campaign: Campaign, subject: Subject, signals: Collection[str],
                   drawn: Collection[str]) -> None:
    """Raises UsageError, with line and field, for a metric or criterion that is none, or names what there is not.

    `signals` are those of all variants together, `drawn` the columns of the draws.
    """
    known = list(subject.metrics)
    taken = {"run", subject.column, "seed", "status", "message", "success", "ticks", "departed_at_s",
             *(f"success.{name}" for name in campaign.success), *drawn, *signals,
             *(["margin"] if campaign.rare else [])}
    for name, text in campaign.metrics.items():
        with source.at("metrics", name):
            if name in known or name in taken:
                kind = "metric" if name in known else "column or a signal"
                raise UsageError(f"there is a {kind} of this name already")
            later = [n for n in parse(text).names if n in campaign.metrics and n not in known]
            if later:
                raise UsageError(f"'{shown(text)}': {later[0]} is no metric yet: a metric may name those above it")
            check(parse(text), signals, known, NUMBER)
        known.append(name)
    for name, text in campaign.success.items():
        with source.at("success", name):
            check(parse(text), signals, known, TRUTH)
    if campaign.worst_by not in (None, *known):
        source.fail(("worst_by",), f"there is no {campaign.worst_by}; there are {', '.join(known) or 'no metrics'}")
    for i, name in enumerate(getattr(campaign, "over_time", ())):
        if name not in signals:
            source.fail(("over_time", i), f"there is no signal {name}{did_you_mean(name, signals)}")


def least_is_worst(metric: str | None, success: Collection[str]) -> bool:
    """Whether the criteria bound the metric from below only, as `clearance > 3` does."""
    found = set()
    for node in (node for text in success for node in ast.walk(parse(text).tree) if isinstance(node, ast.Compare)):
        names = [word(side) for side in (node.left, *node.comparators)]
        for a, op, b in zip(names, node.ops, names[1:]):
            if metric is not None and metric in (a, b) and isinstance(op, ast.Lt | ast.LtE | ast.Gt | ast.GtE):
                found.add((a == metric) == isinstance(op, ast.Gt | ast.GtE))
    return found == {True}


def courses(flight: Flight) -> Courses:
    """The course of a signal by its name. Raises UsageError for one that was not recorded."""
    @cache
    def course(name: str) -> Course:
        if name not in flight:
            raise UsageError(f"there is no {name}")
        return flight.course(name)

    return course


def judged(measure: Measure, metrics: Mapping[str, str], success: Mapping[str, str], flight: Flight
           ) -> tuple[dict[str, float], dict[str, bool], dict[str, str]]:
    """What a flight shows: the metrics that it has; the criteria; why criteria without a value have none.

    A criterion without a value is false, and so is every one of a flight that did not reach its end.
    """
    course = courses(flight)
    found = {**dict.fromkeys(metrics), **measure(flight)}
    found |= values({name: parse(text) for name, text in metrics.items()}, course, found)
    held, reasons = {}, {}
    for name, text in success.items():
        try:
            held[name] = bool(parse(text).value(course, found)) and flight.finished
        except ValueError as reason:
            held[name], reasons[name] = False, str(reason)
    return {name: value for name, value in found.items() if value is not None}, held, reasons
