"""FMUs that are written in Python share this process's modules: an FMU of stock pythonfmu would be given the modules of
another FMU that have the same names, and fly with that one's code, without a word.

Before such an FMU is instantiated, modules that came out of other FMUs make way where it has files of its own for them
that differ. What flies already keeps the modules that it has imported.
"""
import importlib
import os
import sys
from pathlib import Path

FOLDERS: set[str] = set()  # `resources` of the Python FMUs that were instantiated in this process


def make_way(folder: Path) -> None:
    """Before the FMU that is extracted in `folder` is instantiated."""
    resources = folder.resolve() / "resources"
    if not (resources / "slavemodule.txt").is_file():
        return
    others = tuple(f"{other}{os.sep}" for other in FOLDERS - {str(resources)})
    loaded = {name: getattr(module, "__file__", None) or "" for name, module in list(sys.modules.items())}
    differing = {name.partition(".")[0] for name, file in loaded.items()
                 if file.startswith(others) and differs(name, file, resources)}
    for name in [name for name in sys.modules if name.partition(".")[0] in differing]:
        del sys.modules[name]
    importlib.invalidate_caches()
    FOLDERS.add(str(resources))


def differs(name: str, file: str, resources: Path) -> bool:
    """Whether the folder has the module `name` or its package, and not as it is in `file`."""
    top, *below = name.split(".")
    if not (resources / f"{top}.py").is_file() and not (resources / top).is_dir():
        return False
    path = resources.joinpath(top, *below)
    here = path / "__init__.py" if Path(file).stem == "__init__" else path.with_name(path.name + Path(file).suffix)
    try:
        return here.read_bytes() != Path(file).read_bytes()
    except OSError:
        return True
