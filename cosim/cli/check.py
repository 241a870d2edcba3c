"""`ahv check`."""
import sys
from enum import StrEnum
from os.path import isfile
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..errors import RunError, UsageError, did_you_mean
from .options import Json, Open, new_file, opened, typed

if TYPE_CHECKING:
    from ..conformance.report import Report


WIDEST = 120  # characters of a line on a terminal


class FailOn(StrEnum):
    """Which findings make the exit status 1."""
    ERROR = "error"
    WRONG_RESULTS = "wrong-results"
    WARNING = "warning"
    ANY = "any"


class Format(StrEnum):
    """How the reports are printed."""
    TEXT = "text"
    JSON = "json"
    JUNIT = "junit"
    SARIF = "sarif"
    GITHUB = "github"


def check(
    fmus: Annotated[list[Path] | None, typer.Argument(metavar="FMU...",
                                                      help="Co-simulation FMUs of FMI 2.0 or 3.0, anybody's.")] = None,
    dynamic: Annotated[bool, typer.Option(help="Also run the FMU, in child processes.")] = True,
    show_all: Annotated[bool, typer.Option("--all", help="Also show formal findings, notes, and what was not "
                                           "tested.")] = False,
    explain: Annotated[str | None, typer.Option(metavar="RULE", help="Print what a rule asks, why, and how to mend "
                                                "what breaks it; no FMU is checked.")] = None,
    fail_on: Annotated[FailOn, typer.Option(help="Findings that make the exit status 1.")] = FailOn.ERROR,
    ignore: Annotated[list[str] | None, typer.Option(metavar="RULE", help="Leave out a rule's findings. Can be "
                                                     "repeated.")] = None,
    format: Annotated[Format, typer.Option(help="What is printed on stdout.")] = Format.TEXT,
    time_limit: Annotated[float, typer.Option(help="Seconds that one call of the FMU may take.")] = 30.0,
    total_time_limit: Annotated[float, typer.Option(help="Seconds that the whole check of an FMU may take.")] = 1800.0,
    time_budget: Annotated[float, typer.Option(help="Seconds after which no further test of the FMU begins; what is "
                                               "left is told.")] = 30.0,
    memory_limit: Annotated[int, typer.Option(help="Memory that the FMU and all it starts may use, in MB.")] = 4096,
    file_limit: Annotated[int, typer.Option(help="Size of a file that the FMU may write, in MB.")] = 1024,
    process_limit: Annotated[int, typer.Option(help="Processes that the FMU may have.")] = 64,
    out: Annotated[Path | None, typer.Option(metavar="FILE.html", parser=new_file,
                                             help="Also write the reports as a page; with --open, else to "
                                             "results/check.html.")] = None,
    open_: Open = False,
    as_json: Json = False,
) -> None:
    """Check FMUs against FMI 2.0 or 3.0: their files, and what they do when they run."""
    from ..conformance import check as examine
    from ..conformance import formats
    from ..conformance.confined import Limits
    from ..conformance.rule import RULES

    for rule in (explain, *(ignore or ())):
        if rule is not None and rule not in RULES:
            raise UsageError(f"There is no rule {rule}{did_you_mean(rule, RULES)}")
    if explain is not None:
        print(formats.explain(RULES[explain]))
        return
    if not fmus:
        raise UsageError("Name the FMUs to check, or a rule with --explain.")
    missing = [str(path) for path in fmus if not isfile(path)]
    if missing:
        raise UsageError(f"There is no file {', '.join(missing)}.")
    limits = Limits(call_s=time_limit, total_s=total_time_limit, memory_mb=memory_limit, file_mb=file_limit,
                    processes=process_limit, budget_s=time_budget)
    reports = [examine(path, dynamic, limits=limits) for path in fmus]
    for report in reports:
        report.ignore(ignore or ())
    if as_json or format == Format.JSON:
        print(formats.as_json(reports))
    elif format == Format.JUNIT:
        print(formats.as_junit(reports, fail_on))
    elif format == Format.SARIF:
        print(formats.as_sarif(reports))
    elif format == Format.GITHUB:
        print(formats.as_github(reports))
    else:
        for report in reports:
            show(report, fail_on, show_all)
    if out or open_:
        written = write_page(reports, out or Path("results", "check.html"))
        opened(written, open_)
    failed = [one for one in reports if one.fails(fail_on)]
    if failed:
        standard = " and ".join(sorted({f"FMI {one.fmi_version}" for one in failed}))
        broken = f"breaks {standard}" if fail_on == FailOn.ERROR else f"has findings that --fail-on {fail_on} rules out"
        raise RunError(f"{', '.join(one.fmu.name for one in failed)} {broken}.")


def write_page(reports: "list[Report]", out: Path) -> Path:
    """Write the reports as a page to the file `out`, which is given back. Raises RunError where it cannot be."""
    from ..master.whole_file import whole
    from ..pages.write import plain

    out.parent.mkdir(parents=True, exist_ok=True)
    with whole(out) as partial:
        partial.write_text(plain(f"Check of {', '.join(one.fmu.name for one in reports)}",
                                 [(one.fmu.name, one._repr_html_(), one.passed) for one in reports], typed()),
                           encoding="utf-8")
    return out


def show(report: "Report", fail_on: str, everything: bool) -> None:
    """Print a report: a page on a terminal, else one line a finding."""
    from shutil import get_terminal_size

    from ..conformance import formats

    if sys.stdout.isatty():
        print("\n".join([*formats.page(report, min(get_terminal_size().columns, WIDEST), fail_on, everything), ""]))
    else:
        print("\n".join(formats.lines(report, fail_on, everything)))
