"""Fixtures shared by all tests: the FMU files, built where sources have changed."""
import os
import signal
from pathlib import Path

import pytest
from hypothesis import settings

from cosim.vehicle.registry import MODELS
from fmus.builder import build

# No deadline: a busy machine is no failure. In CI the same examples every time; elsewhere new ones are tried.
settings.register_profile("here", deadline=None)
settings.register_profile("ci", deadline=None, derandomize=True)
settings.load_profile("ci" if os.environ.get("CI") else "here")


# `nohup` and background jobs of a script ignore these, and programs that tests start and interrupt would inherit that.
for number, usual in ((signal.SIGINT, signal.default_int_handler), (signal.SIGHUP, signal.SIG_DFL)):
    if signal.getsignal(number) == signal.SIG_IGN:
        signal.signal(number, usual)


def pytest_addoption(parser):
    parser.addoption("--no-skips", action="store_true", help="Fail the run if a test was skipped.")


def pytest_sessionfinish(session):
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    # What the kernel forbids, no installation brings.
    skipped = [r for r in reporter.stats.get("skipped", ()) if "namespaces" not in str(r.longrepr)]
    if session.config.getoption("--no-skips") and skipped and not session.exitstatus:
        reporter.write_line("\n--no-skips: tests were skipped, so the run fails.", red=True)
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


@pytest.fixture(scope="session")
def python_fmus() -> dict[str, Path]:
    """The Python flavour's files, by model name."""
    return {name: build(module, "python") for name, module in MODELS.items()}


@pytest.fixture(scope="session")
def native_fmus() -> dict[str, Path]:
    """The native flavour's files, by model name."""
    return {name: build(module, "native") for name, module in MODELS.items()}


@pytest.fixture(scope="session")
def native_fmi3_fmus() -> dict[str, Path]:
    """The native flavour's files of FMI 3.0, by model name."""
    return {name: build(module, "native", fmi="3") for name, module in MODELS.items()}
