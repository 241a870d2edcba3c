"""Turns a model (equations and a table) into an FMU file.

    import fmus

    fmus.build("my_model.py", "native", "out")     # a file, a dotted name or a module; writes out/native/MyModel.fmu

`fmus.interface` says what a model is, docs/building.md how to write one. Names are imported when they are first used.
"""
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .builder import build as build
    from .check_model import ModelError as ModelError

WHERE = {"build": "builder", "ModelError": "check_model"}


def __getattr__(name: str) -> Any:
    if name not in WHERE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = found = getattr(import_module(f".{WHERE[name]}", __name__), name)
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *WHERE})
