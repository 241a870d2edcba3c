"""The places where a source file can be wrong, and how: single-point mutants of Python and of C.

Python is read with `ast`, whose positions in the text give the place of every operator, constant, condition and
statement. C is read with a regular expression that steps over comments, strings and the preprocessor's lines.
A mutant is known by its file, its function, its line and what becomes of the line: it stays the same when lines move.
"""
import ast
import hashlib
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

SWAPS = {  # one symbol for another, in both languages
    "<": ("<=", ">="), "<=": ("<", ">"), ">": (">=", "<="), ">=": (">", "<"), "==": ("!=",), "!=": ("==",),
    "+": ("-",), "-": ("+",), "*": ("/",), "/": ("*",), "//": ("*",), "%": ("*",), "**": ("*",), "+=": ("-=",),
    "-=": ("+=",), "*=": ("/=",), "/=": ("*=",), "//=": ("*=",), "|": ("&",), "&": ("|",), "|=": ("&=",),
    "&=": ("|=",), "and": ("or",), "or": ("and",), "&&": ("||",), "||": ("&&",), "in": ("not in",),
    "not in": ("in",), "is": ("is not",), "is not": ("is",),
}
CALLS = {"min": "max", "max": "min", "any": "all", "all": "any", "floor": "ceil", "ceil": "floor", "sin": "cos",
         "cos": "sin", "fmin": "fmax", "fmax": "fmin", "startswith": "endswith", "endswith": "startswith"}
SYMBOLS = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=", ast.Add: "+",
           ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.FloorDiv: "//", ast.Mod: "%", ast.Pow: "**", ast.BitOr: "|",
           ast.BitAnd: "&", ast.And: "and", ast.Or: "or", ast.In: "in", ast.NotIn: "not in", ast.Is: "is",
           ast.IsNot: "is not"}


@dataclass(frozen=True)
class Mutant:
    """`text` is the whole mutated file; `before` and `after` are the changed lines without their indentation."""
    file: str
    function: str
    before: str
    after: str
    text: str

    @property
    def key(self) -> tuple[str, str, str, str]:
        """What names it in results and in the list of judged ones."""
        return self.file, self.function, self.before, self.after

    def drawn(self, seed: int) -> str:
        """What a sample is sorted by. It depends on no other mutant, so that a sample stays when code is added."""
        return hashlib.sha256(repr((seed, self.key)).encode()).hexdigest()


def mutants(root: Path, file: str) -> list[Mutant]:
    """All mutants of `file`, a path below `root`."""
    text = (root / file).read_text(encoding="utf-8")
    changes = c_changes(text) if file.endswith(".c") else python_changes(text)
    found, seen = [], Counter()
    for start, end, new, function in changes:
        mutated = text[:start] + new + text[end:]
        if mutated == text or (file.endswith(".py") and not compiles(mutated)):
            continue
        first, last = text.rfind("\n", 0, start) + 1, text.find("\n", end)
        before = " ".join(text[first:last].split())
        after = " ".join(mutated[first:last + len(mutated) - len(text)].split())
        seen[function, before, after] += 1
        if (count := seen[function, before, after]) > 1:
            after += f"  #{count}"
        found.append(Mutant(file, function, before, after, mutated))
    return found


def compiles(text: str) -> bool:
    """Whether `text` is Python."""
    try:
        compile(text, "mutant", "exec")
    except (SyntaxError, ValueError):
        return False
    return True


Change = tuple[int, int, str, str]  # the text from the first place to the second becomes the third, in this function


