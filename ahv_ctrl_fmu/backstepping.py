"""A backstepping law with tracking differentiators and disturbance observers: a reconstruction.

The paper compares with "a traditional backstepping control strategy" whose equations could not be had; this
is the textbook form of its description. It knows the nominal vehicle as an affine model,

    V'     = f_V + b_V Phi   + d_V
    gamma' = f_g + b_g theta + d_g        (elevator lift neglected)
    theta' = Q
    Q'     = f_Q + b_Q delta_e + d_Q

inverts it step by step, takes the derivative of each virtual control from a tracking differentiator, and
estimates each lumped disturbance d with an observer.
"""
from collections import namedtuple
from types import SimpleNamespace

from ahv_plant_fmu.equations import (
    aerodynamic_moment,
    drag,
    dynamic_pressure,
    lift,
    thrust,
    thrust_offset,
    thrust_slope,
)

from .differentiator import filter_rate, filter_step, filter_transition
from .ports import NOMINAL_VEHICLE, gamma_command, limited, start_trim

State = namedtuple("State", "V_ref h_ref V_integral d_V d_gamma d_Q gamma_td theta_td Q_td elevator_trim")
CRITICAL = 1.0  # damping ratio of the tracking differentiators


def unpack(x):
    """The state's numbers (a list) as a `State`."""
    return State(x[0:2], x[2:4], x[4], x[5], x[6], x[7], x[8:10], x[10:12], x[12:14], x[14])


def pack(s):
    """A `State` as a list of numbers."""
    return [*s.V_ref, *s.h_ref, s.V_integral, s.d_V, s.d_gamma, s.d_Q,
            *s.gamma_td, *s.theta_td, *s.Q_td, s.elevator_trim]


def velocity_model(m, u, elevator):
    """f_V and b_V of the nominal vehicle."""
    v, alpha = NOMINAL_VEHICLE, u.theta - u.gamma
    D = drag(dynamic_pressure(m, u.V, u.h, v), alpha, elevator, v)
    return ((thrust_offset(alpha, v) * m.cos(alpha) - D) / v.mass - v.gravity * m.sin(u.gamma),
            thrust_slope(alpha, v) * m.cos(alpha) / v.mass)


def attitude_model(m, u, fuel_ratio):
    """f_g, b_g, f_Q, b_Q of the nominal vehicle; the elevator's lift is neglected."""
    v, alpha = NOMINAL_VEHICLE, u.theta - u.gamma
    q = dynamic_pressure(m, u.V, u.h, v)
    T = thrust(alpha, fuel_ratio, v)
    b_g = q * v.reference_area * v.CL_alpha / (v.mass * u.V)
    rate = (lift(q, alpha, 0.0, v) + T * m.sin(alpha)) / (v.mass * u.V) - v.gravity * m.cos(u.gamma) / u.V
    f_Q = (v.thrust_arm * T + aerodynamic_moment(q, alpha, 0.0, v)) / v.pitch_inertia
    b_Q = q * v.reference_area * v.chord * v.CM_elevator / v.pitch_inertia
    return rate - b_g * u.theta, b_g, f_Q, b_Q


def disturbance(z, gain, measured):
    """The estimate of a disturbance observer with internal state z."""
    return z + gain * measured


def law(m, s, u, p):
    """All steps of the recursion: a namespace with the inputs, the virtual controls and the model's rates.

    Drag needs the elevator and the moment the thrust: the elevator is found with the fuel ratio that the
    trim's elevator would need, then the fuel ratio with that elevator. What this misses is a disturbance.
    """
    error = u.V - s.V_ref[0]
    V_rate = (-p.kV1 * error - p.kV2 * s.V_integral + s.V_ref[1] - disturbance(s.d_V, p.observer_V, u.V))

    def inversion(elevator):
        f_V, b_V = velocity_model(m, u, elevator)
        sent, saturated = limited(m, (V_rate - f_V) / b_V, p.fuel_ratio_min, p.fuel_ratio_max)
        return sent, saturated, f_V + b_V * sent

    about, _, _ = inversion(s.elevator_trim)
    f_g, b_g, f_Q, b_Q = attitude_model(m, u, about)
    gamma_d = gamma_command(m, u.h, u.V, s.h_ref, p)                                    # (36)
    theta_d = (-p.k_path * (u.gamma - gamma_d) + s.gamma_td[1] - f_g
               - disturbance(s.d_gamma, p.observer_gamma, u.gamma)) / b_g
    Q_d = -p.k_theta * (u.theta - theta_d) + s.theta_td[1]
    elevator, elevator_saturated = limited(
        m, (-p.k_Q * (u.Q - Q_d) + s.Q_td[1] - f_Q - disturbance(s.d_Q, p.observer_Q, u.Q)) / b_Q,
        p.elevator_min, p.elevator_max)
    fuel_ratio, fuel_saturated, V_drift = inversion(elevator)
    return SimpleNamespace(error=error, fuel_ratio=fuel_ratio, fuel_saturated=fuel_saturated,
                           gamma_d=gamma_d, theta_d=theta_d, Q_d=Q_d,
                           elevator=elevator, elevator_saturated=elevator_saturated,
                           V_drift=V_drift, gamma_drift=f_g + b_g * u.theta, Q_drift=f_Q + b_Q * elevator)


