"""The paper's adaptive neural law, equations (17)-(57), as pure functions of state, inputs, parameters.

State (19 numbers), in the order of `State`:
    V_ref[2], h_ref[2]   reference filters (67)
    V_integral, phi_1    velocity loop (19), (27)
    chi[4], chi_d[4]     differentiators (13) on the tracked angle and on gamma_d
    e_integral, phi_2    altitude loop (43), (57)
    elevator[2]          structural filter on the elevator, where it is used
and theta_trim, remembered from the start.
"""
from collections import namedtuple
from types import SimpleNamespace

from .differentiator import (
    differentiator_rate,
    differentiator_step,
    differentiator_transition,
    filter_rate,
    filter_step,
    filter_transition,
)
from .ports import gamma_command, limited, start_trim

NODES = 20
LAST = NODES - 1
HALF = NODES // 2
TINY, FAR = 1e-300, 750.0  # where all nodes are one; where exp(-distance) is 0
NEWTON_STEPS, DIFFERENCE = 6, 1e-6

State = namedtuple("State", "V_ref h_ref V_integral phi_1 chi chi_d e_integral phi_2 elevator theta_trim")


def unpack(x):
    """The state's numbers (a list) as a `State`."""
    return State(x[0:2], x[2:4], x[4], x[5], x[6:10], x[10:14], x[14], x[15], x[16:18], x[18])


def pack(s):
    """A `State` as a list of numbers."""
    return [*s.V_ref, *s.h_ref, s.V_integral, s.phi_1, *s.chi, *s.chi_d, s.e_integral, s.phi_2,
            *s.elevator, s.theta_trim]


def activation(m, dimensions):
    """h^T h of (11) for NODES nodes spaced evenly along the diagonal of a box.

    `dimensions` has (input, low, high, width) for each network input. The centres lie on a line, so h_j^2, which is
    exp(-distance^2) (the half cancels), is a Gaussian in the node's index j. It is summed from the node nearest the
    input to both ends: n nodes on it is weight_n ratio^n times as large, where neither is above 1 and the weights
    depend on parameters only.
    """
    line, c = [], 0.0
    for value, low, high, width in dimensions:
        offset, stride = (value - low) / width, (high - low) / (width * LAST)
        line.append((offset, stride))
        c = c + stride * stride
    place, distance, slope = 0.5, 0.0, 0.0
    for offset, stride in line:
        place = place + offset * (stride / m.fmax(c, TINY))
    nearest = m.floor(m.fmin(m.fmax(place, 0.0), LAST))
    for offset, stride in line:
        rest = offset - nearest * stride
        distance, slope = distance + rest * rest, slope + rest * (2 * stride)

    late = nearest > LAST / 2  # then the line is turned: HALF nodes or more lie ahead, fewer than HALF behind
    slope, behind = m.where(late, -slope, slope), m.where(late, LAST - nearest, nearest)
    factor, weights, q = 1.0, [1.0], m.exp(-2 * c)  # weight_n is exp(-c (n^2 - n))
    for _ in range(LAST - 1):
        factor = factor * q
        weights.append(weights[-1] * factor)
    ahead = weights[:HALF] + [m.where(n <= LAST - behind, weights[n - 1], 0.0) for n in range(HALF + 1, NODES)]
    others = [m.where(n <= behind, weights[n - 1], 0.0) for n in range(1, HALF)]
    up, down = m.exp(m.fmin(slope - c, 0.0)), m.exp(m.fmin(-slope - c, 0.0))
    nodes = 1 + up * polynomial(ahead, up) + down * polynomial(others, down)
    return m.where(distance < FAR, m.exp(-distance) * nodes, 0.0)  # beyond, nodes may be inf * 0


def polynomial(coefficients, z):
    """The polynomial with `coefficients` (of z^0 first) at z; in pairs, so that few products wait for others."""
    while len(coefficients) > 1:
        pairs = [even + z * odd for even, odd in zip(coefficients[::2], coefficients[1::2])]
        coefficients = pairs + coefficients[2 * len(pairs):]
        z = z * z
    return coefficients[0]


def tracked_angle(u, s, p):
    """gamma, moved to where the elevator first acts in the third derivative (c_theta = c_Q = 0: gamma)."""
    return u.gamma + p.c_theta * (u.theta - s.theta_trim) + p.c_Q * u.Q


def velocity_law(m, s, u, p):
    """(17), (19), (26), (27): a namespace with the fuel ratio and all that led to it."""
    error = u.V - s.V_ref[0]                                                            # (17)
    phi_0 = -p.kV1 * error - p.kV2 * s.V_integral + s.V_ref[1]                          # below (19)
    hh = activation(m, ((u.V, p.net1_V_min, p.net1_V_max, p.net1_V_width),
                        (phi_0, p.net1_Phi0_min, p.net1_Phi0_max, p.net1_Phi0_width)))
    network = 0.5 * error * s.phi_1 * hh                                                # (26)
    wanted = (phi_0 - network) / p.kV                                                   # (19)
    fuel_ratio, saturated = limited(m, wanted, p.fuel_ratio_min, p.fuel_ratio_max)
    return SimpleNamespace(error=error, network=network, fuel_ratio=fuel_ratio, saturated=saturated,
                           growth=0.5 * p.lambda_1 * error * error * hh)                # (27)


