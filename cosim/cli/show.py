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
        if isinstance(value, list) and value and all(isinstance(row, dict) for row in value):
            value = "; ".join(" ".join(f"{v:.4g}" if isinstance(v, float) else str(v) for v in row.values())
                              for row in value)
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


def root(found: dict[str, float]) -> str:
    """A pole or zero (1/s) as text, which stands for its conjugate, too. What rounding leaves of a part shows as 0."""
    nothing = max(1e-5, 5e-4 * min(1.0, found["omega"]))
    real, imag = (0.0 if abs(found[part]) < nothing else found[part] for part in ("real", "imag"))
    return f"{short(real)} +-{short(imag)}j" if imag else short(real)


def short(value: float) -> str:
    """With three decimals, or, of a number that these do not show, three digits."""
    return f"{value:.3f}" if value == 0 or abs(value) >= 0.01 else f"{value:.3g}"


def upper(roots: list[dict[str, float]]) -> list[dict[str, float]]:
    """Real poles or zeros, and one of each complex pair."""
    return [found for found in roots if found["imag"] >= 0]


def report_poles(systems: dict[str, dict[str, Any]]) -> None:
    """A table of the poles (1/s) of each system, with the damping of oscillations."""
    columns = {name: [(root(p), f"{p['damping']:.3f}" if "j" in root(p) else "") for p in upper(system["poles"])]
               for name, system in systems.items()}
    longest = max(map(len, columns.values()), default=0)
    rows: dict[str, dict[str, Any]] = {}
    for name, found in columns.items():
        filled = found + [("", "")] * (longest - len(found))
        rows[name] = {f"pole {i}": pole for i, (pole, _) in enumerate(filled)}
        rows[f"{name}: damping"] = {f"pole {i}": ratio for i, (_, ratio) in enumerate(filled)}
    report_rows(rows)


def report_zeros(system: dict[str, Any]) -> None:
    """A table of a system's transmission zeros (1/s)."""
    if system["zeros"]:
        report_rows({"zeros": {pair: ", ".join(map(root, upper(found))) or "none"
                               for pair, found in system["zeros"].items()}})


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
