"""`ahv build`."""
import sys
from pathlib import Path
from typing import Annotated

import typer

from ..errors import UsageError
from ..vehicle.closed_loop import choice
from ..vehicle.registry import MODELS
from .options import place


def build(
    models: Annotated[list[str] | None, typer.Argument(
        metavar="[MODEL]...", show_default=False,
        help=f"{', '.join(MODELS)}; a model's file, such as my_model.py; or a module, such as my_package.my_model. "
             "Without any, all that have names.")] = None,
    flavour: Annotated[str, typer.Option(help="python, native or all.")] = "all",
    fmi: Annotated[str, typer.Option(help="Version of FMI: 2, 3 or all. The Python flavour has 2 only.")] = "all",
    out: Annotated[Path | None, typer.Option(
        metavar="DIR", parser=place, show_default=False,
        help="Folder that gets FLAVOUR/NAME.fmu and native-fmi3/NAME.fmu, instead of fmus/dist.")] = None,
    arm: Annotated[bool, typer.Option("--arm", hidden=True)] = False,  # all FMUs have binaries for Arm by now
    wasm: Annotated[bool, typer.Option("--wasm", help="Also WebAssembly of the native flavour: a module in wasm/, and "
                                       "a component in the FMU of FMI 3.0 (docs/wasm.md).")] = False,
) -> None:
    """Write FMU files, of the models of this project or of your own (docs/building.md)."""
    from fmus.builder import FLAVOURS, versions
    from fmus.builder import build as build_one
    from fmus.check_model import ModelError
    from fmus.places import written
    from fmus.wasm import add

    chosen = [model_source(name) for name in models or MODELS]
    choice("fmi", fmi, ("2", "3", "all"))
    kinds = FLAVOURS if flavour == "all" else [choice("flavour", flavour, [*FLAVOURS, "all"])]
    wanted = [(kind, version) for kind in kinds for version in versions(kind) if fmi in (version, "all")]
    if not wanted:
        raise UsageError(f"--fmi {fmi} has no FMU of the flavour {flavour}, which is for FMI {versions(flavour)[0]}.")
    if wasm and "native" not in kinds:
        raise UsageError(f"--wasm is for the native flavour, not for {flavour}.")
    try:
        for kind, version in wanted:
            for model in chosen:
                path = build_one(model, kind, out, version)
                if wasm and kind == "native":
                    add(path, version)
                print(path, file=sys.stderr)
    except ModelError as error:
        raise UsageError(str(error)) from None
    except OSError as error:
        raise UsageError(f"{error.filename or out or written()} cannot be written: {error.strerror}.") from None


def model_source(name: str) -> str:
    """The module or file of the model `name`. Raises UsageError for a word that can be neither."""
    if name in MODELS:
        return MODELS[name]
    if name.endswith(".py") or ("." in name and all(map(str.isidentifier, name.split(".")))):
        return name
    raise UsageError(f"There is no model {name}; there are {', '.join(MODELS)}; a model of your own is a file, such as "
                     "my_model.py, or a module, such as my_package.my_model.")
