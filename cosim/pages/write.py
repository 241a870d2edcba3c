"""Writes pages: HTML with everything in it, for `file://` as well as for a server.

Texts of files and FMUs are strangers': every one is escaped, and the page's policy lets no script run but its own.
"""
import base64
import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from ..text import filled_in, html_text
from .decimate import packed
from .flown import Flown, Mark, Panel, ending
from .tables import different, figures_table, files_table, marks_table, parameters_tables

REPORT = "report.html"  # what a page is called in a folder of results
FILES = Path(__file__).parent / "page"
POINTS = 110_000         # of all curves of a page: about 1.2 MB
FEWEST, MOST = 64, 6000  # of one curve
SIGNALS = 2000           # of one page
UNFOLDED = 3             # flights whose ends are told one by one at the top
CHOSEN, PANELS = 8, 6    # curves of a panel and panels that are shown at first, where no room says which


def page(title: str, flown: Sequence[Flown], panels: Sequence[Panel] = (), command: str = "", notes: Sequence[str] = (),
         tables: Sequence[tuple[str, str]] = ()) -> str:
    """A page of one flight or of several over each other, as a text of HTML.

    `panels` are shown at first; other signals can be chosen, in a panel for each unit. `command` is what made the
    page; `notes` are sentences at its top. `tables` are further sections: title and HTML.
    """
    data = data_of(flown, panels)
    notes = [*notes, *missing(flown, len(data["signals"]))]
    marks = [(one.name if len(flown) > 1 else "", mark) for one in flown for mark in marks_of(one)]
    sections = [
        *commands(command),
        ("Figures", figures_table(flown)),
        *([("What differs in the parameters", different(flown))] if len(flown) > 1 else []),
        *tables,
        ("FMUs", files_table(flown)),
        ("Parameters", parameters_tables(flown)),
    ]
    body = read("curves.html").replace("{{marks}}", marks_table(marks)) + "".join(map(section, sections))
    return filled(title, outcomes(flown) + "".join(f'<p class="note">{html_text(n)}</p>' for n in notes),
                  body, scripts(), data)


def missing(flown: Sequence[Flown], shown: int) -> list[str]:
    """Sentences on signals that a page does not have."""
    count = len({name for one in flown for name in (*one.flight, *one.curves)})
    if not count:
        return ["No signals were recorded."]
    return [f"The page has {shown} of the {count} signals."] if shown < count else []


def plain(title: str, parts: Sequence[tuple[str, str, bool]], command: str = "") -> str:
    """A page without curves, as a text of HTML: of each part a title, its HTML, and whether it is good news."""
    body = "".join(section((name, f'<div class="outcome{"" if good else " bad"}">{html}</div>'))
                   for name, html, good in parts)
    return filled(title, "", body + "".join(map(section, commands(command))), {}, None)


def commands(command: str) -> list[tuple[str, str]]:
    """The section with the command that made the page, if it is known."""
    return [("The command", f"<pre>{html_text(command)}</pre>")] if command else []


def scripts() -> dict[str, str]:
    """The scripts of a page with curves, in their order."""
    return {"bokeh": library(), **{name: read(f"{name}.js") for name in ("base", "curves", "page")}}


def filled(title: str, outcome: str, body: str, scripts: Mapping[str, str], data: object) -> str:
    """The page's frame with its parts."""
    from importlib.metadata import version

    style = read("style.css")
    elements = [f"<script>{text}</script>" for text in scripts.values()]
    if data is not None:
        elements.insert(0, f'<script type="application/json" id="data">{embedded(data)}</script>')
    parts = {"policy": policy(scripts.values()), "title": html_text(title), "style": style, "outcome": outcome,
             "made": f"Made by ahv {html_text(version('ahv'))}.", "scripts": "\n".join(elements), "body": body,
             "licence": "<p>Curves are drawn by Bokeh, whose licence (BSD-3-Clause) is in this file.</p>"
             if scripts else ""}
    return filled_in(read("page.html"), parts)


