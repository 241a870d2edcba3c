"""A YAML file with line numbers, so that what is wrong in it is said by file, line and field.

    source = Source(Path("case.yaml"), "scenario file")
    scenario = source.load(Scenario)               # a pydantic model
    with source.at("set", "plant.mass"):           # UsageError and ValueError in here are on that line
        check(scenario)
"""
from collections.abc import Iterator
from contextlib import contextmanager
from os.path import isfile  # unlike Path.is_file, false for a name that no file can have
from pathlib import Path
from typing import Any, NoReturn, TypeVar

import yaml
from pydantic import BaseModel, ValidationError

from .errors import UsageError, nearest

Place = tuple[str | int, ...]  # keys and indices from the top
Model = TypeVar("Model", bound=BaseModel)
MOST_BYTES, MOST_VALUES, DEEPEST = 1_000_000, 100_000, 50
# What PyYAML raises where a value does not fit its type, as in `!!int x`: it tries.
NO_VALUE = (ValueError, LookupError, AttributeError, TypeError, ArithmeticError)


class Located(UsageError):
    """A UsageError whose message has file and line already."""


class Loader(yaml.SafeLoader):
    """PyYAML's safe loader with limits: what a few lines of aliases stand for counts as if it were written out."""

    def __init__(self, text: str):
        super().__init__(text)
        self.depth = self.count = 0
        self.sizes: dict[int, int] = {}  # of each node that is complete: the values in it

    def compose_node(self, parent: Any, index: Any) -> Any:
        """A node and all below it. Raises MarkedYAMLError beyond a limit."""
        mark, alias, before = self.peek_event().start_mark, self.check_event(yaml.AliasEvent), self.count
        self.depth += 1
        if self.depth > DEEPEST:
            raise yaml.MarkedYAMLError(None, None, f"it is nested more than {DEEPEST} levels deep", mark)
        node = super().compose_node(parent, index)
        self.depth -= 1
        self.count += self.sizes.get(id(node), 1) if alias else 1  # none yet: an alias within what it stands for
        if not alias:
            self.sizes[id(node)] = self.count - before
        if isinstance(node, yaml.ScalarNode) and any("\ud800" <= c <= "\udfff" for c in node.value):
            raise yaml.MarkedYAMLError(None, None, "half of a pair of code units (\\ud800 to \\udfff) is no text", mark)
        if self.count > MOST_VALUES:
            raise yaml.MarkedYAMLError(None, None, f"there are more than {MOST_VALUES} values, those of aliases "
                                                   "included", mark)
        return node


class Source:
    """The YAML file at `path`, which messages call `what`.

    Raises UsageError if there is none, if it is not YAML or too large, or if a key is given twice.
    """

    def __init__(self, path: Path, what: str = "file"):
        self.path = path
        if not isfile(path):
            raise UsageError(f"There is no {what} {path}.")
        try:
            with path.open("rb") as file:
                content = file.read(MOST_BYTES + 1)
            if len(content) > MOST_BYTES:
                raise UsageError(f"{path} is too large: a {what} has at most {MOST_BYTES // 1000} kB.")
            self.read(content.decode("utf-8-sig"))
        except UnicodeDecodeError:
            raise UsageError(f"{path} is not text.") from None
        except OSError as error:
            raise UsageError(f"{path} cannot be read: {error.strerror}.") from None
        except yaml.MarkedYAMLError as error:
            line = error.problem_mark.line + 1 if error.problem_mark else 1
            raise UsageError(f"{path}, line {line}: this is not YAML: {error.problem}.") from None
        except yaml.YAMLError as error:
            raise UsageError(f"{path} is not YAML: {' '.join(str(error).split())}") from None

    def read(self, text: str) -> None:
        """Take the document `text`. Raises UsageError for a key given twice, and what PyYAML raises."""
        loader = Loader(text)
        try:
            self.root = loader.get_single_node()
            self.check_keys(self.root)
            self.data = self.values(loader)
        finally:
            loader.dispose()

    def values(self, loader: Loader) -> Any:
        """The document as plain data. Raises UsageError for a value that does not fit its type."""
        try:
            return None if self.root is None else loader.construct_document(self.root)
        except NO_VALUE as error:
            raise UsageError(f"{self.path}: a value does not fit its type: {' '.join(str(error).split())}.") from None

    def check_keys(self, node: Any, place: Place = (), above: tuple[int, ...] = ()) -> None:
        """Raises UsageError for a key given twice, which YAML lets win silently, and for an anchor inside itself."""
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
        """(line, keys) of `place`, or of as much of it as is in the file."""
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
        """Raises UsageError "FILE, line N: FIELD: MESSAGE" for the field at `place`."""
        line, known = self.find(place)
        field = ".".join(map(str, known))
        end = "" if message.endswith("?") else "."
        where = f"{field}: " if field else ""
        raise Located(f"{self.path}, line {line}: {where}{message.rstrip('.')}{end}") from None

    @contextmanager
    def at(self, *place: str | int) -> Iterator[None]:
        """UsageError and ValueError raised inside get file, line and field of `place`."""
        try:
            yield
        except Located:
            raise
        except (UsageError, ValueError) as error:
            self.fail(place, str(error))

    def load(self, model: type[Model]) -> Model:
        """The file as a `model`. Raises UsageError with line and field for the first thing that is wrong."""
        try:
            return model.model_validate(self.data)
        except ValidationError as error:
            found = error.errors()  # a misspelt field is also reported as missing: the misspelling is the cause
            first = next((e for e in found if e["type"] == "extra_forbidden"), found[0])
            self.fail(*complaint(first, list(model.model_fields)))


def complaint(error: Any, fields: list[str]) -> tuple[Place, str]:
    """Where and what, of one of pydantic's errors; `fields` are those of the whole file."""
    place, kind = error["loc"], error["type"]
    message = error["msg"].removeprefix("Value error, ")
    if kind == "missing":
        return place[:-1], f"{place[-1]} is missing"
    if kind == "extra_forbidden":
        near = nearest(str(place[-1]), fields) if len(place) == 1 else None
        return place, f"there is no such field{f'; did you mean {near}?' if near else ''}"
    if kind in ("union_tag_not_found", "union_tag_invalid"):
        context = error["ctx"]
        discriminator = context["discriminator"].strip("'")
        if kind == "union_tag_not_found":
            return place, f"{discriminator} is missing"
        return place, f"there is no {discriminator} {context['tag']}; there are {context['expected_tags']}"
    if kind == "too_short":
        return place, f"at least {error['ctx']['min_length']} must be given"
    if kind != "value_error" and not isinstance(error.get("input"), dict | list):
        message += f", not {error.get('input')!r}"
    return place, message
