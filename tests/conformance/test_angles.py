"""Sine and cosine of the native flavour are right to a unit in the last place, for any angle."""
import math
import subprocess
from decimal import Decimal, localcontext
from pathlib import Path

import numpy as np
import pytest

from fmus.native_compiler import COMPILE, cc
from fmus.native_flavour import WRAPPER

HERE = Path(__file__).parent


def exact(x, first):
    """The series of sine (from x on) or cosine (from 1 on), to 40 digits; |x| < 1."""
    with localcontext() as context:
        context.prec = 40
        square, term, total = Decimal(x) ** 2, Decimal(x) if first else Decimal(1), Decimal(0)
        for n in range(first, 40, 2):
            total += term
            term *= -square / ((n + 1) * (n + 2))
        return total


@pytest.fixture(scope="module")
def computed(tmp_path_factory):
    """Angles, and what the C code makes of them: shape (angles, 2)."""
    program = tmp_path_factory.mktemp("angles") / "angles"
    cc(*COMPILE, f"-I{WRAPPER}", "-o", program, HERE / "native" / "angles.c", "-lm")
    random = np.random.default_rng(7)
    small = np.concatenate([random.uniform(-0.51, 0.51, 3000), random.uniform(-1, 1, 200) * 10.0 ** -np.arange(200),
                            [0.0, 0.5, -0.5, np.nextafter(0.5, 0), 5e-324]])
    large = random.uniform(-1, 1, 300) * 10.0 ** random.uniform(0, 20, 300)
    angles = [*small, *large, math.inf, -math.inf, math.nan]
    done = subprocess.run([program], input="\n".join(float(a).hex() for a in angles), check=True, text=True,
                          capture_output=True)
    found = np.array([[float.fromhex(word) for word in line.split()] for line in done.stdout.splitlines()])
    return angles, found, len(small)


def test_small_angles_are_right_to_a_unit_in_the_last_place(computed):
    angles, found, count = computed
    for x, pair in zip(angles[:count], found):
        for first, value in zip((1, 0), pair):
            right = exact(float(x), first)
            assert abs(Decimal(float(value)) - right) <= Decimal(math.ulp(float(right))) * Decimal("0.75"), (x, value)


def test_other_angles_are_the_librarys(computed):
    angles, found, count = computed
    for x, (s, c) in list(zip(angles, found))[count:-3]:
        assert (s, c) == pytest.approx((math.sin(x), math.cos(x)), rel=3e-16)
    assert np.isnan(found[-3:]).all()
