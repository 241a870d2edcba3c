"""Filter sections against scipy's bilinear transform and the sine they are prewarped for."""
import numpy as np
import pytest
from scipy.signal import bilinear, lfilter

from ahv_ctrl_fmu.sections import at_rest, cascade, section
from fmus import floats

NOTCH, LOW_PASS, NONE = (14.558, 0.063287, 14.566, 0.47241), (0.0, 0.0, 101.94, 0.4709), (0.0, 0.0, 0.0, 0.0)
STEP = 0.01


def filtered(gains, signal, rest=0.0):
    c = [value for g in gains for value in section(floats, g, STEP)]
    state, result = at_rest(rest, len(gains)), []
    for x in signal:
        y, state = cascade(c, state, x)
        result.append(y)
    return np.array(result)


def tustin(omega, zeta):
    """Numerator's or denominator's z polynomial of s^2/omega^2 + 2 zeta s/omega + 1, prewarped at omega."""
    warped = 2 / STEP * np.tan(omega * STEP / 2)
    return bilinear([1 / warped**2, 2 * zeta / warped, 1.0], [1.0, 0.0, 0.0], 1 / STEP)[0]


@pytest.mark.parametrize("gains", [NOTCH, LOW_PASS])
def test_a_section_is_the_bilinear_transform(gains):
    zero, zeta_zero, pole, zeta_pole = gains
    b = tustin(zero, zeta_zero) if zero else np.array([1.0, 2.0, 1.0]) * STEP**2 / 4
    a = tustin(pole, zeta_pole)
    if not zero:
        b = b * a.sum() / b.sum()
    signal = np.random.default_rng(1).normal(size=200)
    assert np.allclose(filtered([gains], signal), lfilter(b, a, signal), rtol=0, atol=1e-10)


def test_sections_in_cascade_follow_each_other():
    signal = np.random.default_rng(2).normal(size=200)
    assert np.allclose(filtered([NOTCH, LOW_PASS], signal), filtered([LOW_PASS], filtered([NOTCH], signal)), atol=1e-12)


def test_a_section_without_poles_or_with_poles_beyond_the_step_passes_its_input():
    signal = np.random.default_rng(3).normal(size=50)
    for gains in (NONE, (0.0, 0.0, 400.0, 0.5)):
        assert np.array_equal(filtered([gains], signal), signal)


def test_what_is_at_rest_stays_at_rest():
    assert np.allclose(filtered([NOTCH, LOW_PASS], np.full(100, 3.0), rest=3.0), 3.0, rtol=1e-12)
