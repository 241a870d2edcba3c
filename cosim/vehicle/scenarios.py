"""What to fly: the built-in scenarios, and one's own as YAML files."""
from pathlib import Path

import yaml
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from ..errors import UsageError


class Scenario(BaseModel):
    """A flight: how long, which presets, which values. Components are scenario, controller and plant."""
    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str
    stop: float = Field(gt=0, allow_inf_nan=False, description="s")
    presets: dict[str, str] = Field(default={}, description="component -> preset of its FMU")
    set: dict[str, float | bool | str] = Field(default={}, description="component.variable -> value")
    first_figure: int | None = Field(default=None, description="number of the first figure, as in the paper")


BUILT_IN = {
    "case1": Scenario(name="case1", stop=100, presets={"scenario": "case1"}, first_figure=2),
    "case2": Scenario(name="case2", stop=300, presets={"scenario": "case2"}, first_figure=8),
    "hold": Scenario(name="hold", stop=60, presets={"scenario": "hold"}),
}


def load(word: str) -> Scenario:
    """The built-in scenario called `word`, or the one in the YAML file at that path.

    Raises UsageError if there is none, or if the file is not a scenario.
    """
    if word in BUILT_IN:
        return BUILT_IN[word]
    path = Path(word)
    if not path.is_file():
        from difflib import get_close_matches

        near = get_close_matches(word, BUILT_IN, 1)
        hint = f" Did you mean {near[0]}?" if near else ""
        raise UsageError(f"{word} is neither a scenario ({', '.join(BUILT_IN)}) nor a file.{hint}")
    try:
        return Scenario.model_validate(yaml.safe_load(path.read_text()))
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise UsageError(f"{path} is not YAML: {' '.join(str(error).split())}") from None
    except ValidationError as error:
        first = error.errors()[0]
        field = ".".join(str(part) for part in first["loc"]) or "the file"
        raise UsageError(f"{path}: {field}: {first['msg']}.") from None
