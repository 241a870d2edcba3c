"""What the rules look at: an unpacked FMU. What they find: faults."""
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from ..master.description import Description
from .versions import VERSIONS, Version


class Fault(NamedTuple):
    """What a static check yields: which variable (or unit, type, file), what is there, what should be there.

    `impact` if it is milder than the rule's own.
    """
    variable: str
    found: str
    expected: str
    impact: str | None = None


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
    def version(self) -> Version:
        """The version of FMI that it is judged by."""
        return VERSIONS["3.0" if self.description.flat else "2.0"]

    @property
    def identifier(self) -> str:
        """modelIdentifier of the co-simulation interface, which also names the binaries."""
        return (self.description.co_simulation or {}).get("modelIdentifier", "")

    def library(self, platform: str, suffix: str) -> Path | None:
        """The FMU's shared library for a platform, or None. It lies in the FMU, whatever modelIdentifier says."""
        folder = self.folder / "binaries" / platform
        file = folder / f"{self.identifier}{suffix}"
        return file if "\0" not in self.identifier and file.parent == folder and file.is_file() else None
