"""What can go wrong, in two kinds: the user's words, and the run itself; and the word that was probably meant."""
import signal
from collections.abc import Iterable
from difflib import get_close_matches


class UsageError(Exception):
    """A request that cannot be carried out as it stands; one sentence. Exit status 2."""


class RunError(Exception):
    """A run that ended early; one sentence that names the FMU, the time and the reason. Exit status 1."""


class Interrupted(RunError):
    """Ctrl-C or another signal, `number`, ended a run; what was computed until then is kept. Exit status 128 + it."""

    def __init__(self, sentence: str, number: int = signal.SIGINT):
        super().__init__(sentence)
        self.number = number


def nearest(word: str, known: Iterable[str], similarity: float = 0.6) -> str | None:
    """The one of `known` that is most like `word`; None if none reaches `similarity` (0 to 1, difflib's ratio)."""
    return next(iter(get_close_matches(word, list(known), 1, similarity)), None)


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """The end of a sentence about an unknown `word`: a question with the nearest of `known`, or a full stop."""
    near = nearest(word, known, 0.4)
    return f"; did you mean {near}?" if near else "."
