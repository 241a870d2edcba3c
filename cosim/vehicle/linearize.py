"""The vehicle under a control law about level flight: poles, zeros, margins.

Our own laws on our own vehicle are linearised exactly, from their models. With anybody's FMU in the loop, what flies is
linearised from its files (`analysis`), and so is a law that learns on a scaled vehicle: what it has learned when it is
at rest depends on the flight there.
"""
from importlib import import_module
from math import degrees
from typing import Any

from ..errors import RunError, UsageError
from . import scenarios
from .closed_loop import LINKS, Values, closed_loop, merged
from .registry import LAWS, PLANTS

ACTUATORS, SENSORS, COMMANDS = (
    [f"{source}.{name}" for source, target, name in LINKS if (source, target) == ends]
    for ends in (("controller", "plant"), ("plant", "controller"), ("scenario", "controller")))
GROUPS = ("thrust", "lift", "drag", "moment", "forces")


def linearize(controller: str = "neural", preset: str | None = None, plant: str = "ideal", V: float = 7700.0,
              h: float = 85000.0, scale: float = 1.0, step: float = 0.01, values: Values | None = None
              ) -> dict[str, Any]:
    """Matrices, poles and zeros of the vehicle alone and of the closed loop, and margins at each actuator and sensor.

    About level flight at `V` (ft/s), `h` (ft), every coefficient group times `scale`; the loop is sampled every `step`
    seconds. `controller` and `plant` are words of the registry, or anybody's FMUs as NAME=FILE.fmu; `values` are
    parameters of both. Raises UsageError for what is not known, RunError if there is no such flight.
    """
    if controller in LAWS and plant == "ideal" and not (LAWS[controller].learns and scale != 1):
        return from_models(controller, preset or LAWS[controller].preset or "", V, h, scale, step, values or {})
    return from_files(controller, preset, plant, V, h, scale, step, values or {})


def from_models(controller: str, preset: str, V: float, h: float, scale: float, step: float, values: Values
                ) -> dict[str, Any]:
    """Exactly, through the Jacobians of the equations of law and vehicle. Raises as `linearize` does."""
    from fmus.linear_report import linear_report, preset_gains
    from fmus.linearize import NoTrim

    from ..analysis.margins import margins_at

    law, plant = import_module(LAWS[controller].module), import_module(PLANTS["ideal"].module)
    given = {name: {k: float(v) for k, v in pairs.items()} for name, pairs in values.items()}
    try:
        gains = preset_gains(law, preset)
        found = linear_report(plant, law, {**gains, **given.get("controller", {})}, V, h, step,
                              dict.fromkeys(GROUPS, scale), given.get("plant", {}), margins_at)
    except KeyError:
        raise UsageError(f"The {controller} controller has no preset {preset}.") from None
    except NoTrim as error:
        raise RunError(str(error)) from None
    except ValueError as error:
        raise UsageError(str(error)) from None
    return {"controller": controller, "preset": preset, **found}


def from_files(controller: str, preset: str | None, plant: str, V: float, h: float, scale: float, step: float,
               values: Values) -> dict[str, Any]:
    """From the FMU files, by their answers to pulses about the flight that they settle to. Raises as `linearize`."""
    from ..analysis import linearize as linearize_files

    start: Values = {"plant": {"V_start": V, "h_start": h}} if plant in PLANTS else {}
    commanded: Values = {"scenario": {"V_command_base": V, "h_command_base": h,
                                      **{f"scale_{group}_base": scale for group in GROUPS}}}
    loop = closed_loop(scenarios.load("hold"), controller, plant, presets={"controller": preset} if preset else {},
                       values=merged(commanded, start, values))
    there = {link.source for link in loop.system.connections}
    found = linearize_files(loop.system, ACTUATORS, [s for s in SENSORS if s in there], step,
                            commands=[c for c in COMMANDS if c in there])
    rest = found["equilibrium"]
    return {"controller": loop.controller, "preset": loop.preset, "plant": loop.plant, "V_fps": V, "h_ft": h,
            "scale": dict.fromkeys(GROUPS, scale), "fuel_ratio": rest["controller.fuel_ratio"],
            "elevator_deg": degrees(rest["controller.elevator"]),
            **({"theta_deg": degrees(rest["plant.theta"])} if "plant.theta" in rest else {}),
            **({"altitude_offset_ft": rest["plant.h"] - h} if "plant.h" in rest else {}),
            "open_loop": found["open_loop"], "closed_loop": found["closed_loop"], "margins": found["margins"]}
