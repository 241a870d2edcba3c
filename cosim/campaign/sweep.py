"""A sweep: the campaign of a full grid that a command line says in a few words. What `ahv sweep` does."""
import re
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NoReturn

import yaml

from .. import names
from ..errors import UsageError
from ..master.quantities import is_number
from ..master.system import Value
from ..yaml_file import Located, Place, Source
from .campaign import carried_out
from .plan import make, read
from .subject import Subject

RANGE = re.compile(r"([^:,]+):([^:,]+):([^:,]+)")
WORDS = {"dispersions": "", "metrics": "--metric ", "success": "--success ", "set": "--set "}  # field: before a name


def sweep(about: Mapping[str, Any], variables: Sequence[str], metrics: Sequence[str] = (), success: Sequence[str] = (),
          out: Path | None = None, resume: bool = False, workers: int | None = None,
          subjects: Sequence[type[Subject]] = ()) -> dict[str, Any]:
    """Fly every combination of the values of `variables` and write the results of a campaign; a summary as JSON goes.

    `about` are the fields of a campaign file that say what flies. `variables` are words VARIABLE=A:B:N, N values from A
    to B, or VARIABLE=V1,V2,...; `metrics` are words NAME=EXPRESSION; `success` are expressions, or such words. Raises
    UsageError before any run flies if that cannot be done; RunError as `campaign`.
    """
    began = time.perf_counter()
    asked = {"name": "sweep", **about, "sampling": "grid", "dispersions": paired(map(axis, variables)),
             "metrics": paired(metric(word) for word in metrics),
             "success": paired(criterion(word, i) for i, word in enumerate(success, 1))}
    text = yaml.safe_dump({field: said for field, said in asked.items() if said != {}}, sort_keys=False,
                          allow_unicode=True, width=110)
    source = CommandLine(text)
    campaign, kind = read(source, *subjects)
    plan = make(campaign, source, kind)
    folder = out or Path("results") / "sweep" / plan.campaign.name
    return carried_out(plan, text, folder, resume=resume, workers=workers, began=began)


def called(subject: str, variables: Sequence[str]) -> str:
    """A name for a sweep of `subject`, a word or a file: case1-k_gamma-mass."""
    swept = [word.partition("=")[0].rpartition(".")[2] for word in variables]
    return names.safe("-".join([Path(subject).stem, *swept]))


class CommandLine(Source):
    """A campaign file that nobody wrote: messages name the words of the command line instead of its lines."""

    def __init__(self, text: str):
        self.path = Path("sweep.yaml").absolute()
        try:
            self.read(text)
        except yaml.MarkedYAMLError as error:
            raise UsageError(f"This is no sweep: {error.problem}.") from None

    def fail(self, place: Place, message: str) -> NoReturn:
        """Raises UsageError "WORD: MESSAGE" for the field at `place`."""
        field, *inner = (*place, "")
        word = f"{WORDS[str(field)]}{inner[0]}" if field in WORDS else "" if field in ("scenario", "system", "") else \
            f"--{str(field).replace('controllers', 'controller')}"
        start = f"{word}: " if word and not message.startswith("--") else ""
        raise Located(f"{start}{message.rstrip('.')}{'' if message.endswith('?') else '.'}") from None


def paired(found: Any) -> dict[str, Any]:
    """Names with what they are. Raises UsageError for a name that is there twice."""
    pairs: dict[str, Any] = {}
    for name, one in found:
        if name in pairs:
            raise UsageError(f"{name} is given twice.")
        pairs[name] = one
    return pairs


def axis(word: str) -> tuple[str, dict[str, Any]]:
    """A variable and its dispersion, from VARIABLE=A:B:N or VARIABLE=V1,V2,... Raises UsageError for another form."""
    name, equals, values = word.partition("=")
    component, dot, variable = name.partition(".")
    if not (equals and component and dot and variable and values):
        raise UsageError(f"{word} is not of the form COMPONENT.VARIABLE=A:B:N or COMPONENT.VARIABLE=V1,V2,...")
    ends = RANGE.fullmatch(values)
    if ends is None:
        return name, {"values": [value(part, word) for part in values.split(",")]}
    low, high, count = ends.groups()
    if not (is_number(low) and is_number(high)):
        raise UsageError(f"{word}: {low} and {high} must be numbers.")
    if not re.fullmatch(r"\s*\d{1,9}\s*", count) or int(count) < 2:
        raise UsageError(f"{word}: {count} must be how many values there are from {low} to {high}, 2 or more.")
    if not float(low) < float(high):
        raise UsageError(f"{word}: {low} must be below {high}.")
    return name, {"low": float(low), "high": float(high), "points": int(count)}


def value(part: str, word: str) -> Value:
    """A value of a list: a number, true or false, or a word. Raises UsageError where there is none."""
    text = part.strip()
    if not text:
        raise UsageError(f"{word}: a value is missing.")
    if ":" in text:
        raise UsageError(f"{word}: {text} is neither a value nor A:B:N.")
    return float(text) if is_number(text) else {"true": True, "false": False}.get(text.lower(), text)


def metric(word: str) -> tuple[str, str]:
    """A metric's name and expression. Raises UsageError for a word of another form."""
    name, equals, text = word.partition("=")
    if not (equals and name.strip() and text.strip()) or text.startswith("="):
        raise UsageError(f"--metric {word} is not of the form NAME=EXPRESSION.")
    return name.strip(), text.strip()


def criterion(word: str, number: int) -> tuple[str, str]:
    """A criterion's name, if only its number, and expression."""
    found = re.fullmatch(r"\s*(\w+)\s*=(?!=)(.*)", word, re.DOTALL)
    return (found[1], found[2].strip()) if found else (str(number), word)
