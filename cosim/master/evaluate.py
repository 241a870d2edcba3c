"""The functions that expressions have, and the values of their parts. `measures` has the language."""
import ast
import math
import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import reduce
from typing import Any

import numpy as np

from .condition import Condition, combined, finite
from .course import Course

# What an expression, or a part of one, can be.
NUMBER, TRUTH, SIGNAL, CONDITION = "a number", "true or false", "a signal", "true or false at each time"
Courses = Callable[[str], Course]


def power(base: float, exponent: float) -> float:
    """base ** exponent. Raises ArithmeticError where that is no real number, or too large for one."""
    try:
        return math.pow(base, exponent)
    except (ValueError, OverflowError):
        raise ArithmeticError(f"{base:g} ** {exponent:g} is not a real number below 1e308") from None


@dataclass(frozen=True)
class Function:
    """Of one value a signal: what the function does to each of its values; `each` is the same for numbers."""
    words: str                      # what it takes
    counts: range
    each: Callable[..., float]
    values: Callable[..., np.ndarray]


@dataclass(frozen=True)
class Figure:
    """A function that makes a number of a signal or a condition, and of further numbers."""
    words: str
    takes: tuple[str, ...]
    of: Callable[..., float | None]


def least(*arrays: Any) -> np.ndarray:
    """The least value at each time; NaN where one is NaN, which Python's min would hide."""
    return reduce(np.minimum, arrays)


def most(*arrays: Any) -> np.ndarray:
    """The largest value at each time."""
    return reduce(np.maximum, arrays)


def time_above(course: Course, level: float) -> float:
    """How long (s) the signal is above `level`."""
    return Condition.crossed(Course(course.time, course.values - level), np.greater).time_on()


BINARY: dict[type, tuple[Callable[..., float], Callable[..., np.ndarray]]] = {
    ast.Add: (operator.add, np.add), ast.Sub: (operator.sub, np.subtract), ast.Mult: (operator.mul, np.multiply),
    ast.Div: (operator.truediv, np.divide), ast.Pow: (power, np.power)}
EQUAL: dict[type, Callable[..., Any]] = {ast.Eq: operator.eq, ast.NotEq: operator.ne}
COMPARE: dict[type, Callable[..., Any]] = {
    **EQUAL, ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt, ast.GtE: operator.ge}
SIGN: dict[type, Callable[[Any], Any]] = {ast.USub: operator.neg, ast.UAdd: operator.pos}
FUNCTIONS = {"abs": Function("one number", range(1, 2), abs, np.abs),
             "degrees": Function("one number", range(1, 2), math.degrees, np.degrees),
             "min": Function("two numbers or more", range(2, 1000), lambda *numbers: float(least(*numbers)), least),
             "max": Function("two numbers or more", range(2, 1000), lambda *numbers: float(most(*numbers)), most)}
FIGURES = {**{name: Figure("a signal", (SIGNAL,), getattr(Course, name))
              for name in ("min", "max", "final", "mean", "rms", "integral", "max_abs", "travel")},
           "time_above": Figure("a signal and a level", (SIGNAL, NUMBER), time_above),
           "settling": Figure("a signal, a target and a band", (SIGNAL, NUMBER, NUMBER), Course.settling),
           "time_on": Figure("a condition", (CONDITION,), Condition.time_on),
           "first": Figure("a condition", (CONDITION,), Condition.first)}


def word(node: ast.AST) -> str | None:
    """The name `a.b` or "a.b"; None if it is something else."""
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    parts: list[str] = []
    while isinstance(node, ast.Attribute):
        parts.append(node.attr)
        node = node.value
    return ".".join([node.id, *reversed(parts)]) if isinstance(node, ast.Name) else None


def children(node: ast.AST) -> list[ast.expr]:
    """The parts of a part of an expression, in the text's order."""
    if word(node) is not None:
        return []
    return node.args if isinstance(node, ast.Call) else [n for n in ast.iter_child_nodes(node)
                                                         if isinstance(n, ast.expr)]


