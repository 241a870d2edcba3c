"""What commands say that take systems as well as scenarios."""
from ..errors import UsageError


def for_scenarios_only(file: str, kind: str, controller: str, preset: str | None, flavour: str | None, plant: str,
                       uncertainty: float | None) -> None:
    """Raises UsageError for options that choose the parts of a scenario's loop: `file` is of another `kind`."""
    if (controller, preset, flavour, plant, uncertainty) != ("neural", None, None, "ideal", None):
        raise UsageError(f"--controller, --preset, --flavour, --plant and --uncertainty are for scenarios; "
                         f"{file} is {kind}.")