def data_of(flown: Sequence[Flown], panels: Sequence[Panel]) -> dict[str, Any]:
    """What the page's script reads."""
    about: dict[str, dict[str, str]] = {}
    called = [called_in(one, about) for one in flown]
    shown = dict.fromkeys(name for panel in panels for name in panel.curves if name in about)
    names = [*shown, *(name for name in about if name not in shown)][:SIGNALS]
    about = {name: about[name] for name in names}
    arranged = arrangement(about, panels)
    points = min(max(POINTS // max(len(names) * len(flown), 1), FEWEST), MOST)
    kinds: dict[str, str] = {}
    for mark in (mark for one in flown for mark in marks_of(one)):
        kinds.setdefault(mark.kind, mark.kind)
    return {"signals": about, "panels": [{"title": p.title, "curves": p.curves} for p in arranged],
            "chosen": list(shown) or [n for p in arranged[:PANELS] for n in p.curves[:CHOSEN]],
            "kinds": [{"name": kind, "text": text} for kind, text in kinds.items()],
            "runs": [run_of(one, {key: known[key] for key in names if key in known}, points)
                     for one, known in zip(flown, called)]}


def called_in(one: Flown, about: dict[str, dict[str, str]]) -> dict[str, str]:
    """The name in the flight of each of its curves by its name on the page, which has the unit where another flight has
    that name in another unit. What is new is added to `about`."""
    curves = {column.name: {"unit": column.unit, "description": column.description} for column in one.flight.columns}
    curves |= {name: {"unit": curve.unit, "description": curve.description} for name, curve in one.curves.items()}
    found = {}
    for name, said in curves.items():
        same = (about.get(name, said)["unit"] or "1") == (said["unit"] or "1")
        key = name if same else f"{name} in {said['unit'] or '1'}"
        about.setdefault(key, said)
        found[key] = name
    return found


def arrangement(about: Mapping[str, Mapping[str, str]], panels: Sequence[Panel]) -> list[Panel]:
    """`panels` as far as their signals are known, then one for each unit with the signals that are in none."""
    found = [Panel(panel.title, tuple(name for name in panel.curves if name in about)) for panel in panels]
    placed = {name for panel in found for name in panel.curves}
    units: dict[str, list[str]] = {}
    for name in about:
        if name not in placed:
            units.setdefault(about[name]["unit"], []).append(name)
    rest = [Panel("Other signals" if panels else "Signals", tuple(names)) for names in units.values()]
    return [panel for panel in (*found, *rest) if panel.curves]


def run_of(one: Flown, names: Mapping[str, str], points: int) -> dict[str, Any]:
    """A flight's curves and marks; `names` are its curves by their names on the page."""
    flight = one.flight
    curves = {}
    for key, name in names.items():
        if name in one.curves:
            course = one.curves[name].course
            found = course.time, np.asarray(course.values)
        else:
            found = flight.time, np.asarray(flight[name])
        if len(found[0]):
            curves[key] = packed(*found, points)
    start, end = (float(flight.time[0]), float(flight.time[-1])) if len(flight.time) else (0.0, 0.0)
    marks = [{"kind": m.kind, "text": m.text, "begin": m.begin, "end": m.end} for m in marks_of(one)]
    return {"name": one.name, "start": start, "end": end, "curves": curves, "marks": marks}


def marks_of(one: Flown) -> list[Mark]:
    """The marks of its room, and its end if it was early."""
    return [*one.marks, *ending(one.flight)]


def outcomes(flown: Sequence[Flown]) -> str:
    """How the flights ended, as HTML; of many flights first how many ended early, so that the curves are near."""
    told = "".join(map(outcome, flown))
    if len(flown) <= UNFOLDED:
        return told
    early = sum(not one.flight.finished for one in flown)
    text = f"{early} of {len(flown)} flights ended early" if early else f"All {len(flown)} flights finished"
    return f'<details class="outcome{" bad" if early else ""}"><summary>{text}</summary>{told}</details>'


def outcome(one: Flown) -> str:
    """How a flight ended, as HTML."""
    kind = "outcome" if one.flight.finished else "outcome bad"
    notes = "".join(f'<p class="note">{html_text(text)}</p>' for text in one.flight.warnings)
    return f'<p class="{kind}"><strong>{html_text(one.name)}</strong>: {html_text(one.flight.outcome)}</p>{notes}'


def section(titled: tuple[str, str]) -> str:
    """A part of the page; wide tables scroll by themselves."""
    title, html = titled
    return (f'<section><h2>{html_text(title)}</h2><div class="scroll" tabindex="0" role="region" '
            f'aria-label="{html_text(title)}">{html}</div></section>')


@cache
def read(name: str) -> str:
    """A file of the page."""
    return (FILES / name).read_text(encoding="utf-8")


@cache
def library() -> str:
    """BokehJS, from the package's folder: importing it would take a second."""
    found = find_spec("bokeh")
    if found is None or found.origin is None:
        raise ModuleNotFoundError("No module named 'bokeh'", name="bokeh")
    text = Path(found.origin).with_name("server").joinpath("static", "js", "bokeh.min.js").read_text(encoding="utf-8")
    return text.partition("\n//# sourceMappingURL")[0].replace("</script", "<\\/script")


def embedded(data: object) -> str:
    """JSON that can stand in a script element, whatever its texts are."""
    return json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


def policy(scripts: Iterable[str]) -> str:
    """What the page may do: run its own scripts, and load nothing. BokehJS styles its own elements."""
    allowed = " ".join(map(fingerprint, scripts)) or "'none'"
    return (f"default-src 'none'; script-src {allowed}; style-src 'unsafe-inline'; img-src data: blob:; "
            f"base-uri 'none'; form-action 'none'")


@cache
def fingerprint(text: str) -> str:
    """How a content security policy names an element's text."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


