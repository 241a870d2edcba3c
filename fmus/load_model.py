"""A model as a module: from a file, a dotted name, or as it is."""
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from importlib.util import module_from_spec, spec_from_file_location
from os.path import isfile
from pathlib import Path
from types import ModuleType, SimpleNamespace

from .check_model import ModelError, failure


@contextmanager
def loaded(model: ModuleType | Path | str) -> Iterator[ModuleType]:
    """The module of `model`: a file (a Path, or text that ends in .py), a dotted name that is found from the current
    folder too, or a module.

    While this lasts, the model's own files can be imported; afterwards none of a file's modules stays loaded, so that
    another model may have files of the same names. Raises ModelError where there is no such model, or where its code
    fails.
    """
    if isinstance(model, ModuleType):
        yield model
        return
    before, path = dict(sys.modules), list(sys.path)
    file = Path(model) if isinstance(model, Path) or model.endswith(".py") else None
    sys.path.insert(0, str(root_of(file) if file else Path.cwd()))
    try:
        yield from_file(file) if file else from_name(str(model))
    finally:
        sys.path[:] = path
        if file:
            forget(root_of(file), before)


def root_of(file: Path) -> Path:
    """The folder from which `file` is imported: the nearest above it that is no package."""
    folder = file.absolute().parent
    while isfile(folder / "__init__.py"):
        folder = folder.parent
    return folder


def from_file(file: Path) -> ModuleType:
    """The module in `file`, run. Raises ModelError where there is none, or where it fails."""
    file = file.absolute()
    *packages, name = file.relative_to(root_of(file)).with_suffix("").parts
    module = ModuleType(name)
    if not isfile(file):
        raise ModelError(module, f"there is no file {file.name} in {file.parent}")
    try:
        if packages:
            import_module(".".join(packages))
        spec = spec_from_file_location(".".join([*packages, name]), file)
        if spec is None or spec.loader is None:
            raise ImportError(f"{file.name} is no Python file")
        module = sys.modules[spec.name] = module_from_spec(spec)
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        module.__file__ = str(file)
        raise ModelError(module, failure(error, module, SimpleNamespace(), SimpleNamespace())) from error
    return module


def from_name(name: str) -> ModuleType:
    """The module of this dotted name. Raises ModelError where there is none, or where it fails."""
    try:
        return import_module(name)
    except (Exception, SystemExit) as error:
        stub = ModuleType(name)
        if isinstance(error, ModuleNotFoundError) and error.name and f"{name}.".startswith(f"{error.name}."):
            raise ModelError(stub, f"there is no module {error.name}, neither in {Path.cwd()} nor installed") from None
        stub.__file__ = ""
        raise ModelError(stub, failure(error, stub, SimpleNamespace(), SimpleNamespace())) from error


def forget(root: Path, before: dict[str, ModuleType]) -> None:
    """Take from sys.modules what came from below `root` since it was `before`, and put back what it replaced."""
    for name, module in list(sys.modules.items()):
        origin = getattr(module, "__file__", None)
        if before.get(name) is not module and origin and Path(origin).is_relative_to(root):
            del sys.modules[name]
            if name in before:
                sys.modules[name] = before[name]
