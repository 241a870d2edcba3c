"""A model as a pythonfmu FMU: its sources, a generic slave, pythonfmu's binaries."""
import re
from importlib.metadata import distribution, version
from pathlib import Path
from types import ModuleType

import pythonfmu

from .description import Flavour
from .model_files import model_files
from .pack import digest
from .trace import Trace

HERE = Path(__file__).parent
PYTHONFMU = Path(pythonfmu.__file__).parent
CAPABILITIES = {
    "needsExecutionTool": "true", "canGetAndSetFMUstate": "true", "canSerializeFMUstate": "true",
    "canNotUseMemoryManagementFunctions": "true",
}
FLAVOUR = Flavour(CAPABILITIES)
RUNTIME = ("slave.py", "refusal.py", "interface.py", "units.py", "integrators.py", "functions.py", "lookup.py",
           "floats.py")

# pythonfmu's loader runs this text once more for every instance, and each time drops one reference too many
# of the module's globals; a module without functions of its own would lose them at once, any other in time.
SLAVE = """\
import ctypes

from {package}.fmus.slave import ModelSlave
from {package}{where} import {module} as the_model

ctypes.pythonapi.Py_IncRef(ctypes.py_object(globals()))


class {name}(ModelSlave):
    model = the_model
"""


def own_names(source: str, package: str, tops: set[str]) -> str:
    """`source` with its absolute imports from `tops`, the first words of the files' names, moved below `package`."""
    return re.sub(rf"^(\s*from )({'|'.join(sorted(tops))})\b", rf"\1{package}.\2", source, flags=re.MULTILINE)


def resources(model: ModuleType) -> dict[str, bytes]:
    """Everything below resources/ of the FMU: path -> content. Raises ModelError as `model_files` does.

    All FMUs of a process share sys.modules, so each build's modules live in a package whose name carries
    a hash of their content: two different builds never run each other's code.
    """
    own = model_files(model, travelling=True)
    sources = dict(sorted(own.items())) | {f"{HERE.name}/{name}": HERE / name for name in RUNTIME}
    texts = {name: path.read_text(encoding="utf-8") for name, path in sources.items()}
    package = f"{model.NAME}_{digest({name: text.encode() for name, text in texts.items()})[:12]}"
    tops = {name.split("/")[0].removesuffix(".py") for name in texts}

    files = {f"{package}/{name}": own_names(text, package, tops) for name, text in texts.items()}
    for name in list(files):
        for parent in list(Path(name).parents)[:-1]:
            files.setdefault(f"{parent.as_posix()}/__init__.py", "")
    where, _, module = f".{model.__name__}".rpartition(".")
    files[f"{package}_slave.py"] = SLAVE.format(package=package, where=where, module=module, name=model.NAME)
    files["slavemodule.txt"] = f"{package}_slave\n"
    for source in PYTHONFMU.glob("*.py"):
        files[f"pythonfmu/{source.name}"] = source.read_text()
    return {f"resources/{name}": text.encode() for name, text in files.items()}


def versions() -> dict[str, str]:
    """What decides on the FMU's bytes beside CasADi."""
    return {"pythonfmu": version("pythonfmu")}


def files(model: ModuleType, trace: Trace) -> dict[str, bytes]:
    """What the FMU is made of, but for its binaries; with the licence of what it carries of pythonfmu.

    Raises ModelError as `model_files` does.
    """
    licence = distribution("pythonfmu").read_text("licenses/LICENSE") or ""
    return {**resources(model), "documentation/licenses/pythonfmu.txt": licence.encode()}


def binaries(model: ModuleType, contents: dict[str, bytes], token: str, fmi: str) -> dict[str, bytes]:
    """pythonfmu's, the same for every model; it has none for Arm."""
    folder = PYTHONFMU / "resources" / "binaries"
    return {f"binaries/{path.parent.name}/{model.NAME}{path.suffix}": path.read_bytes()
            for path in folder.rglob("*") if path.suffix in (".so", ".dll", ".dylib")}
