"""The shared library of an FMU: loaded from its folder, its functions looked up when they are needed."""
import ctypes
import os
from pathlib import Path
from typing import Any

import fmpy


class Library:
    """A loaded library. Only what is called has to be in it."""

    def __init__(self, path: Path):
        """Load `path`, from its own folder, where some libraries look for what they need.

        Raises OSError if there is no such file, or if it cannot be loaded.
        """
        if not path.is_file():
            raise OSError(f"Cannot find shared library {path}.")
        before = os.getcwd()
        os.chdir(path.parent)
        try:
            self.dll = ctypes.cdll.LoadLibrary(str(path))
        except OSError as error:
            raise OSError(f"Failed to load shared library {path}. {error}") from None
        finally:
            os.chdir(before)

    def has(self, name: str) -> bool:
        """Whether there is a function called `name`."""
        return hasattr(self.dll, name)

    def function(self, name: str, result: Any, *argument_types: Any) -> Any:
        """The C function called `name`. Raises AttributeError if there is none."""
        function = self.dll[name]
        function.argtypes, function.restype = argument_types, result
        return function

    def address(self, name: str) -> int:
        """Where the function called `name` is. Raises AttributeError if there is none."""
        return ctypes.cast(self.dll[name], ctypes.c_void_p).value or 0

    def free(self) -> None:
        """Unload it."""
        fmpy.freeLibrary(self.dll._handle)
