"""Samples of one's own: a file with a column for each variable and a row for each run.

The file is read once, a part at a time, and checked: what is missing, no number or of another type is told with its row
and column. Its values are then in an Arrow file, of which a worker reads the rows that it flies; they are exactly those
of the user's file.
"""
import csv
import hashlib
import math
import weakref
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from itertools import islice
from os.path import isfile
from pathlib import Path
from typing import Any

from ..errors import UsageError
from ..master.system import Value
from ..temporary import Folder, troubles

GROUP = 4096         # rows that are in memory at a time
MOST_WORDS = 10_000  # different words in a column
# pyarrow is imported where it is used: a worker without samples needs 28 MB less.
ARROW = {"Real": "float64", "Integer": "int64", "Boolean": "bool", "String": "string"}
WANTED = {"Real": "a finite number", "Integer": "a whole number", "Boolean": "true or false", "String": "a text"}
FITS = {"Real": ("is_floating", "is_integer"), "Integer": ("is_integer",), "Boolean": ("is_boolean",),
        "String": ("is_string", "is_large_string")}  # of pyarrow.types


def plain(value: Any) -> Any:
    """The value. Raises ValueError for a text such as 1_000, which Python takes for a number and others do not."""
    if isinstance(value, str) and "_" in value:
        raise ValueError
    return value


def real(value: Any) -> float:
    """Raises ValueError unless `value` is a finite number that a double holds exactly, or the text of a number."""
    found = float(plain(value))
    if not math.isfinite(found) or (isinstance(value, int) and int(found) != value):
        raise ValueError
    return found


def whole(value: Any) -> int:
    """Raises ValueError unless `value` is a whole number of 64 bits, or the text of one."""
    value = plain(value)
    try:
        found = int(value)
    except ValueError:
        found = int(size := float(value))
        if found != size:
            raise
    if not -2**63 <= found < 2**63:
        raise ValueError
    return found


def truth(value: Any) -> bool:
    """Raises KeyError unless `value` is true or false, or a word for it."""
    return {"true": True, "1": True, "false": False, "0": False}[str(value).lower()]


PARSERS: dict[str, Callable[[Any], Value]] = {"Real": real, "Integer": whole, "Boolean": truth, "String": str}


@dataclass
class Column:
    """What is known of a column: its least and greatest number, or all its words, each with the row that has it."""
    name: str                                                # in the file
    draw: str                                                # the name of the draw that it is
    kind: str                                                # a key of ARROW
    seen: dict[Value, int] = field(default_factory=dict)     # value -> row, from 1

    def add(self, values: list[Value], before: int) -> None:
        """Take further values, the first one of row `before` + 1. Raises ValueError for too many words."""
        candidates = {min(values), max(values)} if self.kind in ("Real", "Integer") else set(values)
        for value in candidates - self.seen.keys():
            self.seen[value] = before + values.index(value) + 1
        if self.kind in ("Real", "Integer"):
            self.seen = {x: self.seen[x] for x in (min(self.seen), max(self.seen))}  # type: ignore[type-var]
        if len(self.seen) > MOST_WORDS:
            raise ValueError(f"{self.name} has more than {MOST_WORDS:,} different words")


