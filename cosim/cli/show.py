"""Shows results to people: tables on the terminal, or one JSON object. Names are texts, never markup (`[red]`)."""
import json
import sys
from typing import Any

from ..errors import Interrupted, RunError


def report(summary: dict[str, Any], as_json: bool) -> None:
    """Print a result as a table of two columns, or as one JSON object."""
    if as_json:
        print(json.dumps(summary))
        return
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(show_header=False)
    for key, value in summary.items():
        if isinstance(value, dict):
            value = ", ".join(f"{k} {v:.4g}" for k, v in value.items() if v is not None)
        table.add_row(Text(key), Text(f"{value:.4g}" if isinstance(value, float) else str(value)))
    Console().print(table)


def report_rows(rows: dict[str, dict[str, Any]]) -> None:
    """A table with a column for each of `rows`."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table("")
    for name in rows:
        table.add_column(Text(name))
    flat: dict[str, dict[str, Any]] = {}
    for law, row in rows.items():
        for key, value in row.items():
            for part, number in (value.items() if isinstance(value, dict) else [("", value)]):
                flat.setdefault(f"{key} {part}".strip(), {})[law] = number
    for key, found in flat.items():
        table.add_row(Text(key), *(Text(f"{v:.4g}" if isinstance(v, float) else str(v)) for v in map(found.get, rows)))
    Console().print(table)


def short(loop: dict[str, Any]) -> dict[str, Any]:
    """Poles as text, one of each pair."""
    return {f"pole {i}": f"{p['real']:.3f} +-{p['imag']:.3f}j"
            for i, p in enumerate(p for p in loop["poles"] if p["imag"] >= 0)}


def conclude(finished: bool, messages: list[str], trouble: str, interrupted: int = 0) -> None:
    """How flights ended, on stderr. Raises RunError if not all `finished`, or for the `trouble` of their results, and
    Interrupted for a signal."""
    said = [text for text in messages if text]
    if interrupted and finished:
        said.append("Interrupted when the flight had ended.")
    if interrupted or not finished or trouble:
        sentence = "; ".join([*(text.rstrip(".") for text in said), trouble] if trouble else said)
        raise Interrupted(sentence, interrupted) if interrupted else RunError(sentence)
    note(said)


def note(texts: list[str]) -> None:
    """What a reader should know although the run goes on, on stderr."""
    for text in texts:
        print(f"ahv: {text}", file=sys.stderr)
