"""Success criteria: expressions on the metrics, such as `altitude_error_ft.max_abs < 20 and elevator_deg.travel < 300`.

Allowed are numbers, metrics, + - * / **, comparisons, and, or, not, and abs, min, max; nothing else is evaluated.
Numbers are calculated with and compared, truths are joined by and, or, not.
"""
import ast
import math
import operator
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Annotated, Any

from pydantic import AfterValidator

from ..vehicle.metrics import METRICS

NUMBER, TRUTH = "a number", "true or false"  # what an expression, or a part of one, can be


def power(base: float, exponent: float) -> float:
    """base ** exponent. Raises ArithmeticError where that is no real number, or too large for one."""
    try:
        return math.pow(base, exponent)
    except (ValueError, OverflowError):
        raise ArithmeticError(f"{base:g} ** {exponent:g} is not a real number below 1e308") from None


BINARY: dict[type, Callable[[float, float], float]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv, ast.Pow: power}
EQUAL: dict[type, Callable[[Any, Any], bool]] = {ast.Eq: operator.eq, ast.NotEq: operator.ne}
COMPARE: dict[type, Callable[[Any, Any], bool]] = {
    **EQUAL, ast.Lt: operator.lt, ast.LtE: operator.le, ast.Gt: operator.gt, ast.GtE: operator.ge}
SIGN: dict[type, Callable[[float], float]] = {ast.USub: operator.neg, ast.UAdd: operator.pos}
FUNCTIONS: dict[str, tuple[Callable[..., float], range, str]] = {
    "abs": (abs, range(1, 2), "one number"),
    "min": (min, range(2, 1000), "two numbers or more"), "max": (max, range(2, 1000), "two numbers or more")}
MOST_CHARACTERS = 1000
DEEPEST = 100  # of brackets, signs and operators in each other; Python itself fails at several hundred


def dotted(node: ast.AST) -> str | None:
    """`a.b` as text, or None."""
    parts: list[str] = []
    while isinstance(node, ast.Attribute):
        parts.append(node.attr)
        node = node.value
    return ".".join([node.id, *reversed(parts)]) if isinstance(node, ast.Name) else None


def shown(text: str) -> str:
    """`text` on one line, the middle of a long one left out."""
    text = " ".join(text.split())
    return text if len(text) <= 100 else f"{text[:60]} ... {text[-30:]}"


@lru_cache
def parse(text: str) -> ast.expr:
    """The tree of an expression that is true or false. Raises ValueError for anything else."""
    if len(text) > MOST_CHARACTERS:
        raise ValueError(f"an expression has at most {MOST_CHARACTERS} characters, not {len(text)}")
    try:
        tree = ast.parse(text.strip(), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise ValueError(f"'{shown(text)}' is not an expression") from None
    try:
        found = kind(tree, text.strip())
    except ValueError as error:
        raise ValueError(f"'{shown(text)}': {error}") from None
    if found != TRUTH:
        raise ValueError(f"'{shown(text)}' is neither true nor false: compare something")
    return tree


def kind(node: ast.AST, text: str, depth: int = 0) -> str:
    """NUMBER or TRUTH: what a part of the expression `text` is. Raises ValueError for what is not allowed."""
    def part(node: ast.AST) -> str:
        return shown(ast.get_source_segment(text, node) or "a part of it")

    def all_are(wanted: str | None, *children: ast.expr) -> str:
        """What all children are: `wanted`, or what the first one is."""
        for child in children:
            found = kind(child, text, depth + 1)
            wanted = wanted or found
            if found != wanted:
                raise ValueError(f"in {part(node)}, {part(child)} is not {wanted}")
        return wanted or NUMBER

    if depth > DEEPEST:
        raise ValueError(f"it is nested more than {DEEPEST} levels deep")
    word = dotted(node)
    if word is not None:
        if word not in METRICS:
            raise ValueError(f"there is no metric {shown(word)}; there are {', '.join(METRICS)}")
        return NUMBER
    match node:
        case ast.Constant(value=int() | float() as number) if not isinstance(number, bool):
            if number >= 2**1024:
                raise ValueError(f"{part(node)} is too large a number")
            return NUMBER
        case ast.BoolOp(values=values):
            return all_are(TRUTH, *values)
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            return all_are(TRUTH, operand)
        case ast.UnaryOp(op=op, operand=operand) if type(op) in SIGN:
            return all_are(NUMBER, operand)
        case ast.BinOp(left=left, op=op, right=right) if type(op) in BINARY:
            return all_are(NUMBER, left, right)
        case ast.Call(func=ast.Name(id=name), args=args, keywords=[]) if name in FUNCTIONS:
            _, count, words = FUNCTIONS[name]
            if len(args) not in count:
                raise ValueError(f"{name} takes {words}, not {len(args)}: {part(node)}")
            return all_are(NUMBER, *args)
        case ast.Compare(left=left, ops=ops, comparators=others) if all(type(op) in COMPARE for op in ops):
            all_are(None if all(type(op) in EQUAL for op in ops) else NUMBER, left, *others)
            return TRUTH
    raise ValueError(f"{part(node)} is not allowed in an expression")


def value(node: ast.AST, metrics: Mapping[str, float]) -> Any:
    """The value of an expression's tree: bool or float. Raises ArithmeticError where it has none."""
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
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            return not value(operand, metrics)
        case ast.UnaryOp(op=op, operand=operand):
            return SIGN[type(op)](value(operand, metrics))
        case ast.Call(func=ast.Name(id=name), args=args):
            return FUNCTIONS[name][0](*(value(a, metrics) for a in args))
        case ast.Compare(left=left, ops=ops, comparators=others):
            sides = [value(n, metrics) for n in (left, *others)]
            if any(math.isnan(side) for side in sides):
                raise ArithmeticError("infinity minus infinity, or the like, is not a number")
            return all(COMPARE[type(op)](a, b) for a, op, b in zip(sides, ops, sides[1:]))
    raise AssertionError(node)


def judged(text: str, metrics: Mapping[str, float]) -> bool:
    """Whether the expression is true. Raises ValueError, with the reason, where it has no value."""
    for name in metrics_of(text):
        if math.isnan(metrics.get(name, math.nan)):
            raise ValueError(f"there is no {name}")
    try:
        return bool(value(parse(text), metrics))
    except ArithmeticError as error:
        raise ValueError(str(error)) from None


def holds(text: str, metrics: Mapping[str, float]) -> bool:
    """Whether the expression is true; one without a value, as where a metric is missing, is not."""
    try:
        return judged(text, metrics)
    except ValueError:
        return False


def metrics_of(text: str) -> list[str]:
    """The metrics that the expression uses, in its order. Raises ValueError as `parse` does."""
    nodes = [node for node in ast.walk(parse(text)) if isinstance(node, ast.expr) and dotted(node) in METRICS]
    return [str(dotted(node)) for node in sorted(nodes, key=lambda node: (node.lineno, node.col_offset))]


def checked(text: str) -> str:
    """`text` itself. Raises ValueError as `parse` does."""
    parse(text)
    return text


Criterion = Annotated[str, AfterValidator(checked)]
