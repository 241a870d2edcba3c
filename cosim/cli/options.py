"""Options that several commands share."""
import shlex
import sys
from pathlib import Path
from typing import Annotated

import typer

from ..errors import UsageError
from ..master.folder import expanded
from ..vehicle.registry import LAWS, PLANTS, choices


def place(word: str) -> Path:
    """The file or folder that a word of the command line names: `~/x` is below the home folder, `./~/x` is not. Raises
    UsageError if there is no such home."""
    path = Path(word)
    return expanded(path) if word.startswith("~") or not str(path).startswith("~") else path.absolute()


def new_file(word: str) -> Path:
    """The file that a word names for --out. Raises UsageError for what no file can be called."""
    path = place(word)
    if not path.name or "\0" in word or any("\ud800" <= c <= "\udfff" for c in word):
        raise UsageError(f"--out {word!r} is not allowed: it must be the path of a file.")
    return path


def typed() -> str:
    """The command line as one types it again."""
    return shlex.join(["ahv", *sys.argv[1:]])


def opened(page: Path, wanted: bool) -> None:
    """Open a page in the browser, if that is `wanted` and the page was written."""
    if wanted and page.is_file():
        import webbrowser

        webbrowser.open(page.resolve().as_uri())


Json = Annotated[bool, typer.Option("--json", help="Print one JSON object on stdout.")]
Algorithm = Annotated[str, typer.Option(metavar="NAME[,OPTION=VALUE]...", help="gauss-seidel, jacobi, multi-rate, "
                                        "variable or iterated; for example multi-rate,controller=5,hold=linear.")]
Set = Annotated[list[str], typer.Option("--set", metavar="COMPONENT.VARIABLE=VALUE", help="Set a parameter or a start "
                                        "value, with a unit if wanted (2deg). Can be repeated.")]
ScenarioWord = Annotated[str, typer.Argument(metavar="SCENARIO", help="case1, case2, hold, or a YAML file.")]
Controller = Annotated[str, typer.Option(metavar="NAME|NAME=FILE.fmu",
                                         help=f"{choices(LAWS)}; or any FMU with the same ports.")]
Plant = Annotated[str, typer.Option(metavar="NAME|FILE.fmu",
                                    help=f"{choices(PLANTS)}; or any FMU with the same ports.")]
Preset = Annotated[str | None, typer.Option(help="Preset of the controller, else the scenario's or the controller's "
                                            "own; COMPONENT=NAME,... for other components.")]
Flavour = Annotated[str | None, typer.Option(help="native, native-fmi3 or python; else native where it is built.")]
Step = Annotated[float, typer.Option(help="Communication step, s.")]
Stop = Annotated[float | None, typer.Option(help="Stop time, s; else the scenario's.")]
Stream = Annotated[bool, typer.Option("--stream", help="Write rows to the disk during the run, for long runs: no CSV; "
                                      "metrics and figures use a part of the rows.")]
TimeLimit = Annotated[float | None, typer.Option(metavar="S", help="Longest time of one FMU call, s; a call that takes "
                                                  "longer ends the flight.")]
Uncertainty = Annotated[float | None, typer.Option(help="Amplitude of the coefficients' change, for example 0.5; else "
                                                   "the scenario's.")]
Record = Annotated[list[str], typer.Option("--record", metavar="COMPONENT.VARIABLE", help="Signals to keep, * for any; "
                                           "else all outputs. Can be repeated.")]
Decimate = Annotated[int, typer.Option(help="Write every N-th tick.", min=1, max=10**12)]
Velocity = Annotated[float, typer.Option("--V", help="Velocity, ft/s.")]
Altitude = Annotated[float, typer.Option("--h", help="Altitude, ft.")]
Open = Annotated[bool, typer.Option("--open", help="Open the page in the browser.")]
Out = Annotated[Path | None, typer.Option(metavar="DIR", parser=place,
                                          help="Folder for the results; else below results/.")]
Figures = Annotated[str, typer.Option("--figures", metavar="png|pdf|svg", help="Format of the figures.")]
Columns = Annotated[int, typer.Option(metavar="1|2", help="Width of the figures in columns of a journal's page: 3.5 or "
                                      "7.16 in.")]
