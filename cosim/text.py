"""Words and tables for people, as plain text and HTML. Texts come from strangers' FMUs: shown, never obeyed."""
from collections.abc import Iterable, Sequence
from html import escape


def printable(text: str) -> str:
    """`text` with line feeds and control characters shown as escapes."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def shown(value: object) -> str:
    """A value for people to read: six digits of a number, true or false, nothing for None."""
    if isinstance(value, bool):
        return str(value).lower()
    return "" if value is None else f"{value:.6g}" if isinstance(value, float) else printable(str(value))


def text_table(headings: Sequence[str], rows: Iterable[Sequence[object]]) -> list[str]:
    """Lines of aligned columns: a line of headings, then a line for each row."""
    cells = [list(headings), *([shown(x) for x in row] for row in rows)]
    widths = [max(map(len, column)) for column in zip(*cells)]
    return ["  ".join(cell.ljust(width) for cell, width in zip(line, widths)).rstrip() for line in cells]


def without_math(text: str) -> str:
    """`text` for matplotlib, which takes what is between two dollar signs for a formula."""
    return text.replace("$", r"\$")


def html_table(headings: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """An HTML table; every text in it is escaped."""
    def line(tag: str, cells: Iterable[object]) -> str:
        return f"<tr>{''.join(f'<{tag}>{html_text(cell)}</{tag}>' for cell in cells)}</tr>"

    body = "".join(line("td", row) for row in rows)
    return f"<table><thead>{line('th', headings)}</thead><tbody>{body}</tbody></table>"


def html_text(value: object) -> str:
    """A value for people to read, escaped for HTML."""
    return escape(shown(value))
