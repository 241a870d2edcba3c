"""A model's functions as the builder uses them: those of `fmus.interface`, with what the model left to the builder.

A discrete law, one with a parameter `sample_time` (T), becomes a model that can be stepped by any step: its state has
what it shows and how often it ran besides. It runs at the instants t0, t0 + T, t0 + 2 T, ... from the start time t0 on,
each with the inputs of the communication step that the instant lies in, or that begins there; what it shows then it
shows until it runs again.
"""
from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType
from typing import Any

from .integrators import advancing
from .interface import computed, names, variables

EARLY = 1e-6  # of T: an instant is not missed by the rounding of a clock that sums its steps up

Function = Callable[..., Any]


@dataclass(frozen=True)
class Functions:
    """What a model computes; the arguments are those of `fmus.interface`."""
    start: Function
    prepare: Function
    advance: Function
    outputs: Function


def nothing(m: Any, p: Any, h: Any) -> list[Any]:
    """The `prepare` of a model that has none."""
    return []


def functions(model: ModuleType) -> Functions:
    """The functions of `model`."""
    own = Functions(model.start, getattr(model, "prepare", None) or nothing, advancing(model), model.outputs)
    table = variables(model.VARIABLES)
    return sampled(own, computed(table)) if "sample_time" in names(table, "parameter") else own


def sampled(law: Functions, shown: list[str]) -> Functions:
    """`law`, which runs at its instants, as a model for any step up to T; `shown` are the names it computes.

    The state is the number of times that it ran, the start time, what it shows, and its own state.
    """
    count = len(shown)

    def start(m: Any, u: Any, p: Any) -> list[Any]:
        x = law.start(m, u, p)
        y = law.outputs(m, 0.0, x, u, p)
        return [0.0, 0.0, *(y[name] for name in shown), *x]

    def prepare(m: Any, p: Any, h: Any) -> Any:
        return law.prepare(m, p, p.sample_time)

    def advance(m: Any, t: Any, h: Any, x: list[Any], u: Any, p: Any, c: list[Any]) -> list[Any]:
        ran, T = x[0], p.sample_time
        begun = m.where(ran > 0.0, x[1], t)
        instant = begun + ran * T
        due = m.either(ran <= 0.0, instant < t + h - EARLY * T)
        later = law.advance(m, instant, T, x[2 + count:], u, p, c)
        y = law.outputs(m, instant, later, u, p)
        return [m.where(due, ran + 1.0, ran), begun,
                *(m.where(due, new, old) for new, old in zip([*(y[name] for name in shown), *later], x[2:]))]

    def outputs(m: Any, t: Any, x: list[Any], u: Any, p: Any) -> dict[str, Any]:
        return dict(zip(shown, x[2:]))

    return Functions(start, prepare, advance, outputs)
