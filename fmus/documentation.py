"""The page and the icon an FMU carries, made from its model's table and docstrings."""
import ast
import struct
import zlib
from html import escape
from pathlib import Path
from types import ModuleType

from .dependencies import dependencies
from .equations import formulas
from .interface import Variable, names, variables
from .model_files import model_files
from .trace import Trace

STYLE = ("body{font:15px sans-serif;max-width:70em;margin:2em auto;padding:0 1em}table{border-collapse:collapse}"
         "td,th{border:1px solid #ccc;padding:.2em .5em;text-align:left}"
         ".eq{display:flex;justify-content:space-between;padding:.15em 0;overflow-x:auto}"
         ".eq small{color:#666;padding-left:2em}"
         "pre{background:#f6f6f6;padding:1em;overflow:auto}")
RULES = """Inputs are held over a communication step; outputs belong to its end. Values travel in the units of the table
and nothing converts them; angles travel in rad and are shown in degrees. Parameters may be set until initialisation
ends, within their limits. A step that would leave an output's limits, or lead to anything that is not a finite number,
is discarded: the FMU says why, stays at the last communication point, and can be stepped on from there. An input that
is set to something not finite keeps its old value, and no step is taken until it is set again."""

EQUATIONS = """The formulas are made from the lines of Python that the FMU is built of, which stand below each part. A
line that is no formula is shown as code. At the right stand the comments of the source, such as the number of an
equation in the paper."""


def cell_text(v: Variable, value: float | bool | None) -> str:
    """A value of `v` as people read it: angles in degrees."""
    if value is None or isinstance(value, bool):
        return "" if value is None else str(value).lower()
    return f"{v.displayed(value):.6g}"


def html_table(head: list[str], rows: list[list[str]]) -> str:
    """An HTML table of plain texts."""
    def line(cells: list[str], tag: str) -> str:
        return "<tr>" + "".join(f"<{tag}>{escape(cell)}</{tag}>" for cell in cells) + "</tr>"

    return "\n".join(["<table>", line(head, "th"), *(line(row, "td") for row in rows), "</table>"])


def variable_rows(table: list[Variable], *causalities: str) -> list[list[str]]:
    """What the page says of each variable of these causalities."""
    return [[v.name, str(v.value_reference), v.display_unit or v.unit or "Boolean", cell_text(v, v.start),
             cell_text(v, v.minimum), cell_text(v, v.maximum), v.description]
            for v in table if v.causality in causalities]


def module_source(name: str, file: Path) -> str:
    """One file of the model (its name in the model, such as my_room/equations.py): docstring, its functions as
    formulas, and the code folded away."""
    text = file.read_text(encoding="utf-8")
    about = ast.get_docstring(ast.parse(text)) or ""
    title = name.removesuffix(".py").replace("/", ".")
    return (f"<h3>{escape(title)}</h3><pre>{escape(about)}</pre>\n{formulas(text)}\n"
            f"<details><summary>source</summary><pre>{escape(text)}</pre></details>")


def page(model: ModuleType, trace: Trace) -> bytes:
    """documentation/index.html. Raises ModelError as `model_files` does."""
    table = variables(model.VARIABLES)
    inputs = names(table, "input")
    feeds = [[name, ", ".join(n for n in needs if n in inputs) or "no input"]
             for name, needs in dependencies(model, trace).after_step.items()]
    head = ["name", "reference", "shown in", "start", "min", "max", "meaning"]
    presets = []
    for name, values in model.PRESETS.items():
        by_name = {v.name: v for v in table}
        rows = [[key, cell_text(by_name[key], value), by_name[key].display_unit or by_name[key].unit]
                for key, value in values.items()]
        presets.append(f"<details><summary>{escape(name)} (resources/presets/{escape(name)}.ssv)</summary>"
                       + html_table(["parameter", "value", "unit"], rows) + "</details>")
    body = "\n".join([
        f"<h1>{escape(model.NAME)}</h1><p>{escape(model.DESCRIPTION)}</p>",
        f"<p>{escape(RULES)}</p>",
        "<h2>Inputs</h2>", html_table(head, variable_rows(table, "input")),
        "<h2>Outputs</h2>", html_table(head, variable_rows(table, "output", "calculatedParameter")),
        "<h2>Parameters</h2>", html_table(head, variable_rows(table, "parameter")),
        "<h2>Presets</h2>", "<p>Sets of parameters, as SSP 1.0 parameter files.</p>", *presets,
        '<p><a href="fmi-ls-ref.html">Related files</a>: what experiments travel in the FMU, with their results.</p>',
        "<h2>Wiring</h2>",
        "<p>Connect variables of one name and unit; an input left alone keeps its start value. What an output depends "
        "on at once decides the order in which components are stepped: one that depends on no input breaks a loop.</p>",
        html_table(["output", "depends at once on"], feeds),
        "<h2>Equations</h2>", f"<p>{escape(EQUATIONS)}</p>",
        *(module_source(*file) for file in model_files(model).items())])
    return (f'<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>{escape(model.NAME)}</title>'
            f"<style>{STYLE}</style></head>\n<body>\n{body}\n</body></html>\n").encode()


def icon(model: ModuleType, size: int = 64) -> bytes:
    """model.png: a wedge-shaped vehicle on a colour of the model's own."""
    red, green, blue = (96 + b % 96 for b in zlib.crc32(model.NAME.encode()).to_bytes(4, "big")[:3])
    rows = bytearray()
    for y in range(size):
        rows.append(0)  # no filter
        for x in range(size):
            along = (x - 0.1 * size) / (0.8 * size)  # from tail to nose
            half = 0.16 * size * (1 - along)
            inside = 0 <= along <= 1 and abs(y - 0.5 * size) <= half
            rows += bytes((255, 255, 255) if inside else (red, green, blue))

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    header = struct.pack(">IIBBBBB", size, size, 8, 2, 0, 0, 0)
    chunks = chunk(b"IHDR", header), chunk(b"IDAT", zlib.compress(bytes(rows), 9)), chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunks)