def errors(m, s, u, p):
    """(43), (47): e0, its estimated derivatives e1, e2, and gamma_d."""
    gamma_d = gamma_command(m, u.h, u.V, s.h_ref, p)
    e0 = tracked_angle(u, s, p) - gamma_d
    z2 = s.chi[1]
    z3 = m.where(p.z3_from_pitch_rate, p.pitch_rate_gain * (u.Q - z2), s.chi[2])
    return gamma_d, e0, z2 - s.chi_d[1], z3 - s.chi_d[2]


def altitude_activation(m, u, delta_0, p):
    """h^T h of the altitude network at X2 = [gamma, theta, Q, delta_e0]."""
    return activation(m, ((u.gamma, p.net2_gamma_min, p.net2_gamma_max, p.net2_gamma_width),
                          (u.theta, p.net2_theta_min, p.net2_theta_max, p.net2_theta_width),
                          (u.Q, p.net2_Q_min, p.net2_Q_max, p.net2_Q_width),
                          (p.direction * delta_0, p.net2_delta0_min, p.net2_delta0_max, p.net2_delta0_width)))


def elevator_wanted(delta_0, E, hh, phi_2, p):
    """(56), (49): the network's signal and the elevator before filter and limits."""
    network = 0.5 * E * phi_2 * hh                                                      # (56)
    return network, p.direction * (delta_0 - network) / p.kh                            # (49)


def altitude_law(m, s, u, p):
    """(36), (43)-(57): a namespace with the elevator and all that led to it."""
    mu = p.mu
    gamma_d, e0, e1, e2 = errors(m, s, u, p)
    E = e2 + 3 * mu * e1 + 3 * mu**2 * e0 + mu**3 * s.e_integral                        # (48)
    delta_0 = -p.kh1 * E + s.chi_d[3] - 3 * mu * e2 - 3 * mu**2 * e1 - mu**3 * e0       # (49)
    hh = altitude_activation(m, u, delta_0, p)
    network, wanted = elevator_wanted(delta_0, E, hh, s.phi_2, p)
    sent = m.where(p.elevator_bandwidth > 0, s.elevator[0], wanted)
    elevator, saturated = limited(m, sent, p.elevator_min, p.elevator_max)
    return SimpleNamespace(gamma_d=gamma_d, e0=e0, E=E, delta_0=delta_0, hh=hh, network=network, wanted=wanted,
                           elevator=elevator, saturated=saturated,
                           growth=0.5 * p.lambda_2 * E * E * hh)                        # (57)


def filter_omega(m, p):
    """The structural filter's bandwidth; where it is not used (0), any harmless one."""
    return m.where(p.elevator_bandwidth > 0, p.elevator_bandwidth, 1.0)


def start(m, u, p):
    """References, filters and differentiators at rest where the vehicle is, integrals such that the first
    outputs are the trim: the nominal vehicle's at the measured V and h, or the given one."""
    fuel_ratio, elevator, theta_trim = start_trim(m, u, p)
    rest = State(V_ref=[u.V, 0.0], h_ref=[u.h, 0.0], V_integral=-p.kV * fuel_ratio / p.kV2, phi_1=0.0,
                 chi=[0.0] * 4, chi_d=[gamma_command(m, u.h, u.V, [u.h, 0.0], p), 0.0, 0.0, 0.0],
                 e_integral=0.0, phi_2=0.0, elevator=[elevator, 0.0], theta_trim=theta_trim)
    rest = rest._replace(chi=[tracked_angle(u, rest, p), 0.0, 0.0, 0.0])
    _, e0, e1, e2 = errors(m, rest, u, p)
    mu, wanted = p.mu, p.direction * p.kh * elevator
    _, phi_2 = settled(m, u, p, wanted, 0.0)
    E, _ = settled(m, u, p, wanted, 3 * mu * e2 + 3 * mu**2 * e1 + mu**3 * e0, phi_2)
    return pack(rest._replace(e_integral=(E - e2 - 3 * mu * e1 - 3 * mu**2 * e0) / mu**3, phi_2=phi_2))


def settled(m, u, p, wanted, other, phi_2=None):
    """E^ and phi_2 for which (49) gives delta_0 - delta_1 = `wanted`, where `other` are the terms of delta_0
    beside E^; with phi_2 in its equilibrium in (57), or as given."""
    def at(delta_0):
        E = -(delta_0 + other) / p.kh1
        hh = altitude_activation(m, u, delta_0, p)
        phi = p.lambda_2 * E * E * hh / 4 if phi_2 is None else phi_2
        return E, phi, delta_0 - 0.5 * E * phi * hh - wanted

    delta_0 = wanted
    for _ in range(NEWTON_STEPS):
        residual, beside = at(delta_0)[2], at(delta_0 + DIFFERENCE)[2]
        delta_0 = delta_0 - residual * DIFFERENCE / (beside - residual)
    E, phi, _ = at(delta_0)
    return E, phi


