"""The closed loop as a system: which FMU files, which presets, which values, wired how."""
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from fmus.places import found

from ..errors import UsageError
from ..master.quantities import Unit, between, conversion
from ..master.system import Component, Connection, System, Value
from ..names import named, safe
from .registry import LAWS, PLANTS, SCENARIO, Model
from .scenarios import Scenario

FLAVOURS = ("python", "native", "native-fmi3")  # folders of FMUs; FMI 2.0 but for the last
Values = dict[str, dict[str, Value]]  # component -> variable -> value

# source, target, the variables of both. What a component of somebody else may lack is in OPTIONAL.
CLOSED_LOOP = [
    ("scenario", "controller", ("V_command", "h_command")),
    ("scenario", "plant", ("scale_thrust", "scale_lift", "scale_drag", "scale_moment", "scale_forces")),
    ("plant", "controller", ("V", "h", "gamma", "theta", "Q")),
    ("controller", "plant", ("fuel_ratio", "elevator")),
]
OPTIONAL = {"controller": {"V_command", "h_command", "V", "h", "gamma", "theta", "Q"},
            "plant": {"scale_thrust", "scale_lift", "scale_drag", "scale_moment", "scale_forces"}}
LIMITS = (("fuel_ratio_min", "fuel_ratio_max"), ("elevator_min", "elevator_max"))  # parameters of our laws
Link = tuple[str, str, str]
LINKS: list[Link] = [(source, target, name) for source, target, shared in CLOSED_LOOP for name in shared]

# Where nobody says what is commanded, it is where the vehicle starts.
FOLLOWS = {"V_command_base": "V_start", "h_command_base": "h_start"}


@dataclass(frozen=True)
class Choice:
    """An FMU for one place of the loop: the name that results give it, and its preset where nobody says another."""
    name: str
    fmu: Path
    preset: str | None = None
    ours: bool = True


@dataclass(frozen=True)
class ClosedLoop:
    """A system to fly, with what its parts are called and whose preset each one flies."""
    system: System
    controller: str
    plant: str
    flavour: str
    presets: dict[str, str]        # component -> preset
    preset_from: dict[str, str]    # component -> command line, scenario or default
    foreign: bool                  # whether somebody else's FMU is in it, which may crash
    notes: list[str]               # what a reader should know although the loop flies

    @property
    def preset(self) -> str | None:
        """The controller's."""
        return self.presets.get("controller")


def choice(option: str, value: str, allowed: Iterable[str]) -> str:
    """`value` itself. Raises UsageError unless it is one of `allowed`."""
    if value not in allowed:
        raise UsageError(f"--{option} {value} is not known; there are {', '.join(allowed)}.")
    return value


def flavour_of(word: str | None) -> str:
    """`word` itself, or without one the flavour to fly: native where it is built, else python. Raises UsageError for
    an unknown one."""
    built = fmu_path("native", SCENARIO.fmu).is_file()
    return choice("flavour", word or ("native" if built else "python"), FLAVOURS)


def fmu_path(flavour: str, model: str) -> Path:
    """Where the FMU of our model is: in the folder that AHV_FMUS names, else where `fmus.places` finds it. Raises
    UsageError for an unknown flavour."""
    choice("flavour", flavour, FLAVOURS)
    ours = os.environ.get("AHV_FMUS")
    return Path(ours) / f"{model}.fmu" if ours is not None else found(flavour, model)


def names_file(word: str) -> bool:
    """Whether `word` is FILE.fmu or NAME=FILE.fmu, and not a word of the registry."""
    return "=" in word or word.endswith(".fmu")


def law_name(word: str) -> str:
    """What results call the FMU that `word` names, which `chosen` checks: NAME of NAME=FILE.fmu, else what is like the
    file's name."""
    name, _, file = word.rpartition("=")
    return name or (safe(Path(file).stem) if names_file(word) else word)


def chosen(option: str, word: str, known: Mapping[str, Model], flavour: str, folder: Path = Path()) -> Choice:
    """What `word` names: one of ours, or anybody's FMU as FILE.fmu or NAME=FILE.fmu (below `folder`, if relative).

    Raises UsageError if it is neither, or if NAME is not a name.
    """
    if names_file(word):
        return Choice(named(option, law_name(word)), folder / Path(word.rpartition("=")[2]).expanduser(), ours=False)
    if word not in known:
        raise UsageError(f"--{option} {word} is not known; there are {', '.join(known)}, or any FMU as NAME=FILE.fmu.")
    return Choice(word, fmu_path(flavour, known[word].fmu), known[word].preset)


