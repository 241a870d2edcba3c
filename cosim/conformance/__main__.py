"""python -m cosim.conformance FMU...: the tables of the check, for working on the checker itself."""
import sys
import time
from pathlib import Path

import rich

from . import check
from .report import findings_table, not_tested_table


def main(files: list[str]) -> int:
    """Print both tables for each file; 1 when an FMU has an error."""
    failed = False
    for file in files:
        began = time.monotonic()
        report = check(Path(file))
        rich.print(findings_table(report), not_tested_table(report), f"{time.monotonic() - began:.1f} s")
        failed |= not report.passed
    return int(failed)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