def derivative(m, t, x, u, p):
    """dx/dt of the law in continuous time, which `advance` steps: of all states but the last, a memory."""
    s = unpack(x)
    a = (p.a1, p.a2, p.a3, p.a4)
    velocity, altitude = velocity_law(m, s, u, p), altitude_law(m, s, u, p)
    return pack(State(
        V_ref=filter_rate(s.V_ref, u.V_command, p.reference_omega, p.reference_zeta),
        h_ref=filter_rate(s.h_ref, u.h_command, p.reference_omega, p.reference_zeta),
        V_integral=m.where(velocity.saturated, 0.0, velocity.error),
        phi_1=velocity.growth - 2 * s.phi_1,
        chi=differentiator_rate(s.chi, tracked_angle(u, s, p), p.R, a),
        chi_d=differentiator_rate(s.chi_d, altitude.gamma_d, p.R_d, a),
        e_integral=m.where(altitude.saturated, 0.0, altitude.e0),
        phi_2=altitude.growth - 2 * s.phi_2,
        elevator=filter_rate(s.elevator, altitude.wanted, filter_omega(m, p), p.elevator_damping),
        theta_trim=0.0))[:-1]


def prepare(m, p, h):
    """40 transition entries for steps of h: reference filter (4), differentiators on y (16) and gamma_d (16),
    structural filter (4)."""
    a = (p.a1, p.a2, p.a3, p.a4)
    return [*filter_transition(p.reference_omega, p.reference_zeta, h),
            *differentiator_transition(p.R, a, h), *differentiator_transition(p.R_d, a, h),
            *filter_transition(filter_omega(m, p), p.elevator_damping, h)]


def advance(m, t, h, x, u, p, c):
    """One step of h seconds with the inputs held: exact where the law is linear, second order elsewhere."""
    s = unpack(x)
    a = (p.a1, p.a2, p.a3, p.a4)
    velocity, altitude = velocity_law(m, s, u, p), altitude_law(m, s, u, p)
    y = tracked_angle(u, s, p)
    V_ref = filter_step(c[0:4], s.V_ref, u.V_command, u.V_command, h, p.reference_omega, p.reference_zeta)
    h_ref = filter_step(c[0:4], s.h_ref, u.h_command, u.h_command, h, p.reference_omega, p.reference_zeta)
    gamma_d = gamma_command(m, u.h, u.V, h_ref, p)
    new = State(
        V_ref=V_ref, h_ref=h_ref,
        V_integral=s.V_integral + m.where(velocity.saturated, 0.0, h / 2 * (velocity.error + u.V - V_ref[0])),
        phi_1=s.phi_1,
        chi=differentiator_step(c[4:20], s.chi, y, y, h, p.R, a),
        chi_d=differentiator_step(c[20:36], s.chi_d, altitude.gamma_d, gamma_d, h, p.R_d, a),
        e_integral=s.e_integral + m.where(altitude.saturated, 0.0, h / 2 * (altitude.e0 + y - gamma_d)),
        phi_2=s.phi_2, elevator=s.elevator, theta_trim=s.theta_trim)
    decay = m.exp(-2 * h)
    later_velocity, later_altitude = velocity_law(m, new, u, p), altitude_law(m, new, u, p)
    phi_1 = decay * s.phi_1 + (1 - decay) / 4 * (velocity.growth + later_velocity.growth)
    phi_2 = decay * s.phi_2 + (1 - decay) / 4 * (altitude.growth + later_altitude.growth)
    _, wanted = elevator_wanted(later_altitude.delta_0, later_altitude.E, later_altitude.hh, phi_2, p)
    elevator = filter_step(c[36:40], s.elevator, altitude.wanted, wanted, h, filter_omega(m, p), p.elevator_damping)
    return pack(new._replace(phi_1=phi_1, phi_2=phi_2, elevator=elevator))


def outputs(m, t, x, u, p):
    """Every output of the table, in its units."""
    s = unpack(x)
    velocity, altitude = velocity_law(m, s, u, p), altitude_law(m, s, u, p)
    return {
        "fuel_ratio": velocity.fuel_ratio,
        "elevator": altitude.elevator,
        "V_reference": s.V_ref[0],
        "h_reference": s.h_ref[0],
        "V_error": velocity.error,
        "h_error": u.h - s.h_ref[0],
        "gamma_command": altitude.gamma_d,
        "gamma_error": altitude.e0,
        "error_function": altitude.E,
        "phi_hat_1": s.phi_1,
        "phi_hat_2": s.phi_2,
        "network_1": velocity.network,
        "network_2": altitude.network,
        "fuel_ratio_saturated": velocity.saturated,
        "elevator_saturated": altitude.saturated,
    }
