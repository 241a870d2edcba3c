"""The versions of FMI that fly: all else in this room says `instance.standard` where they differ."""
from typing import TYPE_CHECKING, Protocol

from . import fmi2, fmi3

if TYPE_CHECKING:
    from .instance import Instance


class Standard(Protocol):
    """What `fmi2` and `fmi3` say."""
    PREFIX: str                       # of all functions
    TOKEN: str                        # the attribute by which an FMU is known
    PLATFORM: str                     # this machine's folder of binaries/
    STATE: str                        # what Get..., Set... and Free... call a state
    DESERIALIZE: str                  # what the call is named that reads one from bytes
    COUNTS_VALUES: bool               # whether Get... and Set... are told the number of values
    TYPES: dict[str, tuple[str, int]]  # type of a variable -> what Get... and Set... call it, kind of group (`program`)

    def instantiate(self, instance: "Instance") -> int | None:
        """Make the instance; where it is, or None. Says in `instance.uses_events` whether it has an event mode."""

    def enter(self, instance: "Instance", start: float, stop: float | None, tolerance: float | None) -> None:
        """From instantiated to Initialization Mode; times in s. Raises RunError."""

    def leave(self, instance: "Instance", start: float) -> None:
        """From Initialization Mode to ready to step, in model exchange to Continuous-Time Mode. Raises RunError."""

    def ended_at(self, instance: "Instance", begun: float, until: float) -> float | None:
        """See `Instance.ended_at`."""


def standard(version: str) -> Standard:
    """The standard of an FMU that says this version."""
    return fmi3 if version.startswith("3.") else fmi2
