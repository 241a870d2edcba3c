"""The vehicle under a control law about level flight: poles, zeros, margins, from the FMU files (`analysis`)."""
from math import degrees
from typing import Any

from ..errors import UsageError
from ..master.notes import note
from . import scenarios
from .closed_loop import LINKS, Values, closed_loop, merged, no_component
from .registry import PLANTS
from .scenarios import GROUPS

ACTUATORS, SENSORS, COMMANDS = (
    [f"{source}.{name}" for source, target, name in LINKS if (source, target) == ends]
    for ends in (("controller", "plant"), ("plant", "controller"), ("scenario", "controller")))
SHORTEST_STEP = 1e-4  # s; a flight to rest takes up to 300 s
LONGEST_STEP = 1.0    # s; the vehicle's elastic modes turn three times in that

# What is set by options of their own, and would be overruled.
OPTIONS = {"plant.V_start": "--V", "plant.h_start": "--h", "scenario.V_command_base": "--V",
           "scenario.h_command_base": "--h", **{f"scenario.scale_{group}_base": "--scale" for group in GROUPS}}
PARTS = {"loop": ("open_loop", "closed_loop", "margins"), "plant": ("open_loop",), "controller": ("law",)}


def linearize(controller: str = "neural", preset: str | None = None, plant: str = "ideal", V: float = 7700.0,
              h: float = 85000.0, scale: float = 1.0, step: float = 0.01, values: Values | None = None,
              of: str = "loop") -> dict[str, Any]:
    """Matrices, poles and zeros of the vehicle alone and of the closed loop, and margins at each actuator and sensor;
    `of` only the "plant" or the "controller", what is said of that.

    About level flight at `V` (ft/s), `h` (ft), every coefficient group times `scale`; the loop is sampled every `step`
    seconds. `controller` and `plant` are words of the registry, or anybody's FMUs as NAME=FILE.fmu; `values` are
    parameters of both. The files tell: see `analysis.linearize`. Raises UsageError for what is not known or outside its
    limits, RunError if there is no such flight.
    """
    check(scale, step, values or {}, of)
    start: Values = {"plant": {"V_start": V, "h_start": h}} if plant in PLANTS else {}
    commanded: Values = {"scenario": {"V_command_base": V, "h_command_base": h,
                                      **{f"scale_{group}_base": scale for group in GROUPS}}}
    loop = closed_loop(scenarios.load("hold"), controller, plant, presets={"controller": preset} if preset else {},
                       values=merged(commanded, start, values or {}))
    from ..analysis import linearize as linearize_files  # scipy is slow to import

    there = {link.source for link in loop.system.connections}
    found = linearize_files(loop.system, ACTUATORS, [s for s in SENSORS if s in there], step,
                            commands=[c for c in COMMANDS if c in there])
    rest = found["equilibrium"]
    if found["settled_at_s"] is None:
        note("The flight does not come to rest. The figures are of the FMUs' equations about their equilibrium, solved "
             "exactly: in its own steps a controller may differ.")
    return {"controller": loop.controller, "preset": loop.preset, "plant": loop.plant, "V_fps": V, "h_ft": h,
            "scale": dict.fromkeys(GROUPS, scale), "settled_at_s": found["settled_at_s"],
            "solved": found["solved"], "fuel_ratio": rest["controller.fuel_ratio"],
            "elevator_deg": degrees(rest["controller.elevator"]),
            **({"theta_deg": degrees(rest["plant.theta"])} if "plant.theta" in rest else {}),
            **({"altitude_offset_ft": rest["plant.h"] - h} if "plant.h" in rest else {}),
            **{key: found[key] for key in PARTS[of]}}


def check(scale: float, step: float, values: Values, of: str) -> None:
    """Raise UsageError for a number, a value or a word that is not allowed."""
    if of not in PARTS:
        raise UsageError(f"--of {of} is not known; there are {', '.join(PARTS)}.")
    if not 0 < step <= LONGEST_STEP:
        raise UsageError(f"--step {step:g} is not allowed: it must be above 0 and at most {LONGEST_STEP:g} s.")
    if step < SHORTEST_STEP:
        raise UsageError(f"--step {step:g} is not allowed: the FMU files are flown, in steps of at least "
                         f"{SHORTEST_STEP:g} s.")
    if not 0 < scale < float("inf"):
        raise UsageError(f"--scale {scale:g} is not allowed: it must be a positive number.")
    for component, name in ((c, n) for c, pairs in values.items() for n in pairs):
        if f"{component}.{name}" in OPTIONS:
            raise UsageError(f"{component}.{name} cannot be set here: {OPTIONS[f'{component}.{name}']} gives it.")
        if component == "scenario":
            raise UsageError(f"scenario.{name} cannot be set here: the flight is level, at --V and --h.")
        if component not in ("controller", "plant"):
            raise UsageError(no_component(component, ("controller", "plant")))
        for source, target, connected in LINKS:
            if (target, connected) == (component, name):
                raise UsageError(f"{component}.{name} cannot be set here: {source}.{connected} gives it.")
