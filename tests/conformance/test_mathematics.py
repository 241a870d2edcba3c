"""The native flavour's mathematical functions against decimal arithmetic of 60 digits; whose functions it calls."""
import math
import re
import subprocess
import zipfile
from decimal import Decimal, localcontext
from pathlib import Path

import numpy as np
import pytest

from fmus.native_code import OWN
from fmus.native_compiler import COMPILE, cc
from fmus.native_flavour import WRAPPER

HERE = Path(__file__).parent
NAMES = ("exp", "sin", "cos", "tan", "asin")
EXACT = {"sqrt", "floor", "ceil", "fabs"}
NO_FUNCTIONS = {"if", "for", "while", "switch", "return", "sizeof", "defined", "visibility"}


@pytest.fixture(scope="module")
def compute(tmp_path_factory):
    """Arguments, shape (n,) -> what the C code makes of them, name -> values of shape (n,)."""
    program = tmp_path_factory.mktemp("mathematics") / "mathematics"
    cc(*COMPILE, f"-I{WRAPPER}", "-o", program, HERE / "native" / "mathematics.c", "-lm")

    def computed(arguments):
        done = subprocess.run([program], input="\n".join(float(x).hex() for x in arguments), check=True, text=True,
                              capture_output=True)
        rows = [[float.fromhex(word) for word in line.split()] for line in done.stdout.splitlines()]
        return dict(zip(NAMES, np.array(rows).T))
    return computed


def series(x: Decimal, first: int) -> Decimal:
    """The series of sine (`first` is 1) or cosine (0)."""
    term, total = x if first else Decimal(1), Decimal(0)
    for n in range(first, 90, 2):
        total += term
        term *= -x * x / ((n + 1) * (n + 2))
    return total


def exact(name: str, x: float) -> Decimal:
    """The function's value, to 50 digits or so; angles are at most 8."""
    value = Decimal(x)
    match name:
        case "exp":
            return value.exp()
        case "sin" | "cos":
            return series(value, name == "sin")
        case "tan":
            return series(value, 1) / series(value, 0)
    y = Decimal(math.asin(x))
    for _ in range(3):
        y += (value - series(y, 1)) / series(y, 0)
    return y


RANGES = [("exp", -1, 1, 1.3), ("exp", -744, 709, 1.3), ("exp", -745, -708, 1.3), ("sin", -0.51, 0.51, 0.75),
          ("cos", -0.51, 0.51, 0.75), ("sin", -8, 8, 0.85), ("cos", -8, 8, 0.85), ("tan", -1.57, 1.57, 2.5),
          ("asin", -0.5, 0.5, 0.75), ("asin", -0.999, 0.999, 2.5)]


@pytest.mark.parametrize(("name", "low", "high", "units"), RANGES)
def test_functions_are_right_to_units_in_the_last_place(compute, name, low, high, units):
    random = np.random.default_rng(7)
    small = random.uniform(-1, 1, 40) * 10.0 ** -np.arange(0, 320, 8)
    arguments = [*random.uniform(low, high, 300), *small[(small > low) & (small < high)], max(low, 0.0), 5e-324]
    with localcontext() as context:
        context.prec = 60
        for x, value in zip(arguments, compute(arguments)[name]):
            right = exact(name, float(x))
            assert abs(Decimal(float(value)) - right) <= Decimal(math.ulp(float(right))) * Decimal(units), (x, value)


def test_angles_far_from_zero(compute):
    random = np.random.default_rng(8)
    angles = [*random.uniform(-1, 1, 300) * 10.0 ** random.uniform(0, 20, 300), *np.arange(1, 400) * math.pi / 2]
    found = compute(angles)
    assert found["sin"] == pytest.approx([math.sin(x) for x in angles], rel=3e-16)
    assert found["cos"] == pytest.approx([math.cos(x) for x in angles], rel=3e-16)


def test_what_has_no_number_and_what_is_too_large(compute):
    found = compute([math.inf, -math.inf, math.nan, 709.79, -745.2, 709.78, 1.0, -1.0, 1.0000001])
    assert found["exp"][:2].tolist() == [math.inf, 0] and found["exp"][3:5].tolist() == [math.inf, 0]
    assert found["exp"][5] == pytest.approx(math.exp(709.78), rel=3e-16)
    assert all(np.isnan(found[name][2]) for name in NAMES)
    assert all(np.isnan(found[name][:2]).all() for name in ("sin", "cos", "tan", "asin"))
    assert found["asin"][6:8].tolist() == [math.pi / 2, -math.pi / 2] and np.isnan(found["asin"][8])


def test_no_other_function_of_the_c_library_is_called_by_our_models(native_fmus):
    for fmu in native_fmus.values():
        with zipfile.ZipFile(fmu) as archive:
            code = archive.read("sources/model.c").decode()
        called = set(re.findall(r"\b(?!casadi_|model_)([a-z]\w*)\s*\(", code)) - {f"own_{name}" for name in OWN}
        assert called - NO_FUNCTIONS <= EXACT, fmu
