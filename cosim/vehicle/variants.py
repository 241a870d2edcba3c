"""Variants of a run in words, as `ahv compare --run` takes them: NAME:OPTIONS."""
import shlex
from argparse import ArgumentParser
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NoReturn

from ..errors import UsageError
from .closed_loop import ClosedLoop, assignments, chosen_presets, closed_loop
from .scenarios import Scenario


@dataclass(frozen=True)
class Variant:
    """What one run flies, as the options of `ahv run` say it."""
    name: str
    controller: str = "neural"
    plant: str | None = None
    preset: str | None = None
    uncertainty: float | None = None
    set: Sequence[str] = ()

    def loop(self, plan: Scenario, plant: str, flavour: str) -> ClosedLoop:
        """Its closed loop; `plant` is that of a variant that names none. Raises UsageError as `closed_loop` does."""
        try:
            return closed_loop(plan, self.controller, self.plant or plant, flavour, chosen_presets(self.preset),
                               assignments(self.set), self.uncertainty)
        except UsageError as error:
            raise UsageError(f"--run {self.name}: {error}") from None


class Words(ArgumentParser):
    """A parser whose complaints are UsageErrors."""

    def error(self, message: str) -> NoReturn:
        raise UsageError(f"{self.prog}: {message.rstrip('.')}. {ALLOWED}")


ALLOWED = "A run takes --controller, --preset, --plant, --uncertainty and --set."


def variant(word: str) -> Variant:
    """The variant that `NAME:OPTIONS` says, for example `mine:--preset robust --set controller.k_gamma=0.3`. Raises
    UsageError for anything else."""
    name, colon, options = word.partition(":")
    if not colon or not name.strip():
        raise UsageError(f"--run {word} is not of the form NAME:OPTIONS, for example \"mine:--preset robust\".")
    parser = Words(prog=f"--run {name.strip()}", add_help=False, allow_abbrev=False)
    for option in ("controller", "plant", "preset"):
        parser.add_argument(f"--{option}")
    parser.add_argument("--uncertainty", type=float)
    parser.add_argument("--set", action="append")
    try:
        words = shlex.split(options)
    except ValueError as error:
        raise UsageError(f"--run {word}: {str(error).lower()}.") from None
    found: dict[str, Any] = vars(parser.parse_args(words))
    return Variant(name.strip(), **{key: value for key, value in found.items() if value is not None})
