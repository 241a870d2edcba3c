"""Runs the ```python blocks of a page, one after the other in one namespace: `python documented.py PAGE.md`."""
import re
import sys
from pathlib import Path


def blocks(page: Path) -> list[str]:
    """The page's ```python blocks, each moved to its line, so that a traceback names the page's own."""
    text = page.read_text()
    return ["\n" * (text[:found.start(1)].count("\n")) + found[1]
            for found in re.finditer(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL)]


def run(page: Path) -> dict[str, object]:
    """The names that the page's examples leave; raises what they raise."""
    names: dict[str, object] = {"__name__": "__main__"}
    for block in blocks(page):
        exec(compile(block, page, "exec"), names)
    return names


if __name__ == "__main__":
    run(Path(sys.argv[1]))
