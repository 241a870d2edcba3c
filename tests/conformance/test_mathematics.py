"""What models may call: the same names on both backends, the same numbers in both flavours."""
import mathematics_model as model
import pytest
from native_loop import Loaded
from one_platform import one_platform

from fmus import floats, symbols
from fmus.builder import build
from fmus.check_model import BACKEND


def test_the_test_has_every_function_and_the_backends_have_the_same():
    assert {*model.ONE, *model.TWO, *model.OTHERS} - {"power"} == set(BACKEND)
    assert all(callable(getattr(symbols, name)) and callable(getattr(floats, name)) for name in BACKEND)


def test_both_flavours_give_the_same_numbers(tmp_path):
    rows = []
    for flavour in ("native", "python"):
        with one_platform():
            path = build(model, flavour, tmp_path)
        with Loaded(path) as member:
            member.begin()
            member.slave.exitInitializationMode()
            shown = []
            for k, (a, b) in enumerate([(0.3, -1.7), (0.9, 0.4), (0.5, -0.5), (1e-3, -1.0), (0.999, 5.0)]):
                member.set(a=a, b=b)
                member.slave.doStep(0.1 * k, 0.1)
                shown.append(member.get(*member.names("output")))
            rows.append(shown)
    for native, python in zip(*rows):
        assert native == pytest.approx(python, rel=4e-16 * 4, abs=1e-300)
