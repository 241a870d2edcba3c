"""docs/mutants.md: what `make mutants` found, room by room."""
import subprocess
from collections import Counter
from pathlib import Path

from points import Mutant

HEAD = """# Mutants

With this page you can judge how much the tests notice. Single mistakes were put into the code, one at a time, and the
tests were run on each.

A mistake (a mutant) is one operator, constant, condition or statement changed. `make mutants` draws a sample, the
same number in every room of the project, and tries each mutant in a copy of the tree. A mutant is killed when a test
fails or hangs. A mutant that changes nothing that can be observed is *equivalent*: `tests/mutants/judged.yaml` lists
these with the reason. The share is killed / (tried - equivalent). "Before" is the share at the first trial of each
mutant, when no tests had been written for the survivors yet; the recorded flights of the models
(`tests/unit/test_model_numbers.py`) were there already. It is a lower bound in `campaign`, `algorithms` and `fmus`,
where some first trials ran only those tests that look at the mutated function. A room with fewer tried than drawn is
not finished: `make mutants` goes on there. `tests/mutants/rooms.py` names the files and the tests of each room,
`tests/mutants/points.py` the changes.

This page is written by `.venv/bin/python tests/mutants --table`, at commit {commit}. Trials of lines that have changed
since do not count in a new table, and mutants of new lines are drawn.
"""


def share(killed: int, tried: int) -> str:
    """A share in per cent; a dash where there is none."""
    return f"{100 * killed / tried:.0f} %" if tried else "-"


def head(root: Path) -> str:
    """The commit that is checked out."""
    words = ["git", "rev-parse", "--short", "HEAD"]
    return subprocess.run(words, cwd=root, capture_output=True, text=True, check=True).stdout.strip()


def cell(text: str) -> str:
    """A text as code in a cell of a table."""
    short = text if len(text) <= 120 else text[:117] + "..."
    return "``" + short.replace("|", "\\|") + "``" if short else "-"


def write_table(root: Path, samples: dict[str, tuple[list[Mutant], int]], known: dict, equivalent: dict) -> None:
    """Write docs/mutants.md from the trials recorded (`known`) and the judged mutants (`equivalent`)."""
    rows, total, left, excused = [], Counter(), [], []
    trees: Counter[str] = Counter()
    for room, (sample, points) in samples.items():
        judged = [mutant for mutant in sample if mutant.key in equivalent]
        tried = [mutant for mutant in sample if mutant.key in known and mutant.key not in equivalent]
        first = sum(known[mutant.key][0]["killed"] for mutant in tried)
        last = sum(known[mutant.key][-1]["killed"] for mutant in tried)
        found = {"points": points, "drawn": len(sample), "tried": len(tried) + len(judged), "judged": len(judged),
                 "first": first, "last": last, "open": len(tried) - last}
        total.update(found)
        trees.update(known[mutant.key][-1].get("commit", "earlier ones, not noted") for mutant in tried)
        rows.append((room, found))
        left += [mutant for mutant in tried if not known[mutant.key][-1]["killed"]]
        excused += judged
    lines = [HEAD.replace("{commit}", head(root)),
             "| room | possible | drawn | tried | equivalent | killed | survived | before | share |",
             "|---|---|---|---|---|---|---|---|---|"]
    for room, n in [*rows, ("all", total)]:
        counted = n["tried"] - n["judged"]
        cells = [room, *(n[key] for key in ("points", "drawn", "tried", "judged", "last", "open")),
                 share(n["first"], counted), share(n["last"], counted)]
        lines.append(f"| {' | '.join(map(str, cells))} |")
    lines += ["", "Trials by the commit that they were made on, with its code and its tests: "
              + ", ".join(f"{tree} {count}" for tree, count in trees.most_common()) + "."]
    lines += ["", "## Survivors", "", "| place | code | mutant |", "|---|---|---|"]
    lines += [f"| {m.file} {m.function} | {cell(m.before)} | {cell(m.after)} |" for m in left]
    lines += ["", "## Judged equivalent", "", "| place | code | mutant | reason |", "|---|---|---|---|"]
    lines += [f"| {m.file} {m.function} | {cell(m.before)} | {cell(m.after)} | {equivalent[m.key]} |" for m in excused]
    (root / "docs" / "mutants.md").write_text("\n".join(lines) + "\n")
