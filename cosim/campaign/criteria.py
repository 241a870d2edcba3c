"""Success criteria: expressions on the metrics, such as `altitude_error_ft.max_abs < 20 and elevator_deg.travel < 300`.

Allowed are numbers, metrics, + - * / **, comparisons, and, or, not, and abs, min, max; nothing else is evaluated.
"""
import ast
import math
import operator
from collections.abc import Callable, Iterator, Mapping
from typing import Annotated, Any

from pydantic import AfterValidator

from ..vehicle.metrics import METRICS

BINARY: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
    ast.Pow: operator.pow}
COMPARE: dict[type, Callable[[Any, Any], Any]] = {
    ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt, ast.GtE: operator.ge, ast.Eq: operator.eq,
    ast.NotEq: operator.ne}
UNARY: dict[type, Callable[[Any], Any]] = {ast.USub: operator.neg, ast.UAdd: operator.pos, ast.Not: operator.not_}
FUNCTIONS: dict[str, Callable[..., Any]] = {"abs": abs, "min": min, "max": max}
MOST_CHARACTERS = 1000


def dotted(node: ast.AST) -> str | None:
    """`a.b` as text, or None."""
    if isinstance(node, ast.Name):
        return node.id
    if isinstance(node, ast.Attribute):
        left = dotted(node.value)
        return left and f"{left}.{node.attr}"
    return None


def parse(text: str) -> ast.expr:
    """The expression's tree. Raises ValueError for what is no expression, or not allowed."""
    if len(text) > MOST_CHARACTERS:
        raise ValueError(f"an expression has at most {MOST_CHARACTERS} characters")
    try:
        tree = ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise ValueError(f"'{text}' is not an expression") from None
    for _ in names(tree, text):
        pass
    if not isinstance(tree, ast.Compare | ast.BoolOp) and not (
            isinstance(tree, ast.UnaryOp) and isinstance(tree.op, ast.Not)):
        raise ValueError(f"'{text}' is neither true nor false: compare something")
    return tree


def names(node: ast.AST, text: str) -> Iterator[str]:
    """The metrics that the expression uses. Raises ValueError for anything that is not allowed."""
    word = dotted(node)
    if word is not None:
        if word not in METRICS:
            raise ValueError(f"'{text}': there is no metric {word}; there are {', '.join(METRICS)}")
        yield word
        return
    children: list[ast.AST]
    match node:
        case ast.Constant(value=value) if isinstance(value, int | float) and not isinstance(value, bool):
            return
        case ast.BoolOp(values=values):
            children = list(values)
        case ast.BinOp(left=left, op=op, right=right) if type(op) in BINARY:
            children = [left, right]
        case ast.UnaryOp(op=op, operand=operand) if type(op) in UNARY:
            children = [operand]
        case ast.Compare(left=left, ops=ops, comparators=others) if all(type(op) in COMPARE for op in ops):
            children = [left, *others]
        case ast.Call(func=ast.Name(id=name), args=args, keywords=[]) if name in FUNCTIONS and args:
            children = list(args)
        case _:
            raise ValueError(f"'{text}': {ast.unparse(node)} is not allowed in an expression")
    for child in children:
        yield from names(child, text)


def value(node: ast.AST, metrics: Mapping[str, float]) -> Any:
    """The value of an expression's tree; comparisons are bool, everything else float."""
    word = dotted(node)
    if word is not None:
        return metrics[word]
    match node:
        case ast.Constant(value=number):
            return float(number)  # type: ignore[arg-type]
        case ast.BoolOp(op=ast.And(), values=values):
            return all(value(v, metrics) for v in values)
        case ast.BoolOp(values=values):
            return any(value(v, metrics) for v in values)
        case ast.BinOp(left=left, op=op, right=right):
            return BINARY[type(op)](value(left, metrics), value(right, metrics))
        case ast.UnaryOp(op=op, operand=operand):
            return UNARY[type(op)](value(operand, metrics))
        case ast.Call(func=ast.Name(id=name), args=args):
            return FUNCTIONS[name](*(value(a, metrics) for a in args))
        case ast.Compare(left=left, ops=ops, comparators=others):
            sides = [value(n, metrics) for n in (left, *others)]
            return all(COMPARE[type(op)](a, b) for a, op, b in zip(sides, ops, sides[1:]))
    raise AssertionError(node)


def holds(text: str, metrics: Mapping[str, float]) -> bool:
    """Whether the expression is true. One with a metric that the run does not have, or without a value, is false."""
    tree = parse(text)
    if any(math.isnan(metrics.get(name, math.nan)) for name in names(tree, text)):
        return False
    try:
        return bool(value(tree, metrics))
    except (ArithmeticError, TypeError, ValueError):  # 1/0, overflow, a complex root
        return False


def metrics_of(text: str) -> list[str]:
    """The metrics that the expression uses, in its order. Raises ValueError as `parse` does."""
    return list(names(parse(text), text))


def checked(text: str) -> str:
    """`text` itself. Raises ValueError as `parse` does."""
    parse(text)
    return text


Criterion = Annotated[str, AfterValidator(checked)]