@dataclass(frozen=True)
class Samples:
    """The rows of a file of samples, which has been checked, as the Arrow file `folder` / `stored`."""
    file: str                    # as the campaign file calls it
    sha256: str                  # of that file
    rows: int
    columns: tuple[Column, ...]
    stored: str                  # SHA256/samples.arrow
    folder: Path

    @property
    def path(self) -> Path:
        """The Arrow file."""
        return self.folder / self.stored

    def at(self, folder: Path) -> "Samples":
        """The same where the Arrow file is below `folder`."""
        return replace(self, folder=folder)

    def read(self, first: int, last: int) -> Iterator[dict[str, Value]]:
        """The values of rows first ... last - 1, counted from 0, by the draws' names."""
        import pyarrow as pa

        with pa.memory_map(str(self.path)) as source, pa.ipc.open_file(source) as reader:
            for group in range(first // GROUP, (last - 1) // GROUP + 1 if last > first else 0):
                begin = max(first - group * GROUP, 0)
                yield from reader.get_batch(group).slice(begin, min(last - group * GROUP, GROUP) - begin).to_pylist()


@contextmanager
def reading(path: Path) -> Iterator[None]:
    """Around the reading of `path`. Raises UsageError for what is no table."""
    from pyarrow import ArrowException

    try:
        yield
    except UnicodeDecodeError:
        raise UsageError(f"{path} is not text.") from None
    except (ArrowException, csv.Error, OSError) as error:
        raise UsageError(f"{path} cannot be read: {' '.join(str(error).split()).rstrip('.')}.") from None


def header(path: Path) -> list[str]:
    """The names of the columns of a .csv or .parquet file.

    Raises UsageError if there is no such file, it is no table, or a name is missing or there twice.
    """
    if not isfile(path):
        raise UsageError(f"There is no file {path}.")
    if path.suffix.lower() not in (".csv", ".parquet"):
        raise UsageError(f"{path} is not a table: its name must end with .csv or .parquet.")
    with reading(path):
        if path.suffix.lower() == ".parquet":
            from pyarrow.parquet import read_schema

            names = list(read_schema(path).names)
        else:
            with path.open(newline="", encoding="utf-8-sig") as text:
                names = [name.strip() for name in next(csv.reader(text), [])]
    for i, name in enumerate(names, 1):
        if not name:
            raise UsageError(f"{path}: column {i} has no name.")
        if names.count(name) > 1:
            raise UsageError(f"{path} has two columns called {name}.")
    if not names:
        raise UsageError(f"{path} has no columns.")
    return names


def parts(path: Path, kinds: Mapping[str, str]) -> Iterator[list[list[Any]]]:
    """The columns in `kinds` of the file, GROUP rows at a time, as texts of a CSV file or values of a Parquet file.

    Raises UsageError for a row of another length, or a column of another type than its kind.
    """
    names = list(kinds)
    if path.suffix.lower() == ".parquet":
        from pyarrow import types
        from pyarrow.parquet import ParquetFile

        with reading(path), ParquetFile(path, memory_map=True) as table:
            for name in names:
                kind = table.schema_arrow.field(name).type
                if not any(getattr(types, fits)(kind) for fits in FITS[kinds[name]]):
                    raise UsageError(f"{path}: {name} holds {kind}; each value must be {WANTED[kinds[name]]}.")
            held: list[list[Any]] = [[] for _ in names]
            for batch in table.iter_batches(GROUP, columns=names):  # shorter ones where a row group ends
                held = [some + batch.column(name).to_pylist() for some, name in zip(held, names)]
                if len(held[0]) >= GROUP:
                    yield [some[:GROUP] for some in held]
                    held = [some[GROUP:] for some in held]
            if held[0]:
                yield held
        return
    with reading(path), path.open(newline="", encoding="utf-8-sig") as text:
        rows = (row for row in csv.reader(text) if row)
        head = [name.strip() for name in next(rows)]
        places, before = [head.index(name) for name in names], 0
        while group := list(islice(rows, GROUP)):
            for i, row in enumerate(group, before + 1):
                if len(row) != len(head):
                    raise UsageError(f"{path}: row {i} has {len(row)} values, not {len(head)}.")
            yield [[row[place].strip() for row in group] for place in places]
            before += len(group)


def parsed(path: Path, column: str, kind: str, given: list[Any], before: int) -> list[Value]:
    """Values of a column of the file, the first one of row `before` + 1.

    Raises UsageError for the first that is missing or not of its kind.
    """
    parser = PARSERS[kind]
    try:
        if None not in given and (kind == "String" or "" not in given):
            return list(map(parser, given))
    except (ValueError, KeyError, OverflowError):
        pass
    for row, value in enumerate(given, before + 1):
        if value is None or value == "":
            raise UsageError(f"{path}: {column} in row {row} is empty; it must be {WANTED[kind]}.")
        try:
            parser(value)
        except (ValueError, KeyError, OverflowError):
            raise UsageError(f"{path}: {column} in row {row} is {value}; it must be {WANTED[kind]}.") from None
    raise AssertionError(column)


def load(path: Path, file: str, columns: tuple[Column, ...]) -> Samples:
    """The samples in `path`, which the campaign calls `file`; fills `columns`, which are all of the file's.

    Raises UsageError for what is wrong with the file, with row and column.
    """
    import pyarrow as pa

    schema = pa.schema([(c.draw, pa.type_for_alias(ARROW[c.kind])) for c in columns])
    with troubles((folder := Folder()).path):
        rows, draft = 0, folder.path / "samples.arrow"
        with pa.OSFile(str(draft), "wb") as sink, pa.ipc.new_file(sink, schema) as writer:
            for part in parts(path, {c.name: c.kind for c in columns}):
                values = [parsed(path, c.name, c.kind, given, rows) for c, given in zip(columns, part)]
                for column, some in zip(columns, values):
                    column.add(some, rows)
                writer.write_batch(pa.record_batch([pa.array(v, f.type) for v, f in zip(values, schema)],
                                                   schema=schema))
                rows += len(values[0])
        if not rows:
            raise UsageError(f"{path} has no rows.")
        stored = f"{sha256_of(draft)}/{draft.name}"
        (folder.path / stored).parent.mkdir()
        draft.rename(folder.path / stored)
    found = Samples(file, sha256_of(path), rows, columns, stored, folder.path)
    weakref.finalize(found, folder.__exit__)  # which holds the folder until then
    return found


def measured(path: Path, column: str) -> list[Value]:
    """The numbers in a column of a .csv or .parquet file. Raises UsageError for what is wrong with it."""
    names = header(path)
    if column not in names:
        raise UsageError(f"{path} has no column {column}; there are {', '.join(names)}.")
    found: list[Value] = []
    for part in parts(path, {column: "Real"}):
        found += parsed(path, column, "Real", part[0], len(found))
    if not found:
        raise UsageError(f"{path} has no rows.")
    return found


def sha256_of(path: Path) -> str:
    """The SHA-256 of a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
