"""Expressions on recorded signals: `max(abs(plant.h - controller.h_reference))`, `first(tank.level > 2) < 30`.

An expression has numbers, names, + - * / **, comparisons, and, or, not, and the functions of `evaluate`; nothing else
is evaluated. A name is a signal (component.variable), or a metric, which is a number. A name with other characters than
letters, digits and _ is written in quotes: `max("body.x[1]")`. Arithmetic and comparisons of signals are made at each
time and give a signal or a condition; a function such as `max` or `first` makes a number of it.
"""
import ast
import math
from collections.abc import Collection, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from ..errors import UsageError, nearest
from .evaluate import (
    BINARY,
    COMPARE,
    CONDITION,
    EQUAL,
    FIGURES,
    FUNCTIONS,
    NUMBER,
    SIGN,
    SIGNAL,
    TRUTH,
    Courses,
    children,
    value,
    word,
)

MOST_CHARACTERS = 1000
DEEPEST = 100  # of brackets, signs and operators in each other; Python itself fails at several hundred
NAMES = sorted({*FUNCTIONS, *FIGURES})


@dataclass(frozen=True)
class Expression:
    """An expression that `parse` has read. It is told by its text."""
    text: str

    @property
    def tree(self) -> ast.expr:
        """What it consists of."""
        return read(self.text)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """The metrics and signals that it names, in its order."""
        return tuple(dict.fromkeys(all_names(self.tree)))

    def value(self, course: Courses, metrics: Mapping[str, float | None]) -> float | bool:
        """What it is worth: a truth, or a number, which may be infinite. Names are looked up in `metrics`, then with
        `course`. Raises ValueError, with the reason, where it has no value."""
        for name in self.names:
            if name in metrics and not defined(metrics[name]):
                raise ValueError(f"there is no {name}")
        try:
            with np.errstate(all="ignore"):
                found = value(self.tree, course, metrics)
        except (ArithmeticError, UsageError) as error:
            raise ValueError(str(error).rstrip(".")) from None
        return found if isinstance(found, bool) else float(found)

    def holds(self, course: Courses, metrics: Mapping[str, float | None]) -> bool:
        """Whether it is true; what has no value, as where a metric is missing, is not."""
        try:
            return bool(self.value(course, metrics))
        except ValueError:
            return False


def values(expressions: Mapping[str, Expression], course: Courses, metrics: Mapping[str, float | None]
           ) -> dict[str, float]:
    """The numbers that expressions are worth, without those that have no value or are NaN; each may name `metrics` and
    those before it. Signals are asked for once."""
    known = dict(metrics)
    course = lru_cache(None)(course)
    for name, expression in expressions.items():
        known[name] = None
        with suppress(ValueError):
            known[name] = float(expression.value(course, known))
    return {name: number for name in expressions if (number := known[name]) is not None and defined(number)}


def defined(number: float | None) -> bool:
    """Whether it is a number, and no NaN."""
    return number is not None and not math.isnan(number)


def parse(text: str) -> Expression:
    """The expression `text`, whose names nobody has looked up yet. Raises ValueError, one sentence, if it is none."""
    read(text)
    return Expression(text)


@lru_cache(1000)
def read(text: str) -> ast.expr:
    """The tree of an expression. Raises ValueError as `parse` does."""
    if len(text) > MOST_CHARACTERS:
        raise ValueError(f"an expression has at most {MOST_CHARACTERS} characters, not {len(text)}")
    try:
        tree = ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise ValueError(f"'{shown(text)}' is not an expression") from None
    try:
        allowed(tree, text.strip())
    except ValueError as error:
        raise ValueError(f"'{shown(text)}': {error}") from None
    return tree


def all_names(node: ast.expr) -> Iterator[str]:
    """All names, in the text's order."""
    name = word(node)
    if name is not None:
        yield name
    for child in children(node):
        yield from all_names(child)


def shown(text: str) -> str:
    """`text` on one line, the middle of a long one left out."""
    text = " ".join(text.split())
    return text if len(text) <= 100 else f"{text[:60]} ... {text[-30:]}"


def part(node: ast.AST, text: str) -> str:
    """A part of the expression `text`, for a message."""
    return shown(ast.get_source_segment(text, node) or "a part of it")


