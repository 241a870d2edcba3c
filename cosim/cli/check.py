"""`ahv check`."""
import json
from pathlib import Path
from typing import Annotated

import typer

from ..errors import RunError, UsageError
from .options import Json


def check(
    fmus: Annotated[list[Path], typer.Argument(metavar="FMU...", help="FMI 2.0 co-simulation FMUs, anybody's.")],
    dynamic: Annotated[bool, typer.Option(help="Also run the FMU, in child processes.")] = True,
    time_limit: Annotated[float, typer.Option(help="Seconds that one call of the FMU may take.")] = 30.0,
    as_json: Json = False,
) -> None:
    """Check FMUs against FMI 2.0: their files, and what they do when they run."""
    from ..conformance import check as examine
    from ..conformance.report import findings_table, not_tested_table, to_dict

    missing = [str(path) for path in fmus if not path.is_file()]
    if missing:
        raise UsageError(f"There is no file {', '.join(missing)}.")
    reports = [examine(path, dynamic, time_limit) for path in fmus]
    if as_json:
        print(json.dumps({"passed": all(r.passed for r in reports), "fmus": [to_dict(r) for r in reports]}))
    else:
        from rich.console import Console

        for one in reports:
            Console().print(findings_table(one), not_tested_table(one))
    failed = [one.fmu.name for one in reports if not one.passed]
    if failed:
        raise RunError(f"{', '.join(failed)} breaks FMI 2.0.")
