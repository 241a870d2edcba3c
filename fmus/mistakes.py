"""A mistake in a model as one sentence."""
from difflib import get_close_matches
from types import ModuleType
from typing import Any


class ModelError(ValueError):
    """A mistake in a model: one sentence, which begins with the model's name."""

    def __init__(self, model: ModuleType, sentence: str, place: str = ""):
        """`sentence` goes on after the model's name, and has no full stop; `place` is a file and a line, or ""."""
        where = f" ({place})" if place else ""
        super().__init__(f"{getattr(model, 'NAME', model.__name__)}: {sentence}{where}.")


def nearest(name: object, known: Any) -> str:
    """What may have been meant by `name`, in brackets."""
    near = get_close_matches(str(name), known, 3)
    return f" (did you mean {' or '.join(near)}?)" if near else f" (there are {', '.join(known) or 'none'})"
