"""What an FMU says of itself, of any FMI version: its variables, presets, platforms and capabilities."""
import tempfile
from dataclasses import asdict, dataclass
from math import isfinite
from os import PathLike
from pathlib import Path
from typing import Any

import fmpy
from fmpy.model_description import ModelDescription, ScalarVariable

from ..errors import UsageError, did_you_mean
from ..text import html_table, html_text, printable, text_table
from .fmu import settable
from .system import Value, as_path
from .unpack import BadArchive, safe_extract

KINDS = {"coSimulation": "co-simulation", "modelExchange": "model exchange",
         "scheduledExecution": "scheduled execution"}
CAUSALITIES = ("input", "output", "structuralParameter", "parameter", "calculatedParameter", "independent", "local")
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
        texts = (("description", self.description), ("FMI", f"{self.fmi_version}, {' and '.join(self.kinds)}"),
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
    with tempfile.TemporaryDirectory(prefix="ahv_info_") as folder:
        try:
            members = safe_extract(path, Path(folder))
            return described(path, fmpy.read_model_description(folder, validate=False), members)
        except BadArchive as error:
            raise UsageError(f"{path} cannot be opened: {error}.") from None
        except Exception as error:  # fmpy raises whatever it meets
            raise UsageError(f"{path} cannot be read as an FMU: {printable(str(error))}") from None


def described(path: Path, d: ModelDescription, members: list[str]) -> FmuInfo:
    """The info of the FMU at `path` from its description and the names of its files."""
    places = [name.split("/") for name in members]
    found = {kind: getattr(d, kind) for kind in KINDS if getattr(d, kind) is not None}
    claims = vars_of(next(iter(found.values()), None))
    experiment = d.defaultExperiment
    times = {word: number(getattr(experiment, attribute, None)) for word, attribute in (
        ("start", "startTime"), ("stop", "stopTime"), ("step", "stepSize"), ("tolerance", "tolerance"))}
    return FmuInfo(
        path, d.modelName or "", d.description or "", d.fmiVersion or "", tuple(KINDS[k] for k in found),
        d.version or "", d.author or "", d.copyright or "", d.license or "", d.generationTool or "",
        d.generationDateAndTime or "",
        tuple(sorted({p[1] for p in places if p[0] == "binaries" and len(p) > 2})),
        {word: x for word, x in times.items() if x is not None},
        {name: x if isinstance(x, bool) else float(x) for name, x in claims.items()},
        tuple(sorted(p[2].removesuffix(".ssv") for p in places
                     if p[:2] == ["resources", "presets"] and len(p) == 3 and p[2].endswith(".ssv"))),
        tuple(variable(v) for v in d.modelVariables))


def vars_of(interface: Any) -> dict[str, Any]:
    """The capabilities that an interface claims: what differs from nothing, apart from its identifier."""
    names = [a.name for a in getattr(type(interface), "__attrs_attrs__", ())]
    return {name: value for name in names if name != "modelIdentifier" and (value := getattr(interface, name))}


def variable(v: ScalarVariable) -> Variable:
    """A variable as the FMU declares it."""
    names = ("unit", "displayUnit", "min", "max")  # the type's where the variable says nothing
    either = {name: getattr(v, name, None) or getattr(v.declaredType, name, None) for name in names}
    return Variable(v.name, v.causality, v.variability, v.type, either["unit"] or "", either["displayUnit"] or "",
                    start(v), number(either["min"]), number(either["max"]), settable(v), v.description or "")


def start(v: ScalarVariable) -> Value | None:
    """The start value in the type of the variable; as a text if it is an array, or no such value."""
    text: str | None = v.start
    if text is None or v.type in ("String", "Binary"):
        return text
    if v.type == "Boolean":
        return {"true": True, "1": True, "false": False, "0": False}.get(text.strip(), text)
    found = number(text)
    return text if found is None else found if v.type in ("Real", "Float32", "Float64") else int(found)


def number(text: str | None) -> float | None:
    """The finite number that `text` is, else None."""
    try:
        return found if text is not None and isfinite(found := float(text)) else None
    except ValueError:
        return None
