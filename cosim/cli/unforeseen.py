"""What nobody foresaw: one sentence, and a file with all that is needed to find out why."""
import os
import platform
import shlex
import sys
import tempfile
import traceback
from importlib.metadata import PackageNotFoundError, version

UNFORESEEN = 70  # exit status; EX_SOFTWARE of sysexits.h
PACKAGES = ("ahv", "fmpy", "numpy", "pydantic", "typer")


def unforeseen(error: BaseException, words: list[str]) -> str:
    """A sentence about `error`, which the command line `words` led to, and which a new file in the temporary folder
    tells in full."""
    what = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
    try:
        handle, file = tempfile.mkstemp(prefix="ahv_error_", suffix=".txt")
        with os.fdopen(handle, "w", encoding="utf-8", errors="backslashreplace") as report:
            report.write(f"ahv {shlex.join(words)}\n{versions()}\n\n{''.join(traceback.format_exception(error))}")
    except OSError as full:
        return f"This is a mistake in ahv: {what}. A report of it could not be written: {full.strerror}."
    return f"This is a mistake in ahv: {what}. Please send us {file}, which tells where it happened."


def versions() -> str:
    """The versions of what took part, on one line."""
    found = [f"Python {sys.version.split()[0]}", platform.platform()]
    for package in PACKAGES:
        try:
            found.append(f"{package} {version(package)}")
        except PackageNotFoundError:
            continue
    return ", ".join(found)
