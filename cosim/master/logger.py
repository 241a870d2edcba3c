"""What FMUs log: kept for the instance that it belongs to. One logger serves all instances of both versions of FMI."""
from dataclasses import dataclass, field
from itertools import count
from typing import Any

from . import last_call
from .program import OK

MOST_MESSAGES = 1000


@dataclass
class Environment:
    """What the logger is told of an instance by its environment: whose messages these are."""
    name: bytes
    messages: list[str] = field(default_factory=list)  # those of a status other than OK
    callbacks: Any = None                              # alive as long as the instance


ENVIRONMENTS: dict[int, Environment] = {}  # environment -> the instance's; one that cannot be freed stays
NUMBERS = count(1)


def log(environment: int | None, instance: bytes | None, status: int, _category: bytes, message: bytes | None) -> None:
    """Keep a message of a status other than OK."""
    if status == OK:
        return
    text = (message or b"").decode("utf-8", "replace")
    last_call.logged(text)
    mine = ENVIRONMENTS.get(environment or 0)
    if mine is None:  # the FMU hands on something else: its name has to do
        mine = next((e for e in reversed(ENVIRONMENTS.values()) if e.name == instance), None)
    if mine and len(mine.messages) < MOST_MESSAGES:
        mine.messages.append(text)
