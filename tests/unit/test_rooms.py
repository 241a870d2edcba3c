"""Who may import whom: the contracts under [tool.importlinter] in pyproject.toml (run with -s to see the list)."""
import contextlib
import io
import subprocess
import sys
import tomllib
from pathlib import Path

from importlinter.cli import lint_imports

PYPROJECT = Path(__file__).parents[2] / "pyproject.toml"


def test_imports_keep_to_the_contracts(monkeypatch):
    monkeypatch.chdir(PYPROJECT.parent)
    shown = io.StringIO()
    with contextlib.redirect_stdout(shown):
        status = lint_imports(config_filename=str(PYPROJECT), no_cache=True, no_logo=True)
    print(shown.getvalue())
    kept = " ".join(shown.getvalue().split())
    names = [c["name"] for c in tomllib.loads(PYPROJECT.read_text())["tool"]["importlinter"]["contracts"]]
    assert status == 0 and [n for n in names if f"{n} KEPT" not in kept] == []



def test_the_process_that_runs_a_checked_fmu_loads_nothing_heavy():
    heavy = ("lxml", "fmpy", "numpy", "rich", "pydantic", "cosim.master")
    code = f"import sys, cosim.conformance.child; print([m for m in {heavy} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=PYPROJECT.parent,
                          check=True)
    assert done.stdout.strip() == "[]"