def absolute(word: str, folder: Path) -> str:
    """`word` as `chosen` takes it, with the file that it names (if it names one) as an absolute path."""
    if not names_file(word):
        return word
    name, equals, file = word.rpartition("=")
    return f"{name}{equals}{(folder / Path(file).expanduser()).resolve()}"


def assignments(words: Iterable[str]) -> Values:
    """COMPONENT.VARIABLE=VALUE words. Raises UsageError for one of another form."""
    result: Values = {}
    for word in words:
        target, equals, value = word.partition("=")
        component, dot, variable = target.partition(".")
        if not (equals and dot and variable):
            raise UsageError(f"--set {word} is not of the form COMPONENT.VARIABLE=VALUE.")
        result.setdefault(component, {})[variable] = value
    return result


def chosen_presets(word: str | None) -> dict[str, str]:
    """--preset: a controller preset, or COMPONENT=NAME pairs separated by commas; component -> preset."""
    pairs = [part.rpartition("=") for part in word.split(",")] if word else []
    return {component or "controller": name for component, _, name in pairs}


def whose_preset(said: Mapping[str, str], scenario: Scenario, default: Mapping[str, str | None]
                 ) -> tuple[dict[str, str], dict[str, str]]:
    """Command line over scenario over default: component -> preset, and component -> which of them said it."""
    presets: dict[str, str] = {}
    said_by: dict[str, str] = {}
    for origin, given in (("default", default), ("scenario", scenario.presets), ("command line", said)):
        for component, name in given.items():
            if name is not None:
                presets[component], said_by[component] = name, origin
    return presets, said_by


def merged(*layers: Values) -> Values:
    """Values of all layers, the later ones over the earlier."""
    result: Values = {}
    for layer in layers:
        for component, given in layer.items():
            result.setdefault(component, {}).update(given)
    return result


def closed_loop(scenario: Scenario, controller: str = "neural", plant: str = "ideal", flavour: str | None = None,
                presets: Mapping[str, str] | None = None, values: Values | None = None,
                uncertainty: float | None = None, folder: Path = Path()) -> ClosedLoop:
    """The loop that flies `scenario`.

    `controller` and `plant` are words of the registry, or anybody's FMUs as NAME=FILE.fmu, relative to `folder`.
    `presets` (component -> name) and `values` stand over those of the scenario. `flavour` None is native where it is
    built. `uncertainty` is the amplitude of the coefficients that the scenario lets swing.

    Raises UsageError for what is not known or does not fit.
    """
    from ..master.fmu import preset  # fmpy is slow to import

    flavour = flavour_of(flavour)
    parts = {"scenario": Choice("scenario", fmu_path(flavour, SCENARIO.fmu), SCENARIO.preset),
             "controller": chosen("controller", controller, LAWS, flavour, folder),
             "plant": chosen("plant", plant, PLANTS, flavour, folder)}
    names, said_by = whose_preset(presets or {}, scenario, {c: part.preset for c, part in parts.items()})
    given = merged(assignments([f"{name}={value}" for name, value in scenario.set.items()]), values or {})
    check_scenario(scenario, parts, {c for c, origin in said_by.items() if origin == "scenario"})
    for component in {*names, *given} - set(parts):
        raise UsageError(no_component(component, parts))
    commanded = following(parts["plant"].fmu, given.get("plant", {}))
    flown = merged({c: preset(part.fmu, names[c]) for c, part in parts.items() if c in names},
                   {"scenario": commanded}, given)
    if uncertainty is not None:
        flown = merged(flown, {"scenario": swings(scenario.name, flown["scenario"], uncertainty)})
    components = {c: Component(c, part.fmu, flown.get(c, {})) for c, part in parts.items()}
    check_limits(components["controller"])
    foreign = {c for c, part in parts.items() if not part.ours}
    links, notes = fitting(components, foreign) if foreign else (LINKS, [])
    return ClosedLoop(wired(**components, links=links), parts["controller"].name, parts["plant"].name, flavour, names,
                      said_by, bool(foreign), notes)


def check_limits(controller: Component) -> None:
    """Raises UsageError for a lower limit of an actuator that is above its upper limit."""
    from ..master.fmu import FmuFile

    pairs = [pair for pair in LIMITS if set(pair) & set(controller.values)]
    if not pairs:
        return
    with FmuFile.open(controller.fmu) as file:
        for pair in pairs:
            words = {name: word for name in pair if name in file.variables
                     and (word := controller.values.get(name, file.variables[name].start)) is not None}
            limits = [float(file.checked(name, word, "controller")) for name, word in words.items()]
            if len(limits) == 2 and limits[0] > limits[1]:
                least, most = (f"controller.{name} = {word}" for name, word in words.items())
                raise UsageError(f"{least} is not allowed: it is above {most}.")


