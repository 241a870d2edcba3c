"""Poles and zeros as `ahv linearize` prints them."""
import pytest

from cosim.analysis.statespace import roots
from cosim.cli.show import root


@pytest.mark.parametrize("value, shown", [
    (-2.5, "-2.500"), (-2.5 + 1e-9j, "-2.500"), (-0.5 + 2j, "-0.500 +-2.000j"), (1e-12 + 2j, "0.000 +-2.000j"),
    (0.0, "0.000"), (-1e-8, "0.000"),
    (-2e-4, "-0.0002"), (3.14159e-3, "0.00314"), (-1e-4 + 2e-3j, "-0.0001 +-0.002j")])
def test_a_root_is_shown_with_its_sign_however_slow(value, shown):
    (found,) = roots([complex(value)])
    assert root(found) == shown
