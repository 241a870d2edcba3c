"""The probes by name, and how one ends before its end."""
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

from ..fmi2 import STATUS

if TYPE_CHECKING:
    from .bench import Bench

Run = Callable[["Bench"], None]
BOTH = ("2.0", "3.0")
FLYING = ("load", "life")  # the probes without which nothing flies


class CallFailed(Exception):
    """A legal call was refused."""

    def __init__(self, call: str, status: int, where: str):
        super().__init__(f"{call} returned {status_name(status)} {where}")
        self.call = call
        self.status = status


class EndedItself(Exception):
    """The FMU asked to end the simulation (FMI 3.0), which it may do."""


class Stopped(Exception):
    """A probe ends early, for what it has reported: after fmi3Error no more calls are legal (FMI 3.0, 2.2.4)."""


class NoInstance(Exception):
    """fmi2Instantiate returned a null pointer although the GUID was right."""


class Probe(NamedTuple):
    """`legal`: all its calls are legal, so a crash is the FMU's fault beyond doubt; `many`: needs several instances.

    `versions` are those of FMI that it is for.
    """
    name: str
    run: Run
    legal: bool
    many: bool
    versions: tuple[str, ...]


PROBES: dict[str, Probe] = {}


def probe(name: str, legal: bool = True, many: bool = False, versions: tuple[str, ...] = BOTH) -> Callable[[Run], Run]:
    """Register a probe; probes run in the order of registration."""

    def register(run: Run) -> Run:
        PROBES[name] = Probe(name, run, legal, many, versions)
        return run

    return register


def status_name(status: int) -> str:
    """A status as the standard spells it."""
    return STATUS[status] if 0 <= status < len(STATUS) else f"the unknown status {status}"
