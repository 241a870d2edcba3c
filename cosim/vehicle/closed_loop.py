"""Our closed loop by words: which FMU files, which presets, which values."""
from pathlib import Path
from typing import Any

from ..errors import UsageError
from ..master.system import Component, Connection, System, Value

DIST = Path(__file__).parents[2] / "fmus" / "dist"
CONTROLLERS = {"neural": "AhvController", "backstepping": "AhvBackstepping", "resilient": "AhvResilient"}
PLANTS = {"ideal": "AhvPlant", "instrumented": "AhvInstrumentedPlant"}
FLAVOURS = ("python", "native")
CLOSED_LOOP = [
    ("scenario", "controller", ("V_command", "h_command")),
    ("scenario", "plant", ("scale_thrust", "scale_lift", "scale_drag", "scale_moment", "scale_forces")),
    ("plant", "controller", ("V", "h", "gamma", "theta", "Q")),
    ("controller", "plant", ("fuel_ratio", "elevator")),
]


def wired(scenario: Component, controller: Component, plant: Component) -> System:
    """The vehicle under control: scenario -> controller -> plant, and the measurements back."""
    connections = tuple(Connection(f"{source}.{name}", f"{target}.{name}")
                        for source, target, shared in CLOSED_LOOP for name in shared)
    return System((scenario, controller, plant), connections)


def choice(option: str, value: str, allowed: Any) -> str:
    if value not in allowed:
        raise UsageError(f"--{option} {value} is not known; there are {', '.join(allowed)}.")
    return value


def fmu_path(flavour: str, model: str) -> Path:
    return DIST / choice("flavour", flavour, FLAVOURS) / f"{model}.fmu"


def assignments(words: list[str]) -> dict[str, dict[str, Value]]:
    """--set words as component -> variable -> value."""
    result: dict[str, dict[str, Value]] = {}
    for word in words:
        target, equals, value = word.partition("=")
        component, dot, variable = target.partition(".")
        if not (equals and dot and variable):
            raise UsageError(f"--set {word} is not of the form COMPONENT.VARIABLE=VALUE.")
        result.setdefault(component, {})[variable] = value
    return result


def assemble(fmus: dict[str, Path], presets: dict[str, str], values: dict[str, dict[str, Value]]) -> System:
    """The closed loop with presets, then values, applied."""
    from ..master.fmu import preset  # fmpy takes its time

    components = {}
    for name, path in fmus.items():
        component = Component(name, path)
        if name in presets:
            component = component.with_values(preset(path, presets[name]))
        components[name] = component.with_values(values.get(name, {}))
    for name in {*presets, *values} - set(components):
        raise UsageError(f"There is no component {name}; there are {', '.join(components)}.")
    return wired(components["scenario"], components["controller"], components["plant"])


def planned(plan: Any, controller: str, presets: dict[str, str], flavour: str, words: list[str],
            plant: str = "ideal") -> System:
    """The closed loop of the scenario `plan`, with --set `words` applied last."""
    fmus = {"scenario": fmu_path(flavour, "AhvScenario"),
            "controller": fmu_path(flavour, CONTROLLERS[choice("controller", controller, CONTROLLERS)]),
            "plant": fmu_path(flavour, PLANTS[choice("plant", plant, PLANTS)])}
    values = assignments([f"{name}={value}" for name, value in plan.set.items()])
    for component, given in assignments(words).items():
        values.setdefault(component, {}).update(given)
    return assemble(fmus, presets, values)


def chosen_presets(word: str) -> dict[str, str]:
    """--preset: a controller preset, or COMPONENT=NAME pairs separated by commas."""
    pairs = [part.rpartition("=") for part in word.split(",")]
    presets = {component or "controller": name for component, _, name in pairs}
    return {"controller": "calibrated", **presets}