def check_scenario(scenario: Scenario, parts: Mapping[str, Choice], flown: set[str]) -> None:
    """Raises UsageError, with file and line where there is one, for a value that the FMUs do not have, and for such a
    preset of a component in `flown`: the scenario's presets of others are replaced by the command line's."""
    from ..master.fmu import FmuFile, preset

    for component in flown:
        with scenario.at("presets", component):
            if component not in parts:
                raise UsageError(no_component(component, parts))
            preset(parts[component].fmu, scenario.presets[component])
    for component, part in parts.items():
        mine = {name: value for name, value in scenario.set.items() if name.partition(".")[0] == component}
        if mine:
            with FmuFile.open(part.fmu) as file:
                for name, value in mine.items():
                    with scenario.at("set", name):
                        file.checked(name.partition(".")[2], value, component)
    for name in scenario.set:
        if name.partition(".")[0] not in parts:
            with scenario.at("set", name):
                raise UsageError(no_component(name.partition(".")[0], parts))


def no_component(name: str, known: Iterable[str]) -> str:
    """The sentence about an unknown component."""
    return f"There is no component {name}; there are {', '.join(known)}."


def following(plant: Path, values: Mapping[str, Value]) -> dict[str, Value]:
    """The scenario's commands that follow a start among `values`. Raises UsageError for a start that is not allowed."""
    if not set(FOLLOWS.values()) & set(values):
        return {}
    from ..master.fmu import FmuFile  # fmpy is slow to import

    with FmuFile.open(plant) as file:
        return {command: file.checked(start, values[start], "plant")
                for command, start in FOLLOWS.items() if start in values}


def swings(name: str, values: Mapping[str, Value], amplitude: float) -> dict[str, Value]:
    """`amplitude` for each coefficient scale that swings. Raises UsageError if none does."""
    found: dict[str, Value] = {key: amplitude for key, value in values.items()
                               if key.startswith("scale_") and key.endswith("_sine") and value not in (0.0, "0", "0.0")}
    if not found:
        raise UsageError(f"--uncertainty {amplitude:g} has nothing to act on: no coefficient of {name} changes.")
    return found


def wired(scenario: Component, controller: Component, plant: Component, links: list[Link] = LINKS) -> System:
    """The vehicle under control: scenario -> controller -> plant, and the measurements back."""
    return System((scenario, controller, plant),
                  tuple(Connection(f"{source}.{name}", f"{target}.{name}") for source, target, name in links))


def fitting(components: Mapping[str, Component], foreign: set[str]) -> tuple[list[Link], list[str]]:
    """The links whose ports are there, and notes on optional ports that are not.

    Raises UsageError, by name, for a port that is missing or has another unit in a component that is `foreign`.
    """
    ports = {name: ports_of(component.fmu) for name, component in components.items()}
    fit: list[Link] = []
    unwired: dict[str, list[str]] = {}
    for source, target, name in LINKS:
        lacking = [(component, kind) for component, kind in ((source, "output"), (target, "input"))
                   if ports[component].get(name, ("", None))[0] != kind]
        for component, kind in lacking:
            file = components[component].fmu.name
            if kind == "output" or name not in OPTIONAL[component]:
                raise UsageError(f"{component} ({file}) has no {kind} {name}, which the closed loop needs.")
            unwired.setdefault(f"{component} ({file})", []).append(name)
        if lacking:
            continue
        one, other = ports[source][name][1], ports[target][name][1]
        if one and other and conversion(one, other) != (1.0, 0.0):
            which, its, ours = (target, other, one) if target in foreign else (source, one, other)
            theirs, wanted = between(its, ours)
            raise UsageError(f"{which} ({components[which].fmu.name}) has {name} in {theirs}; "
                             f"the closed loop has it in {wanted}.")
        fit.append((source, target, name))
    return fit, [f"{who} has no input {', '.join(names)}: not connected." for who, names in unwired.items()]


def ports_of(path: Path) -> dict[str, tuple[str, Unit | None]]:
    """Name -> (causality, unit) of an FMU's inputs and outputs. Raises UsageError for no such FMU."""
    from ..master.fmu import FmuFile

    with FmuFile.open(path) as file:
        return {v.name: (v.causality, file.description.unit_of(v)) for v in file.description.variables
                if v.causality in ("input", "output")}
