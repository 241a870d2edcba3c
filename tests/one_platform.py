"""Builds for this machine alone, where a test has no use for the other platforms' libraries."""
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from fmus import native_flavour


@contextmanager
def one_platform() -> Iterator[None]:
    """While this lasts, native FMUs have the library for Linux on x86-64 only."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(native_flavour, "PLATFORMS", {"x86_64-linux": native_flavour.PLATFORMS["x86_64-linux"]})
        yield
