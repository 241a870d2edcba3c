"""Conformance of any FMI 2.0 or 3.0 co-simulation FMU to the specification of its version, static and dynamic.

    report = check(Path("some.fmu"))
    rich.print(report_module.findings_table(report))        # cosim.conformance.report
    json.dumps(report_module.to_dict(report))

Nothing heavy is imported here: the child processes that run the FMU import this package too.
"""
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .confined import Limits
    from .report import Report


def check(path: Path, dynamic: bool = True, time_limit: float = 30.0, cycles: int = 200,
          limits: "Limits | None" = None) -> "Report":
    """Check one FMU against the rules of FMI 2.0.x (sections 2.1 to 2.3 and 4.1 to 4.3) or FMI 3.0.x (2 and 4).

    `dynamic` also runs the FMU, in child processes, in a sandbox where the machine has one (`Report.sandbox`).
    `time_limit` is how many seconds a single call of the FMU may take before it counts as hanging; `limits` has all
    limits, that one too. `cycles` is how many lives of an instance the search for memory leaks takes (fewer for
    slow FMUs, which the report then says). Nothing is written outside of a temporary folder, which is removed.

    Raises UsageError for a limit that is not above 0.
    """
    from .checker import check as run  # the child must not import lxml and fmpy
    from .confined import Limits

    return run(path, dynamic, limits or Limits(call_s=time_limit), cycles)
