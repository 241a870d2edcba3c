"""Words and tables for people, as plain text and HTML. Texts come from strangers' FMUs: shown, never obeyed."""
import re
from collections.abc import Iterable, Mapping, Sequence
from html import escape

LONGEST_WORD, LONGEST_SENTENCE = 300, 4000  # characters


def printable(text: str) -> str:
    """`text` with line feeds and control characters shown as escapes."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def sentence(text: str) -> str:
    """`text` for a terminal: control characters as escapes, the middle of a very long word or text left out."""
    words = [shortened(printable(word), LONGEST_WORD) for word in re.split(r"(\s+)", text)]
    return shortened("".join(word if not word.isspace() else " " for word in words), LONGEST_SENTENCE)


def shortened(text: str, longest: int) -> str:
    """`text` itself, or its beginning and its end if it is longer than `longest` characters."""
    return text if len(text) <= longest else f"{text[:longest * 2 // 3]} ... {text[-(longest // 4):]}"


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


def filled_in(template: str, parts: Mapping[str, str]) -> str:
    """A template with its {{names}} replaced by `parts`, at once: what is filled in is never looked through again."""
    first, *rest = template.split("{{")
    return first + "".join(parts[name] + text for name, _, text in (piece.partition("}}") for piece in rest))


def in_python(sentence: str) -> str:
    """The master's sentences name the options of the command line: `--time-limit` is `time_limit` here."""
    return re.sub(r"--([a-z][a-z-]*)", lambda option: option[1].replace("-", "_"), sentence)
