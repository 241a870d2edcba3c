"""The vehicle under a control law about level flight: poles, zeros, margins.

Our own laws on our own vehicle are linearised exactly, from their models. With anybody's FMU in the loop, what flies is
linearised from its files (`analysis`), and so is a law that learns on a scaled vehicle: what it has learned when it is
at rest depends on the flight there.
"""
from importlib import import_module
from math import degrees
from typing import Any

from ..errors import RunError, UsageError
from ..master.system import Component, Value
from . import scenarios
from .closed_loop import LINKS, Values, check_limits, closed_loop, flavour_of, fmu_path, merged, no_component
from .registry import LAWS, PLANTS
from .scenarios import GROUPS

ACTUATORS, SENSORS, COMMANDS = (
    [f"{source}.{name}" for source, target, name in LINKS if (source, target) == ends]
    for ends in (("controller", "plant"), ("plant", "controller"), ("scenario", "controller")))
SHORTEST_FLOWN = 1e-4  # s; a flight to rest takes up to 300 s
LONGEST_STEP = 1.0  # s; the vehicle's elastic modes turn three times in that

# What is set by options of their own, and would be overruled.
OPTIONS = {"plant.V_start": "--V", "plant.h_start": "--h", "scenario.V_command_base": "--V",
           "scenario.h_command_base": "--h", **{f"scenario.scale_{group}_base": "--scale" for group in GROUPS}}


def linearize(controller: str = "neural", preset: str | None = None, plant: str = "ideal", V: float = 7700.0,
              h: float = 85000.0, scale: float = 1.0, step: float = 0.01, values: Values | None = None
              ) -> dict[str, Any]:
    """Matrices, poles and zeros of the vehicle alone and of the closed loop, and margins at each actuator and sensor.

    About level flight at `V` (ft/s), `h` (ft), every coefficient group times `scale`; the loop is sampled every `step`
    seconds. `controller` and `plant` are words of the registry, or anybody's FMUs as NAME=FILE.fmu; `values` are
    parameters of both. Raises UsageError for what is not known or outside its limits, RunError if there is no such
    flight.
    """
    exact = controller in LAWS and plant == "ideal" and not (LAWS[controller].learns and scale != 1)
    if not 0 < step <= LONGEST_STEP:
        raise UsageError(f"--step {step:g} is not allowed: it must be above 0 and at most {LONGEST_STEP:g} s.")
    if not exact and step < SHORTEST_FLOWN:
        raise UsageError(f"--step {step:g} is not allowed: the FMU files are flown, in steps of at least "
                         f"{SHORTEST_FLOWN:g} s.")
    if not 0 < scale < float("inf"):
        raise UsageError(f"--scale {scale:g} is not allowed: it must be a positive number.")
    for component, name in ((c, n) for c, pairs in (values or {}).items() for n in pairs):
        if f"{component}.{name}" in OPTIONS:
            raise UsageError(f"{component}.{name} cannot be set here: {OPTIONS[f'{component}.{name}']} gives it.")
    if exact:
        return from_models(controller, preset or LAWS[controller].preset or "", V, h, scale, step, values or {})
    return from_files(controller, preset, plant, V, h, scale, step, values or {})


def from_models(controller: str, preset: str, V: float, h: float, scale: float, step: float, values: Values
                ) -> dict[str, Any]:
    """Exactly, through the Jacobians of the equations of law and vehicle. Raises as `linearize` does."""
    from fmus.linear_report import linear_report
    from fmus.linearize import NoTrim

    from ..analysis.margins import margins_at

    law, plant = import_module(LAWS[controller].module), import_module(PLANTS["ideal"].module)
    flight: Values = {"plant": {"V_start": V, "h_start": h}}
    gains, parameters = allowed(controller, preset, merged(values, flight))
    del parameters["V_start"], parameters["h_start"]
    try:
        found = linear_report(plant, law, gains, V, h, step, dict.fromkeys(GROUPS, scale), parameters, margins_at)
    except NoTrim as error:
        raise RunError(str(error)) from None
    except ValueError as error:
        raise UsageError(str(error)) from None
    return {"controller": controller, "preset": preset, **found}


def allowed(controller: str, preset: str, values: Values) -> tuple[dict[str, Value], dict[str, Value]]:
    """The values of the law (its preset's, and those given) and of the ideal plant, each in its type.

    Raises UsageError for a preset or a variable that its FMU does not have, and for a value that this does not allow.
    """
    from ..master.fmu import FmuFile

    models = {"controller": LAWS[controller], "plant": PLANTS["ideal"]}
    for component, pairs in values.items():
        if component == "scenario" and pairs:
            raise UsageError(f"scenario.{next(iter(pairs))} cannot be set here: the flight is level, at --V and --h.")
        if component not in models:
            raise UsageError(no_component(component, models))
    found: list[dict[str, Value]] = []
    for component, model in models.items():
        with FmuFile.open(fmu_path(flavour_of(None), model.fmu)) as file:
            own = file.preset(preset) if component == "controller" else {}
            if component == "controller":
                check_limits(Component(component, file.path, {**own, **values.get(component, {})}))
            found.append({name: file.checked(name, value, component)
                          for name, value in {**own, **values.get(component, {})}.items()})
    return found[0], found[1]


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
