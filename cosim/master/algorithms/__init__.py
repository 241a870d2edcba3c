"""The co-simulation algorithms, one file each. Adding one: write its file, and name it here.

An algorithm is a class with
    OPTIONS                    its options: name -> (default, how a word is read)
    __init__(master, options, experiment)   raises UsageError if the FMUs cannot do what it needs
    advance(most)              takes at most `most` steps; rows go to the experiment's recorder; raises RunError
    time, ticks, done          the simulated time, the steps taken, and whether the experiment's stop is reached
"""
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any

from ...errors import UsageError, nearest
from .base import Algorithm
from .options import whole

ALGORITHMS = {
    "gauss-seidel": ("gauss_seidel", "GaussSeidel"),
    "jacobi": ("jacobi", "Jacobi"),
    "multi-rate": ("multi_rate", "MultiRate"),
    "variable": ("variable", "Variable"),
    "iterated": ("iterated", "Iterated"),
}


@dataclass(frozen=True)
class Method:
    """An algorithm's name and its options, as in `multi-rate,controller=20,hold=linear`, which is its `word`."""
    name: str
    options: dict[str, Any] = field(default_factory=dict)
    word: str = field(default="", compare=False)

    @property
    def algorithm(self) -> type[Algorithm]:
        """The class that carries it out."""
        file, kind = ALGORITHMS[self.name]
        found: type[Algorithm] = getattr(import_module(f".{file}", __package__), kind)
        return found

    def periods(self, step: float) -> dict[str, float]:
        """Component -> time between its steps (s), of those that do not step in every tick of `step` (s)."""
        return {name: count * step for name, count in self.options.get("rates", {}).items() if count > 1}


def method(word: str) -> Method:
    """The method that `word` names: NAME[,OPTION=VALUE]...

    Raises UsageError for an unknown name or option, or a value that cannot be read.
    """
    name, *pairs = word.split(",")
    if name not in ALGORITHMS:
        near = nearest(name, ALGORITHMS)
        hint = f" Did you mean {near}?" if near else ""
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
        except ValueError as error:
            raise UsageError(f"--algorithm {word}: {value} is no value for {key}: it must be {error}.") from None
        (options if key in known else rates)[key] = read
    return Method(name, {**options, **({"rates": rates} if "rates" in known else {})}, word)