def python_changes(text: str) -> Iterator[Change]:
    """The changes of a Python file. Not touched: types, decorators, texts, and what a message is made of."""
    lines = text.encode().split(b"\n")
    starts = [0]
    for line in lines:
        starts.append(starts[-1] + len(line.decode()) + 1)

    def place(line: int, column: int) -> int:
        return starts[line - 1] + len(lines[line - 1][:column].decode())

    def span(node: ast.AST) -> tuple[int, int]:
        return place(node.lineno, node.col_offset), place(node.end_lineno, node.end_col_offset)

    def between(left: ast.AST, right: ast.AST, symbol: str, function: str) -> Iterator[Change]:
        start, end = span(left)[1], span(right)[0]
        pattern = re.escape(symbol).replace(r"\ ", r"\s+")
        if hit := re.search(rf"\b{pattern}\b" if symbol[0].isalpha() else pattern, text[start:end]):
            for new in SWAPS[symbol]:
                yield start + hit.start(), start + hit.end(), new, function

    def own(node: ast.AST, function: str) -> Iterator[Change]:
        match node:
            case ast.Compare():
                for left, operator, right in zip([node.left, *node.comparators], node.ops, node.comparators):
                    yield from between(left, right, SYMBOLS[type(operator)], function)
            case ast.BinOp() if type(node.op) in SYMBOLS:
                yield from between(node.left, node.right, SYMBOLS[type(node.op)], function)
            case ast.BoolOp():
                for left, right in zip(node.values, node.values[1:]):
                    yield from between(left, right, SYMBOLS[type(node.op)], function)
            case ast.UnaryOp(op=ast.Not() | ast.USub()):
                yield span(node)[0], span(node.operand)[0], "", function
            case ast.Constant(value=bool()):
                yield *span(node), str(not node.value), function
            case ast.Constant(value=int()):
                yield *span(node), str(node.value + 1), function
                yield *span(node), str(node.value - 1), function
            case ast.Constant(value=float()):
                yield *span(node), repr(node.value * 1.25 or 1.0), function
            case ast.Call(func=ast.Name(id=name) | ast.Attribute(attr=name)) if name in CALLS:
                end = span(node.func)[1]
                yield end - len(name), end, CALLS[name], function
            case ast.Expr(value=ast.Call()) | ast.AugAssign() | ast.Continue() | ast.Break() | ast.Raise():
                yield *span(node), "pass", function
            case ast.Assign(targets=[ast.Attribute() | ast.Subscript()]):
                yield *span(node), "pass", function
            case ast.Return(value=ast.expr()):
                yield *span(node.value), "None", function
        if isinstance(node, ast.AugAssign) and (symbol := SYMBOLS.get(type(node.op), "") + "=") in SWAPS:
            yield from between(node.target, node.value, symbol, function)
        for test in [node.test] if isinstance(node, ast.If | ast.IfExp | ast.While) else getattr(node, "ifs", []):
            start, end = span(test)
            yield start, end, f"(not ({text[start:end]}))", function

    def walk(node: ast.AST, function: str) -> Iterator[Change]:
        yield from own(node, function)
        for name, field in ast.iter_fields(node):
            if name in ("annotation", "returns", "decorator_list", "exc"):
                continue
            for child in field if isinstance(field, list) else [field]:
                if isinstance(child, ast.JoinedStr) or not isinstance(child, ast.AST):
                    continue
                if isinstance(child, ast.FunctionDef | ast.ClassDef):
                    yield from walk(child, f"{function}.{child.name}".removeprefix("."))
                else:
                    yield from walk(child, function)

    yield from walk(ast.parse(text), "")


SKIPPED = r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\])*"|\'(?:\\.|[^\'\\])*\'|^\#[^\n]*'
C_SYMBOLS = r"&&|\|\||[<>=!]=|[+-]=|(?<=[\w)\]] )[-+*/<>&|%](?= )"
# A statement of its own line; one that begins inside another is found as well.
C_STATEMENT = re.compile(r"(?<=\n)(?=( +)((?!return\b|else\b|const\b|case\b|for\b)[\w>*\[\].()-]+ ?(?:[-+|&]?= |\()"
                         r"[^;{}]*;|(?:break|continue|return);))")
C_TOKEN = re.compile(rf"(?P<skip>{SKIPPED})|(?P<symbol>{C_SYMBOLS})|(?P<not>!(?=[\w(]))"
                     r"|(?P<number>\b\d+\.?\d*(?:e-?\d+)?\b)|(?P<if>\b(?:if|while) \()", re.DOTALL | re.MULTILINE)


def c_changes(text: str) -> Iterator[Change]:
    """The changes of a C file: symbols, numbers, conditions, and statements left out."""
    functions = [(m.start(), m[1]) for m in re.finditer(r"^\w[^;\n=#]*?\b(\w+)\(", text, re.MULTILINE)]
    skipped = [m.span() for m in re.finditer(SKIPPED, text, re.DOTALL | re.MULTILINE)]

    def function(at: int) -> str:
        return next((name for start, name in reversed(functions) if start <= at), "")

    at = 0
    while token := C_TOKEN.search(text, at):
        start, end = token.span()
        at, where = end, function(start)
        match token.lastgroup:
            case "symbol":
                for new in SWAPS[token[0]]:
                    yield start, end, new, where
            case "not":
                yield start, end, "", where
            case "number":
                if token[0].isdigit():  # 1 is mostly a truth
                    yield start, end, str(int(token[0]) + 1) if token[0] != "1" else "0", where
                elif re.fullmatch(r"[\d.]+(e-?\d+)?", token[0]):
                    yield start, end, repr(float(token[0]) * 1.25), where
            case "if":
                yield start, (close := closing(text, end - 1)) + 1, f"{token[0]}!({text[end:close]}))", where
    for statement in C_STATEMENT.finditer(text):
        start, end = statement.span(2)
        whole = statement[2].count("(") == statement[2].count(")")  # not the last line of a longer one
        if whole and not any(a <= start < b for a, b in skipped):
            yield start, end, ";", function(start)


def closing(text: str, opening: int) -> int:
    """Where the parenthesis that opens at `opening` closes."""
    depth = 0
    for at in range(opening, len(text)):
        depth += {"(": 1, ")": -1}.get(text[at], 0)
        if not depth:
            return at
    raise ValueError("a parenthesis is left open")
