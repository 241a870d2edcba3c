"""`ahv check`."""
import json
from os.path import isfile
from pathlib import Path
from typing import Annotated

import typer

from ..errors import RunError, UsageError
from .options import Json


def check(
    fmus: Annotated[list[Path], typer.Argument(metavar="FMU...", help="FMI 2.0 co-simulation FMUs, anybody's.")],
    dynamic: Annotated[bool, typer.Option(help="Also run the FMU, in child processes.")] = True,
    time_limit: Annotated[float, typer.Option(help="Seconds that one call of the FMU may take.")] = 30.0,
    total_time_limit: Annotated[float, typer.Option(help="Seconds that the whole check of an FMU may take.")] = 1800.0,
    memory_limit: Annotated[int, typer.Option(help="Memory that the FMU and all it starts may use, in MB.")] = 4096,
    file_limit: Annotated[int, typer.Option(help="Size of a file that the FMU may write, in MB.")] = 1024,
    process_limit: Annotated[int, typer.Option(help="Processes that the FMU may have.")] = 64,
    as_json: Json = False,
) -> None:
    """Check FMUs against FMI 2.0: their files, and what they do when they run."""
    from ..conformance import check as examine
    from ..conformance.confined import Limits
    from ..conformance.report import findings_table, not_tested_table, to_dict

    missing = [str(path) for path in fmus if not isfile(path)]
    if missing:
        raise UsageError(f"There is no file {', '.join(missing)}.")
    limits = Limits(call_s=time_limit, total_s=total_time_limit, memory_mb=memory_limit, file_mb=file_limit,
                    processes=process_limit)
    reports = [examine(path, dynamic, limits=limits) for path in fmus]
    if as_json:
        print(json.dumps({"passed": all(r.passed for r in reports), "fmus": [to_dict(r) for r in reports]}))
    else:
        from rich.console import Console

        for one in reports:
            Console().print(findings_table(one), not_tested_table(one))
    failed = [one.fmu.name for one in reports if not one.passed]
    if failed:
        raise RunError(f"{', '.join(failed)} breaks FMI 2.0.")
