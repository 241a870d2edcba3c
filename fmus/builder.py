"""Builds the FMU file of a model, in one flavour and for one version of FMI."""
from importlib.metadata import distribution, version
from pathlib import Path
from types import ModuleType

from . import description, description3, documentation, experiments, native_flavour, pack, places, python_flavour
from .check_model import checked_trace
from .load_model import loaded

FLAVOURS = {"python": python_flavour, "native": native_flavour}
DESCRIBE = {"2": description.model_description, "3": description3.model_description}  # FMI version -> its description


def versions(flavour: str) -> list[str]:
    """The FMI versions that a flavour is built for."""
    return [fmi for fmi in DESCRIBE if fmi in FLAVOURS[flavour].FLAVOUR.versions]


def folder(flavour: str, fmi: str = "2") -> str:
    """The name of the folder of a flavour's FMUs, for FMI 2.0 that of the flavour."""
    return flavour if fmi == "2" else f"{flavour}-fmi{fmi}"


def build(model: ModuleType | Path | str, flavour: str = "native", dist: Path | str | None = None, fmi: str = "2"
          ) -> Path:
    """Write `dist`/FOLDER/NAME.fmu, an FMU of FMI `fmi` (one of `versions`), and return its path. The same sources give
    the same bytes with the same versions of what makes the FMU, which `generationTool` names.

    `model` is a module as `fmus.interface` describes it, its file (a Path, or text that ends in .py), or its dotted
    name; `flavour` is native or python; without `dist` it is the folder that `places.written` names.

    Raises ModelError (`fmus.check_model`) for a mistake in the model, and RuntimeError where the C compiler is missing
    or fails.
    """
    with loaded(model) as module:
        return build_module(module, flavour, Path(dist or places.written()), fmi)


def build_module(model: ModuleType, flavour: str, dist: Path, fmi: str) -> Path:
    """As `build`, of a model that is loaded. Raises as `build` does."""
    maker = FLAVOURS[flavour]
    trace = checked_trace(model)
    code = maker.files(model, trace)
    files = {**code, "documentation/index.html": documentation.page(model, trace),
             "documentation/licenses/license.txt": licence()}
    for preset, values in model.PRESETS.items():
        files[f"resources/presets/{preset}.ssv"] = description.parameter_set(preset, values)

    made_with = {"ahv": version("ahv"), "casadi": version("casadi"), **maker.versions()}
    tool = ", ".join(f"{name} {number}" for name, number in made_with.items())

    def describe(fmi: str, token: str) -> bytes:
        return DESCRIBE[fmi](model, trace, maker.FLAVOUR, token, version("ahv"), tool)

    # One token for the FMUs of all versions, so that one library serves them.
    token = "{" + pack.digest({**files, **{each: describe(each, "") for each in versions(flavour)}})[:32] + "}"
    files["modelDescription.xml"] = describe(fmi, token)
    files.update(maker.binaries(model, code, token, fmi))
    files.update(experiments.files(model))  # no part of the token: extra/ may change without making another FMU
    icon = documentation.icon(model)
    if fmi == "2":
        files["model.png"] = icon
    else:
        files["terminalsAndIcons/icon.png"] = icon
        files["terminalsAndIcons/terminalsAndIcons.xml"] = description3.terminals(model)
        files["sources/buildDescription.xml"] = description3.build_description(model, maker.FLAVOUR)
    path = dist / folder(flavour, fmi) / f"{model.NAME}.fmu"
    pack.write(path, files)
    return path


def licence() -> bytes:
    """Our licence: the file beside the sources, or, in an installed package, the one in its metadata."""
    file = Path(__file__).parents[1] / "LICENSE"
    return file.read_bytes() if file.is_file() else (distribution("ahv").read_text("licenses/LICENSE") or "").encode()
