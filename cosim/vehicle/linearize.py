"""The vehicle under a control law about level flight: poles, zeros, margins."""
from importlib import import_module
from typing import Any

from ..errors import RunError, UsageError
from .closed_loop import Values
from .registry import LAWS, PLANTS


def linearize(controller: str = "neural", preset: str | None = None, V: float = 7700.0, h: float = 85000.0,
              scale: float = 1.0, step: float = 0.01, values: Values | None = None) -> dict[str, Any]:
    """Matrices, poles and zeros of the vehicle alone and of the closed loop, and margins at each actuator and sensor.

    About level flight at `V` (ft/s), `h` (ft), every coefficient group times `scale`; the loop is sampled every `step`
    seconds. `values` are parameters of controller and plant. Raises UsageError for what is not known, RunError if
    there is no such flight.
    """
    from fmus.linear_report import linear_report, preset_gains
    from fmus.linearize import GROUPS, NoTrim

    if controller not in LAWS:
        raise UsageError(f"--controller {controller} is not known; there are {', '.join(LAWS)}.")
    preset = preset or LAWS[controller].preset or ""
    law, plant = import_module(LAWS[controller].module), import_module(PLANTS["ideal"].module)
    given = {name: {k: float(v) for k, v in pairs.items()} for name, pairs in (values or {}).items()}
    try:
        gains = preset_gains(law, preset)
        found = linear_report(plant, law, {**gains, **given.get("controller", {})}, V, h, step,
                              dict.fromkeys(GROUPS, scale), given.get("plant", {}))
    except KeyError:
        raise UsageError(f"The {controller} controller has no preset {preset}.") from None
    except NoTrim as error:
        raise RunError(str(error)) from None
    except ValueError as error:
        raise UsageError(str(error)) from None
    return {"controller": controller, "preset": preset, **found}
