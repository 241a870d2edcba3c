"""Level flight: the equilibrium of (1)-(7) at a given speed and altitude."""
from types import SimpleNamespace

from .equations import (
    aerodynamic_moment,
    derivative,
    drag,
    dynamic_pressure,
    generalised_forces,
    lift,
    thrust_offset,
    thrust_slope,
)

NOMINAL = SimpleNamespace(thrust=1.0, lift=1.0, drag=1.0, moment=1.0, forces=1.0)
ITERATIONS = 12
DIFFERENCE = 1e-6


def level_trim(m, V, h, p):
    """Solve level flight (gamma = Q = 0, all derivatives zero) at V (ft/s) and h (ft).

    Drag fixes the thrust and thrust the fuel ratio, so two unknowns remain, the angle of attack and
    the elevator; they make lift and moment balance. Newton with difference quotients, a fixed number
    of iterations so that it can be traced; `residual` tells whether it arrived.

    Returns a namespace: theta, elevator (rad), fuel_ratio, eta1, eta2, residual (the largest
    magnitude among the state derivatives, mixed units per second).
    """
    q = dynamic_pressure(m, V, h, p)
    weight = p.mass * p.gravity

    def imbalance(alpha, elevator):
        D = drag(q, alpha, elevator, p)
        T = D / m.cos(alpha)
        return ((lift(q, alpha, elevator, p) + T * m.sin(alpha)) / weight - 1,
                (p.thrust_arm * T + aerodynamic_moment(q, alpha, elevator, p)) / p.pitch_inertia)

    alpha, elevator = 0.03, 0.2
    for _ in range(ITERATIONS):
        f, g = imbalance(alpha, elevator)
        f_a, g_a = imbalance(alpha + DIFFERENCE, elevator)
        f_e, g_e = imbalance(alpha, elevator + DIFFERENCE)
        fa, ga = (f_a - f) / DIFFERENCE, (g_a - g) / DIFFERENCE
        fe, ge = (f_e - f) / DIFFERENCE, (g_e - g) / DIFFERENCE
        determinant = fa * ge - fe * ga
        alpha = alpha - (f * ge - fe * g) / determinant
        elevator = elevator - (fa * g - f * ga) / determinant

    T = drag(q, alpha, elevator, p) / m.cos(alpha)
    fuel_ratio = (T - thrust_offset(alpha, p)) / thrust_slope(alpha, p)
    N1, N2 = generalised_forces(alpha, elevator, p)
    eta1 = N1 / (p.omega_1 * p.omega_1)
    eta2 = N2 / (p.omega_2 * p.omega_2)

    x = [V, h, 0.0, alpha, 0.0, eta1, 0.0, eta2, 0.0]
    residual = 0.0
    for rate in derivative(m, x, fuel_ratio, elevator, NOMINAL, p):
        residual = m.fmax(residual, m.fabs(rate))
    return SimpleNamespace(theta=alpha, elevator=elevator, fuel_ratio=fuel_ratio,
                           eta1=eta1, eta2=eta2, residual=residual)
