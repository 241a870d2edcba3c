"""Writes the page: one file with everything in it, for `file://` as well as for a server."""
import base64
from collections.abc import Mapping
from pathlib import Path

from ..master.whole_file import whole
from ..pages.write import embedded, fingerprint
from ..text import filled_in
from .compile import module
from .data import about

FILES = Path(__file__).parent / "page"
STYLES = ("uplot/uPlot.min.css", "style.css")
SCRIPTS = {  # element -> files; the worker runs the text of the first
    "engine": ("engine.js", "measures.js", "worker.js"),
    "page": ("uplot/uPlot.iife.min.js", "state.js", "view.js", "ranges.js", "decimate.js", "charts.js", "controls.js",
             "readout.js", "main.js"),
}


def playground(out: Path) -> Path:
    """Write the page to the file `out`, whose path is given back.

    Raises UsageError for FMUs that are not built, ModuleNotFoundError without the compiler, RunError where the file
    cannot be written.
    """
    out.parent.mkdir(parents=True, exist_ok=True)
    with whole(out) as partial:
        partial.write_text(page(module()), encoding="utf-8")
    return out


def page(module: bytes) -> str:
    """The page as a text of HTML, with this module. Raises UsageError for FMUs that are not built."""
    data = {**about(), "module": base64.b64encode(module).decode()}
    style = "\n".join(map(read, STYLES))
    scripts = {name: "\n".join(map(read, files)) for name, files in SCRIPTS.items()}
    parts = {"policy": policy(style, scripts), "style": style, "data": embedded(data),
             "licence": read("uplot/LICENSE"), **scripts}
    return filled_in(read("page.html"), parts)


def read(name: str) -> str:
    """A file of the page."""
    return (FILES / name).read_text(encoding="utf-8")


def policy(style: str, scripts: Mapping[str, str]) -> str:
    """What the page may do: run its own scripts and modules, and load nothing."""
    allowed = " ".join(map(fingerprint, scripts.values()))
    return (f"default-src 'none'; script-src {allowed} 'wasm-unsafe-eval'; worker-src blob:; "
            f"style-src {fingerprint(style)}; img-src data:; base-uri 'none'; form-action 'none'")
