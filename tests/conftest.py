"""Fixtures shared by all tests. The FMUs are built by `make test` before the tests run."""
from pathlib import Path

import pytest

from fmus.build import MODELS, build


@pytest.fixture(scope="session")
def python_fmus() -> dict[str, Path]:
    """The Python flavour's files, by model name."""
    return {name: build(name, "python") for name in MODELS}


@pytest.fixture(scope="session")
def native_fmus() -> dict[str, Path]:
    """The native flavour's files, by model name."""
    return {name: build(name, "native") for name in MODELS}
