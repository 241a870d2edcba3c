"""A YAML file's mistakes are said with file, line and field, for any pydantic model."""
from typing import Annotated, Literal

import pytest
from pydantic import BaseModel, ConfigDict, Field

from cosim.errors import UsageError
from cosim.yaml_file import Source


class Step(BaseModel):
    shape: Literal["step"]
    height: float


class Ramp(BaseModel):
    shape: Literal["ramp"]
    slope: float


class Case(BaseModel):
    model_config = ConfigDict(extra="forbid")
    stop: float = Field(gt=0)
    signals: dict[str, Annotated[Step | Ramp, Field(discriminator="shape")]] = {}


GOOD = "stop: 10\nsignals:\n  V:\n    shape: step\n    height: 100\n"


def source(folder, text):
    path = folder / "case.yaml"
    path.write_text(text)
    return Source(path, "case file")


def test_a_good_file_is_the_model(tmp_path):
    case = source(tmp_path, GOOD).load(Case)
    assert isinstance(case, Case) and case.stop == 10 and case.signals["V"].height == 100


@pytest.mark.parametrize("old, new, end", [
    ("stop: 10", "stop: -1", "case.yaml, line 1: stop: Input should be greater than 0, not -1."),
    ("stop: 10", "stop: 10\nstopp: 2", "case.yaml, line 2: stopp: there is no such field; did you mean stop?"),
    ("    height: 100\n", "", "case.yaml, line 3: signals.V: height is missing."),
    ("    shape: step\n", "", "case.yaml, line 3: signals.V: shape is missing."),
    ("shape: step", "shape: stp", "case.yaml, line 3: signals.V: there is no shape stp; there are 'step', 'ramp'."),
    ("stop: 10", "stop: 10\nstop: 2", "case.yaml, line 2: stop is given twice."),
    ("stop: 10", "stop: [", "case.yaml, line 3: this is not YAML: expected ',' or ']', but got ':'."),
])
def test_a_mistake_is_said_with_line_and_field(tmp_path, old, new, end):
    assert old in GOOD
    with pytest.raises(UsageError) as error:
        source(tmp_path, GOOD.replace(old, new)).load(Case)
    assert str(error.value).endswith(end)


def test_what_goes_wrong_at_a_place_is_on_its_line(tmp_path):
    read = source(tmp_path, GOOD)
    with pytest.raises(UsageError, match=r"line 5: signals\.V\.height: too high\.$"), read.at("signals", "V", "height"):
        raise ValueError("too high")


def test_a_missing_file_is_called_by_its_kind(tmp_path):
    with pytest.raises(UsageError, match=r"^There is no case file .*none\.yaml\.$"):
        Source(tmp_path / "none.yaml", "case file")
