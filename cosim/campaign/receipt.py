"""Receipts: JSON files that say which tables belong together, with row count and SHA-256 of each.

A receipt is written after its tables. A table that is missing, cut, changed or exchanged does not fit it any more.
"""
import hashlib
from pathlib import Path

from pydantic import BaseModel, ValidationError

from ..master.whole_file import whole


class Table(BaseModel):
    """A table's entry."""
    rows: int
    sha256: str

    @classmethod
    def of(cls, path: Path, rows: int) -> "Table":
        """The entry of the file at `path`. Raises OSError if it cannot be read."""
        with path.open("rb") as file:
            return cls(rows=rows, sha256=hashlib.file_digest(file, "sha256").hexdigest())


class Receipt(BaseModel):
    """The tables of one task, or of a whole campaign: runs first ... last - 1."""
    campaign: str                # the key of its job
    first: int
    last: int
    successes: int
    tables: dict[str, Table]     # by kind

    @classmethod
    def read(cls, path: Path) -> "Receipt":
        """The receipt at `path`. Raises ValueError, in words, if there is none."""
        try:
            return cls.model_validate_json(path.read_bytes())
        except FileNotFoundError:
            raise ValueError(f"{path.name} is missing") from None
        except (OSError, ValidationError):
            raise ValueError(f"{path.name} is damaged") from None

    def write(self, path: Path) -> None:
        """Write it. Raises RunError if it cannot be written."""
        with whole(path) as partial:
            partial.write_text(self.model_dump_json(indent=2) + "\n")

    def check(self, kind: str, path: Path) -> None:
        """Raises ValueError, in words, unless the table of this kind is at `path` as it was written."""
        try:
            found = Table.of(path, self.tables[kind].rows)
        except FileNotFoundError:
            raise ValueError(f"{path.name} is missing") from None
        except OSError as error:
            raise ValueError(f"{path.name} cannot be read ({error.strerror})") from None
        if found != self.tables[kind]:
            raise ValueError(f"{path.name} is damaged")
