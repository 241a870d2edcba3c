"""What an FMU says of itself, of any FMI version: its variables, presets, platforms and capabilities."""
from dataclasses import asdict, dataclass
from os import PathLike
from pathlib import Path
from typing import Any

from ..errors import UsageError, did_you_mean
from ..temporary import Folder
from ..text import html_table, html_text, printable, text_table
from .declared import Variable as Declared
from .declared import is_true, number
from .description import Description, read
from .fmu import settable
from .system import Value, as_path
from .unpack import BadArchive, safe_extract

KINDS = {"CoSimulation": "co-simulation", "ModelExchange": "model exchange",
         "ScheduledExecution": "scheduled execution"}
CAUSALITIES = ("input", "output", "structuralParameter", "parameter", "calculatedParameter", "independent", "local")
COUNTED = ("maxOutputDerivativeOrder", "fixedInternalStepSize", "recommendedIntermediateInputSmoothness")
HEADINGS = ("name", "unit", "start", "min", "max", "description")


@dataclass(frozen=True)
class Variable:
    """One variable as the FMU declares it; what it leaves out is empty, or None. Values are in `unit`."""
    name: str
    causality: str
    variability: str
    type: str
    unit: str
    display_unit: str
    start: Value | None
    min: float | None
    max: float | None
    settable: bool       # before the flight: a parameter, an input, a start value
    description: str


@dataclass(frozen=True)
class FmuInfo:
    """One FMU as it describes itself; `str` gives a table for a terminal, a notebook shows one of its own."""
    path: Path
    name: str
    description: str
    fmi_version: str
    kinds: tuple[str, ...]                  # co-simulation, model exchange, scheduled execution
    version: str
    author: str
    copyright: str
    license: str
    generation_tool: str
    generated_at: str
    platforms: tuple[str, ...]              # folders of binaries/
    default_experiment: dict[str, float]    # start, stop, step (s), tolerance: those that are declared
    capabilities: dict[str, float | bool]   # of co-simulation if it has that: those that are claimed
    presets: tuple[str, ...]                # SSP parameter sets in resources/presets/
    variables: tuple[Variable, ...]

    def __getitem__(self, name: str) -> Variable:
        """The variable called `name`. Raises UsageError if there is none."""
        known = {v.name: v for v in self.variables}
        if name not in known:
            raise UsageError(f"{self.path.name} has no variable {name}{did_you_mean(name, known)}")
        return known[name]

    def to_dict(self) -> dict[str, Any]:
        """The same as plain data for JSON."""
        return {**asdict(self), "path": str(self.path)}

    def facts(self) -> list[tuple[str, str]]:
        """Label and text of everything that is declared beside the variables."""
        texts = (("description", self.description), ("file", str(self.path)),
                 ("FMI", f"{self.fmi_version}, {' and '.join(self.kinds)}"),
                 ("version", self.version), ("author", self.author), ("copyright", self.copyright),
                 ("license", self.license), ("made by", f"{self.generation_tool} {self.generated_at}".strip()),
                 ("platforms", ", ".join(self.platforms)),
                 ("default experiment", ", ".join(f"{k} {x:g}" for k, x in self.default_experiment.items())),
                 ("capabilities", ", ".join(k if x is True else f"{k} {x:g}" for k, x in self.capabilities.items())),
                 ("presets", ", ".join(self.presets)))
        return [(label, text) for label, text in texts if text]

    def groups(self) -> list[tuple[str, list[tuple[Any, ...]]]]:
        """Causality, and a row for each of its variables, in the order of HEADINGS."""
        found = [(c, [(v.name, v.unit, v.start, v.min, v.max, v.description) for v in self.variables
                      if v.causality == c]) for c in CAUSALITIES]
        return [(causality, rows) for causality, rows in found if rows]

    def __str__(self) -> str:
        lines = [printable(self.name), *(printable(f"  {label}: {text}") for label, text in self.facts())]
        for causality, rows in self.groups():
            lines += ["", *text_table((f"{causality} ({len(rows)})", *HEADINGS[1:]), rows)]
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        tables = [html_table(HEADINGS, [(f"{causality} ({len(rows)})", *[None] * 5), *rows])
                  for causality, rows in self.groups()]
        return f"<p><b>{html_text(self.name)}</b></p>{html_table(('', ''), self.facts())}{''.join(tables)}"


def info(path: str | PathLike[str]) -> FmuInfo:
    """What the FMU at `path` declares, without running it.

    Raises UsageError if there is no such file, or if it cannot be read as an FMU.
    """
    path = as_path(path)
    with Folder() as folder:
        try:
            members = safe_extract(path, folder.path)
            return described(path, read(folder.path), members)
        except BadArchive as error:
            raise UsageError(f"{path} cannot be opened: {error}.") from None
        except ValueError as error:
            raise UsageError(f"{path} cannot be read as an FMU: {printable(str(error))}.") from None


def described(path: Path, d: Description, members: list[str]) -> FmuInfo:
    """The info of the FMU at `path` from its description and the names of its files."""
    places = [name.split("/") for name in members]
    said = {word: d.attributes.get(word, "") for word in (
        "modelName", "description", "version", "author", "copyright", "license", "generationTool",
        "generationDateAndTime")}
    old = "co-simulation" if d.root.find("Implementation") is not None else "model exchange"  # FMI 1.0
    found = {old: {}} if d.version == "1.0" else {
        kind: claims for tag, kind in KINDS.items() if (claims := d.attributes_at(tag)) is not None}
    times = {word: number(d.experiment.get(attribute)) for word, attribute in (
        ("start", "startTime"), ("stop", "stopTime"), ("step", "stepSize"), ("tolerance", "tolerance"))}
    return FmuInfo(
        path, said["modelName"], said["description"], d.version, tuple(found), said["version"], said["author"],
        said["copyright"], said["license"], said["generationTool"], said["generationDateAndTime"],
        tuple(sorted({p[1] for p in places if p[0] == "binaries" and len(p) > 2})),
        {word: x for word, x in times.items() if x is not None},
        claimed(next(iter(found.values()), {})),
        tuple(sorted(p[2].removesuffix(".ssv") for p in places
                     if p[:2] == ["resources", "presets"] and len(p) == 3 and p[2].endswith(".ssv"))),
        tuple(variable(v) for v in d.variables))


def claimed(interface: dict[str, str]) -> dict[str, float | bool]:
    """The capabilities that an interface claims: its attributes that are true, or a number other than 0."""
    values = {name: number(text) if name in COUNTED else is_true(text) for name, text in interface.items()}
    return {name: value for name, value in values.items() if value}


def variable(v: Declared) -> Variable:
    """A variable as the FMU declares it."""
    return Variable(v.name, v.causality, v.variability, v.type, v.unit, v.display_unit, start(v), v.min, v.max,
                    settable(v), v.description)


def start(v: Declared) -> Value | None:
    """The start value in the type of the variable; as a text if it is an array, or no such value."""
    text = v.start
    if text is None or v.type in ("String", "Binary"):
        return text
    if v.type == "Boolean":
        return {"true": True, "1": True, "false": False, "0": False}.get(text.strip(), text)
    found = number(text)
    return text if found is None else found if v.type in ("Real", "Float32", "Float64") else int(found)
