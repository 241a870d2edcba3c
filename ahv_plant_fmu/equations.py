"""Equations (1)-(9) of the paper: forces, moments, and the nine state derivatives.

State x = [V, h, gamma, theta, Q, eta1, eta1_dot, eta2, eta2_dot].
`m` is the mathematics backend (floats or CasADi symbols), `p` has the coefficients as attributes,
`scale` one factor per coefficient group (1 is nominal).
"""


def dynamic_pressure(m, V, h, p):
    """q = rho V^2 / 2 with the exponential atmosphere of (8), lbf/ft^2."""
    return 0.5 * p.air_density_0 * V * V * m.exp((p.h_0 - h) / p.h_scale)


def polynomial(coefficients, alpha):
    """The polynomial with `coefficients`, of the highest power first, at alpha."""
    first, *others = coefficients
    for coefficient in others:
        first = first * alpha + coefficient
    return first


def scaled(factor, coefficients):
    """The coefficients of a polynomial that is `factor` times as large."""
    return [factor * coefficient for coefficient in coefficients]


def thrust_slope(alpha, p):
    """dT/dPhi of (8), (9), lbf/ft."""
    return polynomial((p.beta_1, p.beta_3, p.beta_5, p.beta_7), alpha)


def thrust_offset(alpha, p):
    """T at Phi = 0 of (8), (9), lbf/ft."""
    return polynomial((p.beta_2, p.beta_4, p.beta_6, p.beta_8), alpha)


def thrust_coefficients(fuel_ratio, p):
    """T of (8), (9), lbf/ft, as a polynomial in alpha."""
    return (p.beta_1 * fuel_ratio + p.beta_2, p.beta_3 * fuel_ratio + p.beta_4,
            p.beta_5 * fuel_ratio + p.beta_6, p.beta_7 * fuel_ratio + p.beta_8)


def lift_coefficients(elevator, p):
    """L/q of (8), ft, as a polynomial in alpha."""
    return scaled(p.reference_area, (p.CL_alpha, p.CL_elevator * elevator + p.CL_0))


def drag_coefficients(elevator, p):
    """D/q of (8), ft, as a polynomial in alpha."""
    return scaled(p.reference_area, (p.CD_alpha2, p.CD_alpha,
                                     (p.CD_elevator2 * elevator + p.CD_elevator) * elevator + p.CD_0))


def moment_coefficients(elevator, p):
    """The part of M in (8) that is not due to thrust, over q, ft^2, as a polynomial in alpha."""
    return scaled(p.reference_area * p.chord, (p.CM_alpha2, p.CM_alpha, p.CM_0 + p.CM_elevator * elevator))


def force_coefficients(elevator, p):
    """N1 and N2 of (8), 1/s^2, as polynomials in alpha."""
    return ((p.N1_alpha2, p.N1_alpha, p.N1_0), (p.N2_alpha2, p.N2_alpha, p.N2_0 + p.N2_elevator * elevator))


def thrust(alpha, fuel_ratio, p):
    """T of (8), (9), lbf/ft."""
    return polynomial(thrust_coefficients(fuel_ratio, p), alpha)


def lift(q, alpha, elevator, p):
    """L of (8), lbf/ft."""
    return q * polynomial(lift_coefficients(elevator, p), alpha)


def drag(q, alpha, elevator, p):
    """D of (8), lbf/ft."""
    return q * polynomial(drag_coefficients(elevator, p), alpha)


def aerodynamic_moment(q, alpha, elevator, p):
    """The part of M in (8) that is not due to thrust, lbf.ft/ft."""
    return q * polynomial(moment_coefficients(elevator, p), alpha)


def generalised_forces(alpha, elevator, p):
    """N1, N2 of (8), 1/s^2."""
    return [polynomial(coefficients, alpha) for coefficients in force_coefficients(elevator, p)]


def forces(m, x, fuel_ratio, elevator, scale, p):
    """(q, T, L, D, M, N1, N2) of (8), (9) with every coefficient group scaled."""
    alpha = x[3] - x[2]
    q = dynamic_pressure(m, x[0], x[1], p)
    T = polynomial(scaled(scale.thrust, thrust_coefficients(fuel_ratio, p)), alpha)
    L = q * polynomial(scaled(scale.lift, lift_coefficients(elevator, p)), alpha)
    D = q * polynomial(scaled(scale.drag, drag_coefficients(elevator, p)), alpha)
    M = p.thrust_arm * T + q * polynomial(scaled(scale.moment, moment_coefficients(elevator, p)), alpha)
    N1, N2 = (polynomial(scaled(scale.forces, of_mode), alpha) for of_mode in force_coefficients(elevator, p))
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
