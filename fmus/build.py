"""Builds the FMU files: every model, every flavour."""
from importlib import import_module
from importlib.metadata import version
from pathlib import Path

from . import documentation, native_flavour, pack, python_flavour
from .description import model_description, parameter_set
from .trace import trace

DIST = Path(__file__).parent / "dist"

# Adding a model: name its module here.
MODELS = {
    "AhvPlant": "ahv_plant_fmu.model",
    "AhvInstrumentedPlant": "ahv_plant_fmu.instrumented_model",
    "AhvController": "ahv_ctrl_fmu.neural_model",
    "AhvBackstepping": "ahv_ctrl_fmu.backstepping_model",
    "AhvResilient": "ahv_ctrl_fmu.resilient_model",
    "AhvScenario": "cosim.vehicle.scenario_model",
}
FLAVOURS = {"python": python_flavour, "native": native_flavour}


def build(name: str, flavour: str, dist: Path = DIST, arm: bool = False) -> Path:
    """Write `dist`/`flavour`/`name`.fmu and return its path. The same sources give the same bytes.

    `arm` adds binaries for Arm processors where the flavour has them.
    """
    model = import_module(MODELS[name])
    maker = FLAVOURS[flavour]
    traced = trace(model)
    files = maker.files(model, traced)
    files["documentation/index.html"] = documentation.page(model, traced)
    files["model.png"] = documentation.icon(model)
    for preset, values in model.PRESETS.items():
        files[f"resources/presets/{preset}.ssv"] = parameter_set(preset, values)

    def describe(guid: str) -> bytes:
        return model_description(model, traced, maker.FLAVOUR, guid, version("ahv"))

    files["modelDescription.xml"] = describe("")
    guid = "{" + pack.digest(files)[:32] + "}"
    files["modelDescription.xml"] = describe(guid)
    files.update(maker.binaries(model, files, guid, arm))
    path = dist / flavour / f"{name}.fmu"
    pack.write(path, files)
    return path


def build_all(flavours: list[str], arm: bool = False) -> list[Path]:
    return [build(name, flavour, arm=arm) for flavour in flavours for name in MODELS]