def start(m, u, p):
    """At rest where the vehicle is; integral and observers such that the first outputs are the trim."""
    fuel_ratio, elevator, theta = start_trim(m, u, p)
    f_V, b_V = velocity_model(m, u, elevator)
    f_g, b_g, f_Q, b_Q = attitude_model(m, u, fuel_ratio)
    gamma_d = gamma_command(m, u.h, u.V, [u.h, 0.0], p)
    d_gamma = -(f_g + b_g * theta)  # so that the first theta_d is the trim's theta
    theta_d = (-p.k_path * (u.gamma - gamma_d) - f_g - d_gamma) / b_g
    Q_d = -p.k_theta * (u.theta - theta_d)
    d_Q = -p.k_Q * (u.Q - Q_d) - f_Q - b_Q * elevator
    return pack(State(
        V_ref=[u.V, 0.0], h_ref=[u.h, 0.0], V_integral=0.0,
        d_V=-(f_V + b_V * fuel_ratio) - p.observer_V * u.V,
        d_gamma=d_gamma - p.observer_gamma * u.gamma, d_Q=d_Q - p.observer_Q * u.Q,
        gamma_td=[gamma_d, 0.0], theta_td=[theta_d, 0.0], Q_td=[Q_d, 0.0], elevator_trim=elevator))


def derivative(m, t, x, u, p):
    """dx/dt of the law in continuous time, which `advance` steps: of all states but the last, a memory."""
    s = unpack(x)
    now = law(m, s, u, p)

    def observer(z, gain, measured, drift):  # d^ = z + gain x follows x' - drift
        return -gain * (disturbance(z, gain, measured) + drift)

    return pack(State(
        V_ref=filter_rate(s.V_ref, u.V_command, p.reference_omega, p.reference_zeta),
        h_ref=filter_rate(s.h_ref, u.h_command, p.reference_omega, p.reference_zeta),
        V_integral=m.where(now.fuel_saturated, 0.0, now.error),
        d_V=observer(s.d_V, p.observer_V, u.V, now.V_drift),
        d_gamma=observer(s.d_gamma, p.observer_gamma, u.gamma, now.gamma_drift),
        d_Q=observer(s.d_Q, p.observer_Q, u.Q, now.Q_drift),
        gamma_td=filter_rate(s.gamma_td, now.gamma_d, p.R_gamma, CRITICAL),
        theta_td=filter_rate(s.theta_td, now.theta_d, p.R_theta, CRITICAL),
        Q_td=filter_rate(s.Q_td, now.Q_d, p.R_Q, CRITICAL),
        elevator_trim=0.0))[:-1]


def prepare(m, p, h):
    """19 transition entries for steps of h: reference filter (4), three differentiators (4 each), three observers."""
    return [*filter_transition(p.reference_omega, p.reference_zeta, h),
            *(entry for R in (p.R_gamma, p.R_theta, p.R_Q) for entry in filter_transition(R, CRITICAL, h)),
            *(m.exp(-gain * h) for gain in (p.observer_V, p.observer_gamma, p.observer_Q))]


def advance(m, t, h, x, u, p, c):
    """One step of h seconds with the inputs held: exact in the linear parts for what they are fed, which is
    taken at the step's start for the observers and as straight lines for the differentiators."""
    s = unpack(x)
    now = law(m, s, u, p)
    V_ref = filter_step(c[0:4], s.V_ref, u.V_command, u.V_command, h, p.reference_omega, p.reference_zeta)
    h_ref = filter_step(c[0:4], s.h_ref, u.h_command, u.h_command, h, p.reference_omega, p.reference_zeta)

    def observer(decay, z, gain, measured, drift):
        rest = -(gain * measured + drift)
        return rest + decay * (z - rest)

    new = s._replace(
        V_ref=V_ref, h_ref=h_ref,
        V_integral=s.V_integral + m.where(now.fuel_saturated, 0.0, h / 2 * (now.error + u.V - V_ref[0])),
        d_V=observer(c[16], s.d_V, p.observer_V, u.V, now.V_drift),
        d_gamma=observer(c[17], s.d_gamma, p.observer_gamma, u.gamma, now.gamma_drift),
        d_Q=observer(c[18], s.d_Q, p.observer_Q, u.Q, now.Q_drift))
    later = law(m, new, u, p)
    return pack(new._replace(
        gamma_td=filter_step(c[4:8], s.gamma_td, now.gamma_d, later.gamma_d, h, p.R_gamma, CRITICAL),
        theta_td=filter_step(c[8:12], s.theta_td, now.theta_d, later.theta_d, h, p.R_theta, CRITICAL),
        Q_td=filter_step(c[12:16], s.Q_td, now.Q_d, later.Q_d, h, p.R_Q, CRITICAL)))


def outputs(m, t, x, u, p):
    """Every output of the table, in its units."""
    s = unpack(x)
    now = law(m, s, u, p)
    return {
        "fuel_ratio": now.fuel_ratio,
        "elevator": now.elevator,
        "V_reference": s.V_ref[0],
        "h_reference": s.h_ref[0],
        "V_error": now.error,
        "h_error": u.h - s.h_ref[0],
        "gamma_command": now.gamma_d,
        "fuel_ratio_saturated": now.fuel_saturated,
        "elevator_saturated": now.elevator_saturated,
        "theta_command": now.theta_d,
        "Q_command": now.Q_d,
        "disturbance_V": disturbance(s.d_V, p.observer_V, u.V),
        "disturbance_gamma": disturbance(s.d_gamma, p.observer_gamma, u.gamma),
        "disturbance_Q": disturbance(s.d_Q, p.observer_Q, u.Q),
    }
