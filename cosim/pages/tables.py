"""The tables of a page, as HTML; every text is escaped."""
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from ..text import html_table, html_text
from .flown import Flown, Mark

NO_FIGURES = ("fmus", "parameters", "signals", "versions", "files", "kind", "message", "warnings", "presets", "out",
              "live")


def flat(record: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """Nested objects as one: {"a": {"b": 1}} is {"a.b": 1}. Lists are texts."""
    found: dict[str, Any] = {}
    for key, value in record.items():
        if isinstance(value, Mapping):
            found |= flat(value, f"{prefix}{key}.")
        else:
            found[f"{prefix}{key}"] = ", ".join(map(str, value)) if isinstance(value, list | tuple) else value
    return found


def side_by_side(columns: Mapping[str, Mapping[str, Any]], first: str, only_different: bool = False) -> str:
    """A table with a column for each mapping and a row for each of their keys, those that differ if so wanted."""
    names = dict.fromkeys(name for column in columns.values() for name in column)
    rows = [(name, *(column.get(name) for column in columns.values())) for name in names]
    if only_different:
        rows = [row for row in rows if any(value != row[1] for value in row[2:])]
    return html_table((first, *columns), rows) if rows else "<p>Nothing.</p>"


def figures_table(flown: Sequence[Flown]) -> str:
    """What run.json says of each flight, but for parameters and files."""
    columns = {one.name: {key: value for key, value in flat(
        {k: v for k, v in one.record.items() if k not in NO_FIGURES}).items() if value is not None} for one in flown}
    if len(columns) == 1:
        columns = {"value": next(iter(columns.values()))}
    return side_by_side(columns, "figure")


def different(flown: Sequence[Flown]) -> str:
    """The parameters, files and options in which flights differ."""
    columns = {one.name: {
        **{key: value for key, value in flat(
            {k: one.record[k] for k in ("scenario", "system", "controller", "preset", "flavour", "algorithm", "step_s",
                                        "start_s", "stop_s") if k in one.record}).items()},
        **{f"FMU of {component}": f"{fmu.get('model')} {fmu.get('sha256', '')[:12]}"
           for component, fmu in one.flight.fmus.items()},
        **({"steps made by hand": len(one.record["live"])} if isinstance(one.record.get("live"), list) else {}),
        **flat(one.flight.parameters)} for one in flown}
    return side_by_side(columns, "parameter", only_different=True)


def files_table(flown: Sequence[Flown]) -> str:
    """The FMUs that flew."""
    rows = dict.fromkeys(
        (component, fmu.get("model"), fmu.get("file"), fmu.get("sha256"), fmu.get("generation_tool"))
        for one in flown for component, fmu in one.flight.fmus.items())
    return html_table(("component", "model", "file", "SHA-256", "made by"), rows)


def parameters_tables(flown: Sequence[Flown]) -> str:
    """All parameters, a table to unfold for each component."""
    components = dict.fromkeys(name for one in flown for name in one.flight.parameters)
    return "".join(
        f"<details><summary>{html_text(component)}</summary>" + side_by_side(
            {one.name if len(flown) > 1 else "value": flat(one.flight.parameters.get(component, {})) for one in flown},
            "parameter") + "</details>" for component in components)


def marks_table(marks: Iterable[tuple[str, Mark]]) -> str:
    """What happened when; the first of each pair is the flight's name, where there are several."""
    found = sorted(marks, key=lambda pair: pair[1].begin)
    several = any(name for name, _ in found)
    return html_table(("from (s)", "to (s)", "what", *(["flight"] if several else [])),
                      [(mark.begin, mark.end, mark.text, *([name] if several else [])) for name, mark in found])
