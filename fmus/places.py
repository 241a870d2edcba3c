"""Where built FMUs are: in a checkout fmus/dist; else those that came with the package, and the user's cache folder."""
from importlib.metadata import version
from pathlib import Path

from platformdirs import user_cache_path

CARRIED = Path(__file__).parent / "dist"  # in a wheel: its FMUs, never written to
# Not pyproject.toml, which some packages install beside themselves.
CHECKOUT = (Path(__file__).parents[1] / "requirements" / "flying.txt").is_file()


def written() -> Path:
    """Where builds are written to: fmus/dist of the checkout, else the user's cache folder for this version."""
    return CARRIED if CHECKOUT else user_cache_path("ahv", appauthor=False, version=version("ahv"))


def found(folder: str, name: str) -> Path:
    """Where NAME.fmu of `folder` (such as native) is: the one that came with the package, else the one that was or
    would be built."""
    carried, built = (place / folder / f"{name}.fmu" for place in (CARRIED, written()))
    return carried if carried.is_file() else built