def allowed(node: ast.AST, text: str, depth: int = 0) -> None:
    """Raises ValueError for what is no part of the language."""
    if depth > DEEPEST:
        raise ValueError(f"it is nested more than {DEEPEST} levels deep")
    match node:
        case _ if word(node) is not None:
            pass
        case ast.Constant(value=int() | float() as number) if not isinstance(number, bool):
            if number >= 2**1024:
                raise ValueError(f"{part(node, text)} is too large a number")
        case ast.BoolOp() | ast.UnaryOp(op=ast.Not()):
            pass
        case ast.UnaryOp(op=op) if type(op) in SIGN:
            pass
        case ast.BinOp(op=op) if type(op) in BINARY:
            pass
        case ast.Compare(ops=ops) if all(type(op) in COMPARE for op in ops):
            pass
        case ast.Call(func=ast.Name(id=name), args=args, keywords=[]) if name in NAMES:
            counts = {*(FUNCTIONS[name].counts if name in FUNCTIONS else ()),
                      *([len(FIGURES[name].takes)] if name in FIGURES else ())}
            if len(args) not in counts:
                words = (FUNCTIONS.get(name) or FIGURES[name]).words
                raise ValueError(f"{name} takes {words}, not {len(args)}: {part(node, text)}")
        case ast.Call(func=ast.Name(id=name), keywords=[]) if near := nearest(name, NAMES):
            raise ValueError(f"there is no function {shown(name)}; did you mean {near}?")
        case ast.Subscript(value=base) if word(base) is not None:
            raise ValueError(f"{part(node, text)} is not allowed in an expression; a signal of that name is written in "
                             "quotes")
        case _:
            raise ValueError(f"{part(node, text)} is not allowed in an expression")
    for child in children(node):
        allowed(child, text, depth + 1)


def check(expression: Expression, signals: Collection[str], metrics: Collection[str], wanted: str | None = None) -> str:
    """What the expression is, where `signals` are recorded and the numbers `metrics` are known: NUMBER, TRUTH, SIGNAL
    or CONDITION. Raises ValueError for a name that there is not, for parts that do not fit each other, and for anything
    that is not `wanted` as a whole."""
    text = expression.text.strip()
    for name in expression.names:
        if name not in metrics and name not in signals:
            raise ValueError(f"'{shown(text)}': {unknown(name, signals, metrics)}")
    try:
        found = kind(expression.tree, text, metrics)
    except ValueError as error:
        raise ValueError(f"'{shown(text)}': {error}") from None
    if wanted not in (None, found):
        raise ValueError(f"'{shown(text)}' {misfit(found, shown(text))}")
    return found


def unknown(name: str, signals: Collection[str], metrics: Collection[str]) -> str:
    """The sentence about a name that there is not."""
    what = "metric or signal" if signals else "metric"
    near = nearest(name, [*metrics, *signals], 0.7)
    end = f"did you mean {near}?" if near and signals else f"there are {', '.join(metrics) or 'none'}"
    return f"there is no {what} {shown(name)}; {end}"


def misfit(found: str, text: str) -> str:
    """What to do about an expression that is `found` and should be something else."""
    if found == SIGNAL:
        return f"is a signal: say which number of it, such as max({text})"
    if found == CONDITION:
        return f"is true or false at each time: say how long it holds, or from when on: time_on({text}), first({text})"
    return "is neither true nor false: compare something" if found == NUMBER else "is true or false, not a number"


def kind(node: ast.expr, text: str, metrics: Collection[str]) -> str:
    """What a part of the expression `text` is. Raises ValueError for parts that do not fit each other."""
    parts = children(node)
    found = [kind(child, text, metrics) for child in parts]

    def must_be(child: int, *wanted: str) -> None:
        if found[child] not in wanted:
            over_time = f"{found[child]}, " if found[child] in (SIGNAL, CONDITION) else ""
            other = "of the whole run" if found[child] == CONDITION and wanted[0] == TRUTH else wanted[0]
            raise ValueError(f"in {part(node, text)}, {part(parts[child], text)} is {over_time}not {other}")

    def numbers() -> str:
        for child in range(len(parts)):
            must_be(child, NUMBER, SIGNAL)
        return SIGNAL if SIGNAL in found else NUMBER

    def truths() -> str:
        wanted = (TRUTH,) if found[0] in (TRUTH, NUMBER) else (CONDITION, SIGNAL)  # a signal holds where it is not 0
        for child in range(len(parts)):
            must_be(child, *wanted)
        return wanted[0]

    match node:
        case ast.BoolOp() | ast.UnaryOp(op=ast.Not()):
            return truths()
        case ast.Compare(ops=ops):
            alike = found[0] in (TRUTH, CONDITION) and all(type(op) in EQUAL for op in ops)
            return CONDITION if (truths() if alike else numbers()) in (SIGNAL, CONDITION) else TRUTH
        case ast.Call(func=ast.Name(id=name)) if name in FIGURES and len(parts) == len(FIGURES[name].takes):
            if name in FUNCTIONS and found[0] == NUMBER:
                raise ValueError(f"{name} takes {FUNCTIONS[name].words}, not 1: {part(node, text)}")
            for child, wanted in enumerate(FIGURES[name].takes):
                must_be(child, wanted, *((SIGNAL,) if wanted == CONDITION else ()))
            return NUMBER
    if parts:
        return numbers()
    named = word(node)
    return SIGNAL if named is not None and named not in metrics else NUMBER
