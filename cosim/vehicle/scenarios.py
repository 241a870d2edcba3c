"""What to fly: the built-in scenarios, and one's own as YAML files."""
from contextlib import AbstractContextManager, nullcontext
from os.path import isfile
from pathlib import Path
from typing import Annotated

from pydantic import AfterValidator, BeforeValidator, Field, PrivateAttr

from .. import names
from ..errors import UsageError, nearest
from ..fields import Positive, Strict, exact
from ..yaml_file import Source
from .scenario_model import SCALES

GROUPS = tuple(name.removeprefix("scale_") for name in SCALES)  # of coefficients, which a scenario scales together


class Scenario(Strict):
    """A flight: how long, which presets, which values. Components are scenario, controller and plant."""
    name: Annotated[str, AfterValidator(names.checked)]
    stop: Positive = Field(description="s")
    presets: dict[str, str] = Field(default={}, description="component -> preset of its FMU")
    set: dict[str, Annotated[float | bool | str, BeforeValidator(exact)]] = Field(
        default={}, description="component.variable -> value")
    first_figure: int | None = Field(default=None, description="number of the first figure, as in the paper")
    _source: Source | None = PrivateAttr(default=None)

    def at(self, *place: str) -> AbstractContextManager[None]:
        """Errors raised inside get the file, line and field of `place`, if the scenario is from a file."""
        return self._source.at(*place) if self._source else nullcontext()


BUILT_IN = {
    "case1": Scenario(name="case1", stop=100, presets={"scenario": "case1"}, first_figure=2),
    "case2": Scenario(name="case2", stop=300, presets={"scenario": "case2"}, first_figure=8),
    "hold": Scenario(name="hold", stop=60, presets={"scenario": "hold"}),
}


def load(word: str) -> Scenario:
    """The built-in scenario called `word`, or the one in the YAML file at that path.

    Raises UsageError if there is none, or, with line and field, if the file is not a scenario.
    """
    if word in BUILT_IN:
        return BUILT_IN[word]
    path = Path(word)
    if not isfile(path):
        near = nearest(word, BUILT_IN)
        hint = f" Did you mean {near}?" if near else ""
        raise UsageError(f"{word} is neither a scenario ({', '.join(BUILT_IN)}) nor a file.{hint}")
    source = Source(path, "scenario file")
    scenario = source.load(Scenario)
    scenario._source = source
    return scenario
