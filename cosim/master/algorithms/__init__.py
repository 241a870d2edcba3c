"""The co-simulation algorithms, one file each. Adding one: write its file, and name it here.

An algorithm is a class with
    OPTIONS                    its options: name -> (default, how a word is read)
    __init__(master, options, plan)   raises UsageError if the FMUs cannot do what it needs
    advance(most)              at most `most` ticks on; rows go to the plan's recorder; raises RunError
    time, ticks, done          where it is, how many steps that took, and whether it is the plan's stop
"""
from dataclasses import dataclass, field
from difflib import get_close_matches
from importlib import import_module
from typing import Any

from ...errors import UsageError

ALGORITHMS = {
    "gauss-seidel": ("gauss_seidel", "GaussSeidel"),
    "jacobi": ("jacobi", "Jacobi"),
    "multi-rate": ("multi_rate", "MultiRate"),
    "variable": ("variable", "Variable"),
    "iterated": ("iterated", "Iterated"),
}


@dataclass(frozen=True)
class Method:
    """An algorithm's name and its options, as in `multi-rate,controller=20,hold=linear`."""
    name: str
    options: dict[str, Any] = field(default_factory=dict)

    @property
    def algorithm(self) -> Any:
        file, kind = ALGORITHMS[self.name]
        return getattr(import_module(f".{file}", __package__), kind)


def method(word: str) -> Method:
    """The method that `word` names: NAME[,OPTION=VALUE]...

    Raises UsageError for an unknown name or option, or a value that cannot be read.
    """
    name, *pairs = word.split(",")
    if name not in ALGORITHMS:
        near = get_close_matches(name, ALGORITHMS, 1)
        hint = f" Did you mean {near[0]}?" if near else ""
        raise UsageError(f"--algorithm {name} is not known; there are {', '.join(ALGORITHMS)}.{hint}")
    known = Method(name).algorithm.OPTIONS
    options = {key: default for key, (default, _) in known.items()}
    rates: dict[str, int] = {}
    for pair in pairs:
        key, equals, value = pair.partition("=")
        reader = known[key][1] if key in known else whole if "rates" in known else None
        if not equals or reader is None:
            allowed = [k for k in known if k != "rates"] + (["COMPONENT"] if "rates" in known else [])
            raise UsageError(f"--algorithm {word}: {pair} is not an option of {name}; "
                             f"there {'is' if len(allowed) == 1 else 'are'} {', '.join(k + '=' for k in allowed)}.")
        try:
            read = reader(value)
        except (KeyError, ValueError):
            raise UsageError(f"--algorithm {word}: {value} is no value for {key}.") from None
        (options if key in known else rates)[key] = read
    return Method(name, {**options, **({"rates": rates} if "rates" in known else {})})


def whole(word: str) -> int:
    """A whole number from 1 on."""
    if int(word) < 1:
        raise ValueError
    return int(word)


def positive(word: str) -> float:
    if not 0 < float(word) < float("inf"):
        raise ValueError
    return float(word)


def linear(word: str) -> bool:
    """How inputs are held through a step: constant, or by their last slope."""
    return {"constant": False, "linear": True}[word]


def names(word: str) -> list[str]:
    """Components in an order, joined by +."""
    return word.split("+")


HOLD = {"hold": (False, linear)}
ORDER: dict[str, Any] = {"order": (None, names)}
