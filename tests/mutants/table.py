"""docs/mutants.md: what `make mutants` found, room by room."""
from pathlib import Path

from points import Mutant


def write_table(root: Path, samples: dict[str, tuple[list[Mutant], int]], known: dict, equivalent: dict) -> None:
    raise NotImplementedError
