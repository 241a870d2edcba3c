"""How far a run is from failing a criterion: positive where it meets it, at most 0 where it fails.

The margin of `a < b` is b - a; that of `and` is the least of its parts, that of `or` the largest, that of `not` the
opposite. A run that departed failed whatever it showed: its margin is minus the share of the flight that is missing.
No estimate depends on how far a failure is below 0.
"""
import ast
import math
import sys
from collections.abc import Mapping
from itertools import pairwise

import numpy as np

from ..errors import UsageError
from ..master.evaluate import Courses, value
from ..master.measures import parse, part

LEAST = sys.float_info.min  # of a run that meets its criteria
UPWARDS = (ast.Lt, ast.LtE)


def margin(text: str, course: Courses, metrics: Mapping[str, float | None]) -> float:
    """The margin of an expression; minus infinity where it has no value."""
    return of(parse(text).tree, course, metrics)


def of(node: ast.expr, course: Courses, metrics: Mapping[str, float | None]) -> float:
    """The margin of a part that is true or false."""
    match node:
        case ast.BoolOp(op=op, values=values):
            return (min if isinstance(op, ast.And) else max)(of(child, course, metrics) for child in values)
        case ast.UnaryOp(operand=operand):
            return -of(operand, course, metrics)
        case ast.Compare(left=left, ops=ops, comparators=others) if not equality(node):
            try:
                with np.errstate(all="ignore"):
                    sides = [float(value(child, course, metrics)) for child in (left, *others)]
            except (ArithmeticError, TypeError, UsageError):  # TypeError: a metric is None
                return -math.inf
            found = [b - a if isinstance(op, UPWARDS) else a - b for a, op, b in zip(sides, ops, sides[1:])]
            return -math.inf if any(map(math.isnan, found)) else min(found)
        case ast.Compare(left=left, ops=ops, comparators=others):  # of truths: both hold, or neither
            parts = [of(child, course, metrics) for child in (left, *others)]
            alike = [max(min(a, b), min(-a, -b)) for a, b in pairwise(parts)]
            return min(m if isinstance(op, ast.Eq) else -m for m, op in zip(alike, ops))
    raise AssertionError(node)


def equality(node: ast.Compare) -> bool:
    """Whether it is == or != somewhere."""
    return any(isinstance(op, ast.Eq | ast.NotEq) for op in node.ops)


def check(text: str) -> None:
    """Raises ValueError for an expression with a comparison that has no margin."""
    for node in ast.walk(parse(text).tree):
        if isinstance(node, ast.Compare) and equality(node) and not all(
                isinstance(side, ast.Compare | ast.BoolOp) or (isinstance(side, ast.UnaryOp) and
                                                                isinstance(side.op, ast.Not))
                for side in (node.left, *node.comparators)):
            raise ValueError(f"{part(node, text.strip())} is met or not, with nothing between: rare needs < or >")


def of_flight(texts: Mapping[str, str], success: Mapping[str, bool], course: Courses,
              metrics: Mapping[str, float | None], ended: float | None) -> float:
    """The margin of all `texts` together, of a run that judged them as `success`; `ended` is the share of the flight
    after which a run departed."""
    if ended is not None:
        return ended - 1.0
    found = min(margin(text, course, metrics) for text in texts.values())
    return signed(found, all(success[name] for name in texts))


def signed(found: float, succeeded: bool) -> float:
    """A margin that agrees with the criterion at its very limit, and where rounding would have it otherwise."""
    return max(found, LEAST) if succeeded else min(found, 0.0)
