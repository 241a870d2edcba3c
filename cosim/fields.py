"""Fields of the YAML files that users write, as pydantic takes them."""
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field


def exact(value: Any) -> Any:
    """The value. Raises ValueError for a whole number that a double does not hold exactly."""
    if isinstance(value, int) and abs(value) > 2**53 and (value.bit_length() > 1023 or int(float(value)) != value):
        raise ValueError(f"{value} is no number that a double holds exactly")
    return value


Finite = Annotated[float, Field(allow_inf_nan=False)]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
Exact = Annotated[Finite, BeforeValidator(exact)]
Setting = Annotated[Finite | bool | str, BeforeValidator(exact)]  # what a variable is set to
Name = Annotated[str, Field(pattern=r"^\w+\.[^\s=]+$")]           # component.variable


class Strict(BaseModel):
    """A model that refuses fields it does not know."""
    model_config = ConfigDict(extra="forbid", frozen=True)
