"""What columns are called on pages and pictures: names with units, and what the FMUs say of them."""
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from .dispersions import Fmus

LONGEST = 60  # characters of a description that an axis has room for


@dataclass(frozen=True)
class Label:
    """Of one column: its name in the table, its unit (empty without one) and the FMU's description of it."""
    name: str
    unit: str = ""
    description: str = ""

    @property
    def said(self) -> str:
        """All of it in a line."""
        return ", ".join(filter(None, (f"{self.name} ({self.unit})" if self.unit else self.name, self.description)))


def labels_of(names: Iterable[str], files: Fmus) -> dict[str, Label]:
    """Of variables component.variable; what no FMU has is called by its name alone."""
    found = {}
    for name in names:
        component, _, word = name.partition(".")
        variable = files[component].variables.get(word) if component in files else None
        found[name] = Label(name) if variable is None else Label(
            name, "" if variable.unit in (None, "1") else variable.unit, " ".join(variable.description.split()))
    return found


def of_difference(name: str) -> Label:
    """Of a difference of two phases, as `statistics.with_differences` calls it."""
    first, second = (part.rpartition(".")[2].removesuffix("_sine_phase") for part in name.split(" - "))
    return Label(name, "rad", f"{first}, {second}: difference of the phases")


def on_axes(names: Iterable[str], labels: Mapping[str, Label]) -> dict[str, str]:
    """What stands on an axis for each name: the FMU's description where it is short and no other's, else the name; with
    the unit."""
    found = {name: labels[name] if name in labels else of_difference(name) if " - " in name else Label(name)
             for name in names}
    said = Counter(label.description for label in found.values())
    words = {name: label.description if 0 < len(label.description) <= LONGEST and said[label.description] == 1 else name
             for name, label in found.items()}
    return {name: f"{words[name]} ({label.unit})" if label.unit else words[name] for name, label in found.items()}
