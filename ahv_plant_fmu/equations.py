"""Equations (1)-(9) of the paper: forces, moments, and the nine state derivatives.

State x = [V, h, gamma, theta, Q, eta1, eta1_dot, eta2, eta2_dot].
`m` is the mathematics backend (floats or CasADi symbols), `p` has the coefficients as attributes,
`scale` one factor per coefficient group (1 is nominal).
"""


def dynamic_pressure(m, V, h, p):
    """q = rho V^2 / 2 with the exponential atmosphere of (8), lbf/ft^2."""
    return 0.5 * p.air_density_0 * V * V * m.exp((p.h_0 - h) / p.h_scale)


def thrust_slope(alpha, p):
    """dT/dPhi of (8), (9), lbf/ft."""
    return ((p.beta_1 * alpha + p.beta_3) * alpha + p.beta_5) * alpha + p.beta_7


def thrust_offset(alpha, p):
    """T at Phi = 0 of (8), (9), lbf/ft."""
    return ((p.beta_2 * alpha + p.beta_4) * alpha + p.beta_6) * alpha + p.beta_8


# The forces are polynomials in alpha whose coefficients held inputs and parameters decide: these are computed once a
# step, so factors stand with them.


def thrust(alpha, fuel_ratio, p, scale=1.0):
    """`scale` times T of (8), (9), lbf/ft."""
    cubic, square = scale * (p.beta_1 * fuel_ratio + p.beta_2), scale * (p.beta_3 * fuel_ratio + p.beta_4)
    linear, constant = scale * (p.beta_5 * fuel_ratio + p.beta_6), scale * (p.beta_7 * fuel_ratio + p.beta_8)
    return ((cubic * alpha + square) * alpha + linear) * alpha + constant


def lift(q, alpha, elevator, p, scale=1.0):
    """`scale` times L of (8), lbf/ft."""
    area = scale * p.reference_area
    return q * (area * p.CL_alpha * alpha + area * (p.CL_elevator * elevator + p.CL_0))


def drag(q, alpha, elevator, p, scale=1.0):
    """`scale` times D of (8), lbf/ft."""
    area = scale * p.reference_area
    return q * ((area * p.CD_alpha2 * alpha + area * p.CD_alpha) * alpha
                + area * ((p.CD_elevator2 * elevator + p.CD_elevator) * elevator + p.CD_0))


def aerodynamic_moment(q, alpha, elevator, p, scale=1.0):
    """`scale` times the part of M in (8) that is not due to thrust, lbf.ft/ft."""
    volume = scale * p.reference_area * p.chord
    return q * ((volume * p.CM_alpha2 * alpha + volume * p.CM_alpha) * alpha
                + volume * (p.CM_0 + p.CM_elevator * elevator))


def generalised_forces(alpha, elevator, p, scale=1.0):
    """`scale` times N1, N2 of (8), 1/s^2."""
    return ((scale * p.N1_alpha2 * alpha + scale * p.N1_alpha) * alpha + scale * p.N1_0,
            (scale * p.N2_alpha2 * alpha + scale * p.N2_alpha) * alpha
            + scale * (p.N2_0 + p.N2_elevator * elevator))


def forces(m, x, fuel_ratio, elevator, scale, p):
    """(q, T, L, D, M, N1, N2) of (8), (9) with every coefficient group scaled."""
    alpha = x[3] - x[2]
    q = dynamic_pressure(m, x[0], x[1], p)
    T = thrust(alpha, fuel_ratio, p, scale.thrust)
    L = lift(q, alpha, elevator, p, scale.lift)
    D = drag(q, alpha, elevator, p, scale.drag)
    M = p.thrust_arm * T + aerodynamic_moment(q, alpha, elevator, p, scale.moment)
    N1, N2 = generalised_forces(alpha, elevator, p, scale.forces)
    return q, T, L, D, M, N1, N2


def derivative(m, x, fuel_ratio, elevator, scale, p):
    """dx/dt of (1)-(7), nine numbers, per second."""
    V, _, gamma, theta, Q, eta1, eta1_dot, eta2, eta2_dot = x
    alpha = theta - gamma
    _, T, L, D, M, N1, N2 = forces(m, x, fuel_ratio, elevator, scale, p)
    mass, Iyy, g, psi1, psi2 = p.mass, p.pitch_inertia, p.gravity, p.psi_1, p.psi_2
    sin_gamma = m.sin(gamma)

    V_dot = (T * m.cos(alpha) - D) / mass - g * sin_gamma                               # (1)
    h_dot = V * sin_gamma                                                               # (2)
    gamma_dot = g / V * ((L + T * m.sin(alpha)) / (mass * g) - m.cos(gamma))            # (3)
    # (6), (7): k1 eta1'' + c eta2'' = r1, c eta1'' + k2 eta2'' = r2; printed with s = 1, energy is kept with s = -1
    s = p.coupling_sign
    k1, k2, c = 1 + s * psi1 * psi1 / Iyy, 1 + s * psi2 * psi2 / Iyy, s * psi1 * psi2 / Iyy
    r1 = -2 * p.zeta_1 * p.omega_1 * eta1_dot - p.omega_1 * p.omega_1 * eta1 + N1 - s * psi1 / Iyy * M
    r2 = -2 * p.zeta_2 * p.omega_2 * eta2_dot - p.omega_2 * p.omega_2 * eta2 + N2 - s * psi2 / Iyy * M
    determinant = k1 * k2 - c * c
    eta1_ddot = k2 / determinant * r1 - c / determinant * r2
    eta2_ddot = k1 / determinant * r2 - c / determinant * r1
    Q_dot = (M + psi1 * eta1_ddot + psi2 * eta2_ddot) / Iyy                             # (5)
    return [V_dot, h_dot, gamma_dot, Q, Q_dot, eta1_dot, eta1_ddot, eta2_dot, eta2_ddot]  # (4)
