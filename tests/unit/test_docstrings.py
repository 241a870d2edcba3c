"""Every public module, class, function and method of the packages has a docstring.

Exempt are names with a leading underscore, functions inside functions, `__init__` and its like (the class is
documented), rules registered by `@static` (their summary is an argument), validators of pydantic models (their
messages say what they check), and methods that override or implement a documented one of a base class.
"""
import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
ROOMS = ["cosim", "fmus", "ahv_plant_fmu", "ahv_ctrl_fmu"]
DECORATORS = {"static", "field_validator", "model_validator"}
Function = ast.FunctionDef | ast.AsyncFunctionDef


def files(room: str) -> list[Path]:
    path = ROOT / room
    return [path] if path.suffix else sorted(path.rglob("*.py"))


def word(node: ast.expr) -> str:
    """The last name in `a.b[c](d)` without what is in brackets."""
    while isinstance(node, ast.Call | ast.Subscript):
        node = node.func if isinstance(node, ast.Call) else node.value
    return node.attr if isinstance(node, ast.Attribute) else getattr(node, "id", "")


def classes() -> dict[str, tuple[list[str], set[str]]]:
    """Class -> (its bases, its methods that have a docstring), of all rooms."""
    nodes = [node for package in ("cosim", "fmus", "ahv_plant_fmu", "ahv_ctrl_fmu") for path in files(package)
             for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.ClassDef)]
    return {node.name: ([word(base) for base in node.bases],
                        {item.name for item in node.body if isinstance(item, Function) and ast.get_docstring(item)})
            for node in nodes}


CLASSES = classes()


def documented_in_base(name: str, bases: list[str]) -> bool:
    known = [CLASSES[base] for base in bases if base in CLASSES]
    return any(name in methods or documented_in_base(name, further) for further, methods in known)


def undocumented(tree: ast.Module) -> list[str]:
    found = [] if ast.get_docstring(tree) else ["the module"]
    for node in tree.body:
        owners = [(None, node)]
        if isinstance(node, ast.ClassDef):
            owners += [(node, item) for item in node.body]
        for owner, item in owners:
            if not isinstance(item, Function | ast.ClassDef) or item.name.startswith("_") or ast.get_docstring(item):
                continue
            if DECORATORS & {word(d) for d in item.decorator_list} or (
                    owner and documented_in_base(item.name, [word(base) for base in owner.bases])):
                continue
            found.append(f"{owner.name}.{item.name}" if owner else item.name)
    return found


@pytest.mark.parametrize("room", ROOMS)
def test_what_is_public_is_documented(room):
    missing = {str(path.relative_to(ROOT)): undocumented(ast.parse(path.read_text()))
               for path in files(room)}
    assert missing and {path: names for path, names in missing.items() if names} == {}


def test_the_search_finds_what_is_missing():
    tree = ast.parse('"""Module."""\nclass A:\n    """Class."""\n    def b(self): pass\ndef c(): pass\ndef _d(): pass')
    assert undocumented(tree) == ["A.b", "c"]
