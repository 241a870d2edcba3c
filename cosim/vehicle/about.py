"""What can be set and seen: of a component of the loop, a law, a plant, a scenario or any FMU."""
from os.path import isfile
from typing import Any

from ..errors import UsageError, did_you_mean
from ..master.info import FmuInfo, info
from ..text import text_table
from . import scenarios
from .closed_loop import closed_loop, flavour_of, fmu_path
from .registry import LAWS, PLANTS, SCENARIO
from .scenarios import BUILT_IN

COMPONENTS = {"scenario": SCENARIO, "controller": LAWS["neural"], "plant": PLANTS["ideal"], **LAWS, **PLANTS}


class ScenarioInfo:
    """What a scenario flies: its stop time, the preset of each component, and what it sets beyond `hold`."""

    def __init__(self, word: str, flavour: str):
        self.scenario = scenarios.load(word)
        loop = closed_loop(self.scenario, flavour=flavour)
        self.presets = loop.presets
        holding = closed_loop(scenarios.load("hold"), flavour=flavour).system.components[0]
        declared = info(fmu_path(flavour, SCENARIO.fmu))
        self.rows = [(f"{component.name}.{name}", declared[name].unit if component.name == "scenario" else "", value)
                     for component in loop.system.components for name, value in component.values.items()
                     if (component.name == "scenario" and value != holding.values.get(name))
                     or f"{component.name}.{name}" in self.scenario.set]

    def to_dict(self) -> dict[str, Any]:
        """The same as plain data for JSON."""
        return {"scenario": self.scenario.name, "stop_s": self.scenario.stop, "presets": self.presets,
                "values": {name: value for name, _, value in self.rows}}

    def __str__(self) -> str:
        presets = ", ".join(f"{component} {name}" for component, name in self.presets.items())
        lines = [self.scenario.name, f"  stop: {self.scenario.stop:g} s", f"  presets: {presets}", "",
                 *text_table(("what it sets beyond hold", "unit", "value"), self.rows), "",
                 "`ahv info scenario`, `controller` and `plant` show what else can be set."]
        return "\n".join(lines)


def about(word: str, flavour: str | None = None) -> FmuInfo | ScenarioInfo:
    """What `word` is: an FMU file, a component of the loop, a law, a plant, a built-in scenario or a scenario file.

    Raises UsageError if it is none of these.
    """
    flavour = flavour_of(flavour)
    if word in COMPONENTS:
        return info(fmu_path(flavour, COMPONENTS[word].fmu))
    if word in BUILT_IN or word.endswith((".yaml", ".yml")):
        return ScenarioInfo(word, flavour)
    if not isfile(word):
        known = [*COMPONENTS, *BUILT_IN]
        raise UsageError(f"{word} is neither a file nor one of {', '.join(known)}{did_you_mean(word, known)}")
    return info(word)
