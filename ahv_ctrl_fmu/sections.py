"""Second-order filter sections in cascade, sampled by Tustin's rule.

    B(s) = (s^2/z^2 + 2 zeta_z s/z + 1) / (s^2/p^2 + 2 zeta_p s/p + 1)

is prewarped at z in its numerator and at p in its denominator. Without z (0) the numerator is 1; without p (0), or
with p beyond what the step can show, the section passes its input.
"""

COEFFICIENTS = 5  # of a section: b0, b1, b2, a1, a2
LARGEST_ANGLE = 1.5  # rad of p h / 2, which is pi/2 at half the sampling frequency


def polynomial(m, omega, zeta, h):
    """s^2/omega^2 + 2 zeta s/omega + 1 times (z + 1)^2: coefficients of z^2, z, 1."""
    k = 1 / m.tan(omega * h / 2)
    return k * k + 2 * zeta * k + 1, 2 * (1 - k * k), k * k - 2 * zeta * k + 1


def section(m, gains, h):
    """The COEFFICIENTS of one section for samples every h seconds; `gains` are z, zeta_z, p, zeta_p (rad/s)."""
    zero, zeta_zero, pole, zeta_pole = gains
    used = m.both(pole > 0, pole * h < 2 * LARGEST_ANGLE)
    has_zero = m.both(zero > 0, zero * h < 2 * LARGEST_ANGLE)
    a0, a1, a2 = polynomial(m, m.where(used, pole, 1.0), zeta_pole, h)
    above = polynomial(m, m.where(has_zero, zero, 1.0), zeta_zero, h)
    b0, b1, b2 = (m.where(has_zero, b, low_pass) for b, low_pass in zip(above, (1.0, 2.0, 1.0)))
    return [m.where(used, value / a0, otherwise)
            for value, otherwise in ((b0, 1.0), (b1, 0.0), (b2, 0.0), (a1, 0.0), (a2, 0.0))]


def at_rest(signal, count):
    """State of `count` sections in cascade that have always seen `signal`: 2 (count + 1) numbers."""
    return [signal] * (2 * (count + 1))


def cascade(coefficients, state, signal):
    """(output, next state) for one more sample of `signal`.

    The state has the last two samples of the input and of each section's output, the latest first.
    """
    new = []
    for i in range(0, len(coefficients), COEFFICIENTS):
        b0, b1, b2, a1, a2 = coefficients[i:i + COEFFICIENTS]
        place = 2 * (i // COEFFICIENTS)
        x1, x2, y1, y2 = state[place:place + 4]
        new += [signal, x1]
        signal = b0 * signal + b1 * x1 + b2 * x2 - a1 * y1 - a2 * y2
    return signal, [*new, signal, state[-2]]
