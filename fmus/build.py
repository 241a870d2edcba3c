"""Builds the FMU files: every model, every flavour."""
from importlib import import_module
from importlib.metadata import version
from pathlib import Path

from . import archive, native_flavour, python_flavour
from .description import model_description, parameter_set
from .trace import trace

DIST = Path(__file__).parent / "dist"

# Adding a model: name its module here.
MODELS = {
    "AhvPlant": "ahv_plant_fmu.model",
    "AhvController": "ahv_ctrl_fmu.neural_model",
    "AhvScenario": "cosim.scenario.model",
}
FLAVOURS = {"python": python_flavour, "native": native_flavour}


def build(name: str, flavour: str, dist: Path = DIST) -> Path:
    """Write `dist`/`flavour`/`name`.fmu and return its path. The same sources give the same bytes."""
    model = import_module(MODELS[name])
    maker = FLAVOURS[flavour]
    traced = trace(model)
    files = maker.files(model, traced)
    for preset, values in model.PRESETS.items():
        files[f"resources/presets/{preset}.ssv"] = parameter_set(preset, values)

    def describe(guid: str) -> bytes:
        return model_description(model, traced, maker.FLAVOUR, guid, version("ahv"))

    files["modelDescription.xml"] = describe("")
    guid = "{" + archive.digest(files)[:32] + "}"
    files["modelDescription.xml"] = describe(guid)
    files.update(maker.binaries(model, files, guid))
    path = dist / flavour / f"{name}.fmu"
    archive.write(path, files)
    return path


def build_all(flavours: list[str]) -> list[Path]:
    return [build(name, flavour) for flavour in flavours for name in MODELS]
