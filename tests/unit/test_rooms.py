"""Who may import whom: the contracts under [tool.importlinter] in pyproject.toml (run with -s to see the list)."""
import subprocess
import sys
import tomllib
from pathlib import Path

PYPROJECT = Path(__file__).parents[2] / "pyproject.toml"


def python(code: str) -> subprocess.CompletedProcess[str]:
    """Run `code` in a fresh process, with the packages beside pyproject.toml."""
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=PYPROJECT.parent)


def test_imports_keep_to_the_contracts():
    done = python("import sys; from importlinter.cli import lint_imports; "
                  "sys.exit(lint_imports(config_filename='pyproject.toml', no_cache=True, no_logo=True))")
    print(done.stdout, done.stderr)
    names = [c["name"] for c in tomllib.loads(PYPROJECT.read_text())["tool"]["importlinter"]["contracts"]]
    kept = " ".join(done.stdout.split())
    assert done.returncode == 0 and names and [n for n in names if f"{n} KEPT" not in kept] == []


def test_the_process_that_runs_a_checked_fmu_loads_nothing_heavy():
    heavy = ("lxml", "fmpy", "numpy", "rich", "pydantic", "cosim.master")
    done = python(f"import sys, cosim.conformance.child; print([m for m in {heavy} if m in sys.modules])")
    assert done.stdout.strip() == "[]", done.stderr