def value(node: ast.expr, course: Courses, metrics: Mapping[str, float | None]) -> Any:
    """A part's value: bool, float, Course or Condition. Raises ArithmeticError where it has none."""
    def of(child: ast.expr) -> Any:
        return value(child, course, metrics)

    name = word(node)
    if name is not None:
        return metrics[name] if name in metrics else course(name)
    match node:
        case ast.Constant(value=number):
            return float(number)  # type: ignore[arg-type]
        case ast.BoolOp(op=op, values=values):
            first = of(values[0])
            if isinstance(first, bool):
                rest = (of(child) for child in values[1:])
                return first and all(rest) if isinstance(op, ast.And) else first or any(rest)
            logical = np.logical_and if isinstance(op, ast.And) else np.logical_or
            return combined(lambda *held: logical.reduce(held), *map(condition, (first, *map(of, values[1:]))))
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            found = of(operand)
            return not found if isinstance(found, bool) else combined(np.logical_not, condition(found))
        case ast.BinOp(left=left, op=op, right=right):
            return at_each_time(*BINARY[type(op)], of(left), of(right))
        case ast.UnaryOp(op=op, operand=operand):
            return at_each_time(SIGN[type(op)], SIGN[type(op)], of(operand))
        case ast.Call(func=ast.Name(id=name), args=args):
            first, *others = map(of, args)
            if name in FIGURES and isinstance(first, Course | Condition) and len(args) == len(FIGURES[name].takes):
                figure = FIGURES[name]
                found = figure.of(condition(first) if CONDITION in figure.takes else first, *others)
                return math.inf if found is None else found
            return at_each_time(FUNCTIONS[name].each, FUNCTIONS[name].values, first, *others)
        case ast.Compare(left=left, ops=ops, comparators=others):
            sides = [of(child) for child in (left, *others)]
            if any(isinstance(side, float) and math.isnan(side) for side in sides):
                raise ArithmeticError("infinity minus infinity, or the like, is not a number")
            found = [compared(COMPARE[type(op)], a, b) for a, op, b in zip(sides, ops, sides[1:])]
            always = all(one for one in found if isinstance(one, bool))
            over_time = [one for one in found if isinstance(one, Condition)]
            return combined(lambda *held: np.logical_and.reduce(held) & always, *over_time) if over_time else always
    raise AssertionError(node)


def at_each_time(each: Callable[..., float], values: Callable[..., np.ndarray], *sides: Course | float) -> Any:
    """A function of numbers; of the values at each time at which all are known, where one of `sides` is a signal."""
    courses = [side for side in sides if isinstance(side, Course)]
    if not courses:
        return each(*sides)
    time = courses[0].time
    for other in courses[1:]:
        if other.time is not time and not np.array_equal(other.time, time):
            time = np.intersect1d(time, other.time, assume_unique=True)
    return Course(time, values(*(known(side, time) if isinstance(side, Course) else side for side in sides)))


def known(course: Course, time: np.ndarray) -> np.ndarray:
    """The values at those of its rows that `time` has."""
    return course.values if len(course.time) == len(time) else course.values[np.isin(course.time, time)]


def condition(found: Course | Condition) -> Condition:
    """A condition; a signal is one where it is not 0."""
    return Condition.held(found) if isinstance(found, Course) else found


def compared(compare: Callable[..., Any], a: Any, b: Any) -> bool | Condition:
    """A comparison. Of signals, < and the like know when these cross; == and != hold for whole steps, as truths do."""
    if isinstance(a, Condition) or isinstance(b, Condition):
        return combined(compare, condition(a), condition(b))
    if not isinstance(a, Course) and not isinstance(b, Course):
        return bool(compare(a, b))
    if compare in EQUAL.values():
        a, b = (finite(side) if isinstance(side, Course) else side for side in (a, b))
        return Condition.held(at_each_time(compare, compare, a, b))
    return Condition.crossed(at_each_time(operator.sub, np.subtract, a, b), compare)
