"""A campaign file as text: what it says, and on which line."""
from collections.abc import Iterator
from contextlib import contextmanager
from difflib import get_close_matches
from pathlib import Path
from typing import Any, NoReturn

import yaml
from pydantic import ValidationError

from ..errors import UsageError
from .spec import Campaign

Place = tuple[str | int, ...]  # keys and indices from the top


class Located(UsageError):
    """One that names its line already."""


class Source:
    """A YAML file; complaints name the line and the field."""

    def __init__(self, path: Path):
        self.path = path
        if not path.is_file():
            raise UsageError(f"There is no campaign file {path}.")
        try:
            text = path.read_text()
            self.root = yaml.compose(text, Loader=yaml.SafeLoader)
            self.check_keys(self.root)
            self.data = yaml.safe_load(text)
        except UnicodeDecodeError:
            raise UsageError(f"{path} is not text.") from None
        except OSError as error:
            raise UsageError(f"{path} cannot be read: {error.strerror}.") from None
        except yaml.MarkedYAMLError as error:
            line = error.problem_mark.line + 1 if error.problem_mark else 1
            raise UsageError(f"{path}, line {line}: this is not YAML: {error.problem}.") from None
        except (yaml.YAMLError, RecursionError, ValueError) as error:
            raise UsageError(f"{path} is not YAML: {' '.join(str(error).split())}") from None

    def check_keys(self, node: Any, place: Place = (), above: tuple[int, ...] = ()) -> None:
        """A key given twice would silently win over the first; an anchor inside itself has no end."""
        if id(node) in above:
            self.fail(place, "it contains itself")
        if isinstance(node, yaml.MappingNode):
            seen: set[str] = set()
            for key, child in node.value:
                if not isinstance(key, yaml.ScalarNode):
                    self.fail(place, "a key must be a word")
                if key.value in seen:
                    raise UsageError(f"{self.path}, line {key.start_mark.line + 1}: "
                                     f"{'.'.join(map(str, (*place, key.value)))} is given twice.")
                seen.add(key.value)
                self.check_keys(child, (*place, key.value), (*above, id(node)))
        elif isinstance(node, yaml.SequenceNode):
            for i, child in enumerate(node.value):
                self.check_keys(child, (*place, i), (*above, id(node)))

    def find(self, place: Place) -> tuple[int, Place]:
        """(line of the nearest thing at or above `place` that is in the file, the parts of `place` that are keys)."""
        node, line, known = self.root, 1, []
        for part in place:
            if isinstance(node, yaml.MappingNode):
                for key, child in node.value:
                    if key.value == str(part):
                        node, line = child, key.start_mark.line + 1
                        known.append(part)
                        break
            elif isinstance(node, yaml.SequenceNode) and isinstance(part, int) and part < len(node.value):
                node = node.value[part]
                line = node.start_mark.line + 1
                known.append(part)
        return line, tuple(known)

    def fail(self, place: Place, message: str) -> NoReturn:
        line, known = self.find(place)
        field = ".".join(map(str, known))
        end = "" if message.endswith("?") else "."
        where = f"{field}: " if field else ""
        raise Located(f"{self.path}, line {line}: {where}{message.rstrip('.')}{end}") from None

    @contextmanager
    def at(self, *place: str | int) -> Iterator[None]:
        """What is complained of inside is on the line of `place`."""
        try:
            yield
        except Located:
            raise
        except (UsageError, ValueError) as error:
            self.fail(place, str(error))

    def campaign(self) -> Campaign:
        """What the file says. Raises UsageError with line and field for the first thing that is wrong."""
        try:
            return Campaign.model_validate(self.data)
        except ValidationError as error:
            found = error.errors()  # a misspelt field is missing, too, but that is not what to say
            first = next((e for e in found if e["type"] == "extra_forbidden"), found[0])
            return self.fail(*complaint(first))


def complaint(error: Any) -> tuple[Place, str]:
    """Where and what, of one of pydantic's errors."""
    place, kind = error["loc"], error["type"]
    message = error["msg"].removeprefix("Value error, ")
    if kind == "missing":
        return place[:-1], f"{place[-1]} is missing"
    if kind == "extra_forbidden":
        near = get_close_matches(str(place[-1]), Campaign.model_fields, 1) if len(place) == 1 else []
        return place, f"there is no such field{f'; did you mean {near[0]}?' if near else ''}"
    if kind == "union_tag_not_found":
        return place, "distribution is missing"
    if kind == "union_tag_invalid":
        return place, f"there is no distribution {error['ctx']['tag']}; there are {error['ctx']['expected_tags']}"
    if kind != "value_error" and not isinstance(error.get("input"), dict | list):
        message += f", not {error.get('input')!r}"
    return place, message
