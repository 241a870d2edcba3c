"""Where in a model's files something is written: text such as "tank.py, line 9", or "" where that cannot be told."""
import ast
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

from .mistakes import ModelError
from .model_files import model_files


def file_place(model: ModuleType) -> str:
    """The name of the model's file."""
    return Path(model.__file__).name if model.__file__ else ""


def function_place(function: Any) -> str:
    """Where a function begins."""
    code = getattr(function, "__code__", None)
    return f"{Path(code.co_filename).name}, line {code.co_firstlineno}" if code else ""


def parsed(model: ModuleType) -> Iterator[tuple[str, ast.Module]]:
    """The names and the syntax trees of the model's file and of those it imports, nearest first."""
    try:
        files = list(model_files(model).values())
    except (ModelError, SyntaxError, UnicodeDecodeError):  # another mistake, which is told in its turn
        return
    for file in files:
        yield file.name, ast.parse(file.read_text(encoding="utf-8"))


def row_place(model: ModuleType, table: str, i: int, row: Any) -> str:
    """Where row i of a table (VARIABLES, STATES) is written: as the i-th entry of the list in the model's file, else as
    the first tuple of the model's files with the row's constants, else as the first that begins with its name."""
    trees = list(parsed(model))
    for name, tree in trees[:1]:
        for node in tree.body:
            if not (isinstance(node, ast.Assign) and isinstance(node.value, ast.List)):
                continue
            written = node.value.elts[:i + 1]
            plain = len(written) == i + 1 and not any(isinstance(entry, ast.Starred) for entry in written)
            if ast.unparse(node.targets[0]) == table and plain:
                return f"{name}, line {written[i].lineno}"
    if not isinstance(row, (tuple, list)) or not row:
        return ""
    for alike in (same_constants, same_name):
        for name, tree in trees:
            for entry in ast.walk(tree):
                if isinstance(entry, ast.Tuple) and entry.elts and alike(entry, row):
                    return f"{name}, line {entry.lineno}"
    return ""


def same_constants(node: ast.Tuple, row: Any) -> bool:
    """Whether a tuple in a file can be `row`: of its length, with its name and every other constant."""
    return len(node.elts) == len(row) and same_name(node, row) and all(
        entry.value == value for entry, value in zip(node.elts, row) if isinstance(entry, ast.Constant))


def same_name(node: ast.Tuple, row: Any) -> bool:
    """Whether a tuple in a file begins as `row` does."""
    return isinstance(node.elts[0], ast.Constant) and node.elts[0].value == row[0]


def key_place(model: ModuleType, key: object) -> str:
    """Where the first dict with this key is written: the key's line."""
    for name, tree in parsed(model):
        for node in ast.walk(tree):
            for written in node.keys if isinstance(node, ast.Dict) else []:
                if isinstance(written, ast.Constant) and written.value == key:
                    return f"{name}, line {written.lineno}"
    return ""
