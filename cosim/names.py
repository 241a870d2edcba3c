"""The rule for names that users give to campaigns, scenarios, systems and laws.

Folders and files are called by these names, so a name is never a path, and nothing that a terminal, a figure or a file
system takes for more than a name.
"""
import re
from collections import Counter
from collections.abc import Iterable

from .errors import UsageError

LONGEST = 64  # bytes in UTF-8
PATTERN = re.compile(r"\w(?:[\w .-]*[\w-])?")
RULE = (f"it must have 1 to {LONGEST} letters, digits, _, -, . and spaces, begin with a letter, a digit or _, and not "
        f"end with a space or a dot")


def is_name(text: str) -> bool:
    """Whether `text` follows the rule."""
    return bool(PATTERN.fullmatch(text)) and len(text.encode()) <= LONGEST


def checked(text: str) -> str:
    """`text` itself. Raises ValueError unless it follows the rule."""
    if not is_name(text):
        raise ValueError(f"the name {shortened(text)} is not allowed: {RULE}")
    return text


def distinct(many: str, given: Iterable[str]) -> None:
    """Raises ValueError for a name that two of the `many` have."""
    for name, count in Counter(given).items():
        if count > 1:
            raise ValueError(f"two {many} are called {name}: give each a name of its own")


def named(what: str, text: str) -> str:
    """`text` itself, the name of a `what`. Raises UsageError unless it follows the rule."""
    if not is_name(text):
        raise UsageError(f"The {what} name {shortened(text)} is not allowed: {RULE}.")
    return text


def shortened(text: str) -> str:
    """`text` as a message shows it."""
    return repr(text if len(text) <= LONGEST else f"{text[:40]}...")


def safe(text: str) -> str:
    """`text` if it follows the rule, else what is like it and does: for files of others, whose names are theirs."""
    found = re.sub(r"[^\w .-]", "_", text).lstrip(" .-")
    while len(found.encode()) > LONGEST:
        found = found[:-1]
    return found.rstrip(" .") or "unnamed"

