"""`ahv bench`."""
import subprocess
import sys
from pathlib import Path
from typing import Annotated

import typer

from ..errors import RunError, UsageError
from ..vehicle.closed_loop import choice

FOLDER = Path(__file__).parents[2] / "benchmarks"
SCRIPTS = {"masters": "masters.py", "orders": "orders.py", "memory": "memory.py", "step": "native_step.py",
           "campaign": "campaign.py", "versions": "versions.py"}


def bench(
    context: typer.Context,
    what: Annotated[str, typer.Argument(help=f"{', '.join(SCRIPTS)}.")] = "masters",
) -> None:
    """Measure speed and memory, side by side; --json and further options go to the script (benchmarks/*.py)."""
    script = FOLDER / SCRIPTS[choice("what", what, SCRIPTS)]
    if not script.is_file():
        raise UsageError(f"There is no {script}: measurements come with the sources, not with the package.")
    if subprocess.run([sys.executable, script, *context.args], stdout=sys.stdout).returncode:
        raise RunError(f"The measurement {what} failed, see above.")
