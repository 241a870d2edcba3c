"""Builds the FMU file of a model, in one flavour."""
from importlib.metadata import distribution, version
from pathlib import Path
from types import ModuleType

from . import documentation, native_flavour, pack, python_flavour
from .check_model import checked_trace
from .description import model_description, parameter_set
from .load_model import loaded

DIST = Path(__file__).parent / "dist"

FLAVOURS = {"python": python_flavour, "native": native_flavour}


def build(model: ModuleType | Path | str, flavour: str = "native", dist: Path | str = DIST, arm: bool = False) -> Path:
    """Write `dist`/`flavour`/NAME.fmu and return its path. The same sources give the same
    bytes with the same versions of what makes the FMU, which `generationTool` names.

    `model` is a module as `fmus.interface` describes it, its file (a Path, or text that ends in .py), or its dotted
    name; `flavour` is native or python. `arm` adds binaries for Arm processors where the flavour has them.

    Raises ModelError (`fmus.check_model`) for a mistake in the model, and RuntimeError where the C compiler is missing
    or fails.
    """
    with loaded(model) as module:
        return build_module(module, flavour, Path(dist), arm)


def build_module(model: ModuleType, flavour: str, dist: Path, arm: bool) -> Path:
    """As `build`, of a model that is loaded. Raises as `build` does."""
    maker = FLAVOURS[flavour]
    trace = checked_trace(model)
    files = maker.files(model, trace)
    files["documentation/index.html"] = documentation.page(model, trace)
    files["documentation/licenses/license.txt"] = licence()
    files["model.png"] = documentation.icon(model)
    for preset, values in model.PRESETS.items():
        files[f"resources/presets/{preset}.ssv"] = parameter_set(preset, values)

    made_with = {"ahv": version("ahv"), "casadi": version("casadi"), **maker.versions()}
    tool = ", ".join(f"{name} {number}" for name, number in made_with.items())

    def describe(guid: str) -> bytes:
        return model_description(model, trace, maker.FLAVOUR, guid, version("ahv"), tool)

    files["modelDescription.xml"] = describe("")
    guid = "{" + pack.digest(files)[:32] + "}"
    files["modelDescription.xml"] = describe(guid)
    files.update(maker.binaries(model, files, guid, arm))
    path = dist / flavour / f"{model.NAME}.fmu"
    pack.write(path, files)
    return path


def licence() -> bytes:
    """Our licence: the file beside the sources, or, in an installed package, the one in its metadata."""
    file = Path(__file__).parents[1] / "LICENSE"
    return file.read_bytes() if file.is_file() else (distribution("ahv").read_text("licenses/LICENSE") or "").encode()
