"""The source files that a model is made of, wherever they lie."""
import ast
import sys
from pathlib import Path
from types import ModuleType

from .mistakes import ModelError


def model_root(model: ModuleType) -> Path:
    """The folder that `model`'s dotted name begins in. Raises ModelError for a model that is in no file."""
    if not model.__file__:
        raise ModelError(model, "the model is in no file; an FMU carries the file of its model")
    return Path(model.__file__).parents[model.__name__.count(".")]


def model_files(model: ModuleType, travelling: bool = False) -> dict[str, Path]:
    """`model`'s file and those below its root folder that it imports, directly or not, nearest first: relative name
    (such as ahv_ctrl_fmu/neural.py) -> file.

    Raises ModelError where a file is imported as `import NAME`: in an FMU the files lie in a package of their own,
    where only `from ... import ...` finds them. With `travelling`, the files must be all that the model needs: raises
    ModelError also for what is imported and is neither one of them nor in Python's standard library.
    """
    root = model_root(model)
    found: dict[str, Path] = {}
    waiting = [Path(str(model.__file__))]
    while waiting:
        file = waiting.pop(0)
        if file in found.values() or not file.is_file():
            continue
        found[file.relative_to(root).as_posix()] = file
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom):
                base = file.parents[node.level - 1] if node.level else root
                place = base.joinpath(*(node.module or "").split("."))
                if travelling:
                    check_travels(model, file, node, place)
                waiting += [place.with_suffix(".py"), *(place / f"{alias.name}.py" for alias in node.names)]
            elif isinstance(node, ast.Import):
                for alias in node.names:
                    if root.joinpath(*alias.name.split(".")).with_suffix(".py").is_file():
                        raise ModelError(model, f"{file.name}, line {node.lineno}, imports {alias.name}, a file of the "
                                                f"model, as a whole; write from {alias.name} import NAME")
                    if travelling and alias.name.split(".")[0] not in sys.stdlib_module_names:
                        raise ModelError(model, not_travelling(file, node, alias.name))
    return found


def check_travels(model: ModuleType, file: Path, node: ast.ImportFrom, place: Path) -> None:
    """Raises ModelError where what `node` imports, from the file or folder at `place`, is in no file that travels."""
    if not node.level and (node.module or "").split(".")[0] in sys.stdlib_module_names:
        return
    if place.with_suffix(".py").is_file():
        return
    for alias in node.names:
        if not (place / f"{alias.name}.py").is_file():
            raise ModelError(model, not_travelling(file, node, f"{'.' * node.level}{node.module or ''}", alias.name))


def not_travelling(file: Path, node: ast.stmt, module: str, name: str = "") -> str:
    """What is said of an import that does not travel."""
    what = f"{name} from {module}" if name else module
    return (f"{file.name}, line {node.lineno}, imports {what}, which would not travel in the FMU; a model imports its "
            "own files, but no __init__.py, and Python's standard library; the native flavour alone may import others")
