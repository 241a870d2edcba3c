"""The command line `ahv`: one command a file, each a few lines around a function that Python users call too.

Words and JSON keys are a contract. Errors are one sentence on stderr: exit status 1 for a run that failed, 2 for a
request that cannot be carried out, 70 for what nobody foresaw, which then is in a file to send us.
"""
import errno
import gc
import os
import sys
from typing import Annotated

import typer

from ..errors import Interrupted, RunError, UsageError
from ..master.quantities import is_number
from ..text import sentence
from . import (
    bench,
    build,
    campaign,
    check,
    compare,
    container,
    fit,
    info,
    linearize,
    playground,
    recover,
    run,
    simulate,
    ssp,
    sweep,
    trim,
    tune,
    view,
)
from .ending import ending
from .unforeseen import UNFORESEEN, unforeseen

# What the system says of a file that cannot be read or written where the user wants it.
REFUSED = (errno.ENOENT, errno.EACCES, errno.EPERM, errno.ENOTDIR, errno.EISDIR, errno.EEXIST, errno.ENAMETOOLONG,
           errno.ELOOP, errno.EROFS)

app = typer.Typer(no_args_is_help=True, pretty_exceptions_enable=False)
for command in (run, recover, compare, info, trim, linearize, simulate, ssp, container, check, campaign, sweep, fit,
                tune, build, playground, view):
    app.command()(getattr(command, command.__name__.rpartition(".")[2]))
app.command(context_settings={"allow_extra_args": True, "ignore_unknown_options": True})(bench.bench)


def show_version(wanted: bool) -> None:
    """Print the version and end, if that is `wanted`."""
    if wanted:
        from importlib.metadata import version

        print(f"ahv {version('ahv')}")
        raise typer.Exit


@app.callback()
def ahv(version: Annotated[bool, typer.Option("--version", callback=show_version, is_eager=True,
                                              help="Print the version.")] = False) -> None:
    """An air-breathing hypersonic vehicle and its controllers as FMUs, and a master that flies them."""


def main() -> None:
    """Entry point of the program: its exit status, with signals as an end that removes temporary files."""
    with ending():
        keep_output_apart()
        status = done(sys.argv[1:])
        gc.freeze()  # all memory goes with the process: looking through it first takes Python up to a second
        sys.exit(status)


def done(words: list[str]) -> int:
    """Carry out a command line: errors become one sentence on stderr; the exit status."""
    try:
        app(args=with_factor(words))
    except UsageError as error:
        return complain(error, 2)
    except Interrupted as error:
        return complain(error, 128 + error.number)
    except RunError as error:
        return complain(error, 1)
    except ModuleNotFoundError as error:
        return complain(f"{error}. `make setup` installs all packages.", 2)
    except OSError as error:
        if error.filename is None or error.errno not in REFUSED:
            return complain(unforeseen(error, words), UNFORESEEN)
        return complain(f"{error.filename}: {error.strerror}.", 2)
    except Exception as error:
        return complain(unforeseen(error, words), UNFORESEEN)
    return 0


def keep_output_apart() -> None:
    """What an FMU prints goes to standard error: standard output is for our answers alone."""
    ours = os.dup(1)
    os.dup2(2, 1)
    sys.stdout = os.fdopen(ours, "w", encoding=sys.stdout.encoding, errors=sys.stdout.errors)


def with_factor(words: list[str]) -> list[str]:
    """`--real-time` with its factor, which is 1 where none is given."""
    for i, word in enumerate(words):
        if word == "--real-time" and not is_number(words[i + 1] if i + 1 < len(words) else ""):
            return [*words[:i + 1], "1", *words[i + 1:]]
    return words


def complain(error: object, status: int) -> int:
    """Print `error`; the exit status."""
    print(f"ahv: {sentence(str(error))}", file=sys.stderr)
    return status
