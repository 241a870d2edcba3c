"""What the rules look at: an unpacked FMU. What they find: faults."""
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from ..master.description import Description


class Fault(NamedTuple):
    """What a static check yields: which variable (or unit, type, file), what is there, what should be there."""
    variable: str
    found: str
    expected: str


@dataclass
class Fmu:
    """An unpacked FMU: `members` are the archive's names, `encoding` is what the XML declaration says (or None)."""
    path: Path
    folder: Path
    members: list[str]
    description: Description
    encoding: str | None
    schema_faults: list[Fault] = field(default_factory=list)

    @property
    def identifier(self) -> str:
        """modelIdentifier of the co-simulation interface (4.3.1), which also names the binaries."""
        return (self.description.co_simulation or {}).get("modelIdentifier", "")
