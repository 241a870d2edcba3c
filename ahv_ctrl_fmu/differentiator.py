"""Second-order reference filter (67) and high-order tracking differentiator (13), stepped exactly."""
from .linear import apply, exponential


def differentiator_rate(chi, signal, R, a):
    """d chi/dt of (13): chi follows `signal` and its first three derivatives."""
    a1, a2, a3, a4 = a
    return [chi[1], chi[2], chi[3],
            -R**4 * (a1 * (chi[0] - signal) + a2 * chi[1] / R + a3 * chi[2] / R**2 + a4 * chi[3] / R**3)]


def differentiator_transition(m, R, a, h):
    """16 entries, row-major: exp(h A) of (13)'s homogeneous part.

    Computed in the scaled states chi_i / R^(i-1), whose matrix is R times a companion matrix of order 1.
    """
    a1, a2, a3, a4 = a
    k = R * h
    scaled = exponential(m, [[0, k, 0, 0], [0, 0, k, 0], [0, 0, 0, k], [-a1 * k, -a2 * k, -a3 * k, -a4 * k]])
    return [scaled[i][j] * (R**(i - j) if i >= j else 1 / R**(j - i)) for i in range(4) for j in range(4)]


def differentiator_step(transition, chi, signal_0, signal_1, h, R, a):
    """(13) over h seconds, exact for a signal that runs straight from signal_0 to signal_1."""
    slope = (signal_1 - signal_0) / h
    lag = a[1] * slope / (a[0] * R)  # behind a ramp, chi settles at [signal - lag, slope, 0, 0]
    deviation = apply(transition, [chi[0] - signal_0 + lag, chi[1] - slope, chi[2], chi[3]])
    return [deviation[0] + signal_1 - lag, deviation[1] + slope, deviation[2], deviation[3]]


def filter_rate(r, command, omega, zeta):
    """d r/dt of (67), r = [reference, its rate]."""
    return [r[1], omega * omega * (command - r[0]) - 2 * zeta * omega * r[1]]


def filter_transition(m, omega, zeta, h):
    """4 entries, row-major: exp(h A) of (67)'s homogeneous part, computed in the states r and dr/dt / omega."""
    k = omega * h
    (stay, from_rate), (to_rate, keep) = exponential(m, [[0, k], [-k, -2 * zeta * k]])
    return [stay, from_rate / omega, to_rate * omega, keep]


def filter_step(transition, r, command_0, command_1, h, omega, zeta):
    """(67) over h seconds, exact for a command that runs straight from command_0 to command_1."""
    slope = (command_1 - command_0) / h
    lag = 2 * zeta * slope / omega  # behind a ramp, r settles at [command - lag, slope]
    deviation = apply(transition, [r[0] - command_0 + lag, r[1] - slope])
    return [deviation[0] + command_1 - lag, deviation[1] + slope]
