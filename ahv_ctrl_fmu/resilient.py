"""A law that keeps the vehicle when its coefficient groups err each on its own, as pure functions.

Three observers find how far lift, pitching moment and drag are from the nominal vehicle's; the nominal model, scaled by
what they find, is inverted; and no more angle of attack is asked for than the elevator that is left can hold. The law
is discrete: one evaluation a communication step, from the measurements at the step's start. What it sends is kept in
the state.

With T = Ts Phi + To, c(alpha) = CMa2 alpha^2 + CMa alpha, e = -ce, mu = q S c/Iyy, kappa = c'(alpha)/e, and the
elevator delta as the servo's model has it now.
"""
from collections import namedtuple
from types import SimpleNamespace

from ahv_plant_fmu.equations import drag, dynamic_pressure, lift, thrust_offset, thrust_slope

from .differentiator import filter_rate, filter_step, filter_transition
from .ports import NOMINAL_VEHICLE, gamma_command, start_trim
from .sections import COEFFICIENTS, at_rest, cascade, section

LIFT_SCALE = 0.3, 2.0  # range of the lift scale found
MOMENT_SCALE = 0.6, 1.4  # range of the moment scale found: what is promised, 40 %
RELEASED = 0.43  # 0.6/1.4: least part of the nominal moment that releasing thrust gives, against the moment scale
LEAST_LIFT = 0.3  # of the weight: below it lift says little about its scale
LEAD_RATE = 1.0  # 1/s, of the low-pass in the lift's prediction
FASTEST_SCALE = 0.13  # 1/s: 0.4 of amplitude at 0.1 pi rad/s
LEAST_ALPHA = -0.05  # rad
SECTIONS = ("a", "b", "c")

v, e = NOMINAL_VEHICLE, -NOMINAL_VEHICLE.CM_elevator
REST = v.thrust_arm / v.pitch_inertia  # pitch acceleration per thrust

State = namedtuple("State", (
    "V_ref h_ref filter "                   # lists: reference filters (67), moment demand's filter
    "V d_V gamma s_L Q d_Q h gamma_slow "   # observers and what else is predicted for the next sample
    "m_first m_bar m_slow d_slow s_M d_M "  # moment: m0 as the observer sees it, slow parts, scale, disturbance used
    "s_bar s_slow n_bar T_bar "             # slow filters: lift scale used and its low-pass, bias, thrust
    "fuel_ratio elevator servo "            # sent, and the servo's model
    "hold alpha_wanted alpha_limit"))       # for the record: no evaluation reads them
Numbers = namedtuple("Numbers", "reference filter V gamma Q h gamma_slow m0 lift moment washout hold lead servo")
FILTER = 2 * (len(SECTIONS) + 1)


def unpack(x):
    """The state's numbers (a list) as a `State`."""
    return State(x[0:2], x[2:4], x[4:4 + FILTER], *x[4 + FILTER:])


def pack(s):
    """A `State` as a list of numbers."""
    return [*s.V_ref, *s.h_ref, *s.filter, *s[3:]]


# --- numbers that depend on gains and step only ---------------------------------------------------------------------

def low_pass(m, rate, h):
    """Gain of an exact first-order low-pass, state += gain (input - state); rate 0 is none: gain 1."""
    return 1 - m.where(rate > 0, m.exp(-rate * h), 0.0)


def observer(m, rate, h):
    """Gains of an observer with the double pole b = exp(-rate h): on its state, on its disturbance."""
    b = m.exp(-rate * h)
    return [1 - b * b, (1 - b)**2 / h]


def section_gains(p, k):
    """Zero, its damping, pole, its damping of the moment demand's filter section `k`."""
    return [getattr(p, f"section_{k}_{name}") for name in ("zero", "zero_damping", "pole", "pole_damping")]


def prepare(m, p, h):
    """39 numbers for steps of h: reference filter (4), sections (20), observers (6), low-passes (9)."""
    numbers = Numbers(
        reference=filter_transition(p.reference_omega, p.reference_zeta, h),
        filter=[value for k in SECTIONS for value in section(m, section_gains(p, k), h)],
        V=observer(m, p.observer_V, h), gamma=observer(m, p.observer_gamma, h), Q=observer(m, p.observer_Q, h),
        h=low_pass(m, p.filter_h, h), gamma_slow=low_pass(m, p.filter_gamma, h), m0=low_pass(m, p.observer_Q, h),
        lift=low_pass(m, p.filter_lift, h), moment=low_pass(m, p.filter_moment, h),
        washout=low_pass(m, p.moment_washout, h),
        hold=low_pass(m, p.hold_rate, h), lead=low_pass(m, LEAD_RATE, h), servo=low_pass(m, p.servo_rate, h))
    return [*numbers.reference, *numbers.filter, *numbers.V, *numbers.gamma, *numbers.Q, *numbers[5:]]


def numbers_of(c):
    """The numbers that `prepare` gives (a list) as a `Numbers`."""
    end = 4 + COEFFICIENTS * len(SECTIONS)
    return Numbers(c[0:4], c[4:end], c[end:end + 2], c[end + 2:end + 4], c[end + 4:end + 6], *c[end + 6:])


# --- the law's parts, in their order --------------------------------------------------------------------------------

def measurements(m, s, u):
    """The nominal vehicle at what is measured, with the inputs last sent."""
    alpha = u.theta - u.gamma
    q = dynamic_pressure(m, u.V, u.h, v)
    now = SimpleNamespace(
        u=u, alpha=alpha, q=q, qS=q * v.reference_area, mu=q * v.reference_area * v.chord / v.pitch_inertia,
        c=(v.CM_alpha2 * alpha + v.CM_alpha) * alpha, kappa=(2 * v.CM_alpha2 * alpha + v.CM_alpha) / e,
        slope=thrust_slope(alpha, v), offset=thrust_offset(alpha, v),
        sin_alpha=m.sin(alpha), cos_alpha=m.cos(alpha), sin_gamma=m.sin(u.gamma), cos_gamma=m.cos(u.gamma))
    now.T = now.slope * s.fuel_ratio + now.offset
    now.m0 = now.mu * (now.c + v.CM_0 - e * s.servo)
    return now


def V_rate(now, T, elevator):
    """(1) of the nominal vehicle."""
    return (T * now.cos_alpha - drag(now.q, now.alpha, elevator, v)) / v.mass - v.gravity * now.sin_gamma


def gamma_rate(now, T, elevator, s_L):
    """(3) with the lift scaled."""
    return ((s_L * lift(now.q, now.alpha, elevator, v) + T * now.sin_alpha) / (v.mass * now.u.V)
            - v.gravity * now.cos_gamma / now.u.V)


def observers(m, s, now, k):
    """Correct what was predicted for this sample. The disturbance of gamma goes to the lift's scale."""
    e_V, e_gamma, e_Q = now.u.V - s.V, now.u.gamma - s.gamma, now.u.Q - s.Q
    L0, least = lift(now.q, now.alpha, s.servo, v), LEAST_LIFT * v.mass * v.gravity
    s_L = s.s_L + k.gamma[1] * e_gamma * v.mass * now.u.V * L0 / m.fmax(L0, least)**2
    return s._replace(
        V=s.V + k.V[0] * e_V, d_V=s.d_V + k.V[1] * e_V,
        gamma=s.gamma + k.gamma[0] * e_gamma, s_L=m.clip(s_L, *LIFT_SCALE),
        Q=s.Q + k.Q[0] * e_Q, d_Q=s.d_Q + k.Q[1] * e_Q,
        h=s.h + k.h * (now.u.h - s.h), gamma_slow=s.gamma_slow + k.gamma_slow * (now.u.gamma - s.gamma_slow))


def moment_scale(m, s, now, p, h, k):
    """The moment's scale, from what disturbance and model have in common; the disturbances take no bump from it."""
    m_first = s.m_first + k.m0 * (now.m0 - s.m_first)
    m_bar = s.m_bar + k.m0 * (m_first - s.m_bar)
    m_slow = s.m_slow + k.washout * (m_bar - s.m_slow)
    d_slow = s.d_slow + k.washout * (s.d_Q - s.d_slow)
    m_fast, d_fast = m_bar - m_slow, s.d_Q - d_slow
    s_M = m.clip(s.s_M + h * p.moment_gain * d_fast * m_fast / (p.moment_floor**2 + m_fast * m_fast), *MOMENT_SCALE)
    change = s_M - s.s_M
    d_Q, d_M = s.d_Q - change * m_bar, s.d_M - change * m_bar
    return s._replace(m_first=m_first, m_bar=m_bar, m_slow=m_slow, d_slow=d_slow - change * m_slow, s_M=s_M,
                      d_Q=d_Q, d_M=d_M + k.moment * (d_Q - d_M))


def slow_filters(s, now, k):
    """The lift's scale as used, the bias of the pitching moment, the thrust."""
    s_bar = s.s_bar + k.lift * (s.s_L - s.s_bar)
    return s._replace(s_bar=s_bar, s_slow=s.s_slow + k.lead * (s_bar - s.s_slow),
                      n_bar=s.n_bar + k.hold * (REST * now.T + s.d_M - s.n_bar),
                      T_bar=s.T_bar + k.hold * (now.T - s.T_bar))


def lift_scale(m, s, p):
    """The lift's scale a moment ahead, no faster than a scale moves."""
    trend = m.clip(LEAD_RATE * (s.s_bar - s.s_slow), -FASTEST_SCALE, FASTEST_SCALE)
    return m.clip(s.s_bar + p.lift_lead * trend, *LIFT_SCALE)


def altitude(m, s, now, p, s_L, hold):
    """The angle of attack that the altitude asks for. The elevator's steady lift is inverted, its transient is not:
    the zero at 3.5 1/s is respected."""
    h_ref, h_ref_rate = s.h_ref
    _, h_ref_rate2 = filter_rate(s.h_ref, now.u.h_command, p.reference_omega, p.reference_zeta)
    h_rate = now.u.V * m.sin(s.gamma_slow)
    wanted = h_ref_rate2 - (p.k_gamma + p.k_path) * (h_rate - h_ref_rate) - p.k_gamma * p.k_path * (s.h - h_ref)
    CL = ((v.mass * wanted / now.cos_gamma + v.mass * v.gravity * now.cos_gamma - now.T * now.sin_alpha)
          / (s_L * now.qS))
    return (CL - v.CL_0 - v.CL_elevator * (hold - now.kappa * now.alpha)) / (v.CL_alpha + v.CL_elevator * now.kappa)


def holdable_alpha(m, s, now, p, hold, margin):
    """The largest angle of attack that the elevator can hold with `margin` of it left and the thrust released."""
    least = m.fmax(now.slope * p.fuel_ratio_min + now.offset, 0.0)
    released = RELEASED * REST * m.fmax(s.T_bar - least, 0.0) / (s.s_M * now.mu)
    c = now.c + e * (p.elevator_max - margin - hold) + released
    B = v.CM_alpha
    return (-B + m.sqrt(m.fmax(B * B + 4 * v.CM_alpha2 * c, 0.0))) / (2 * v.CM_alpha2)


def commanded(m, s, u, now, p):
    """What the corrected state asks for: elevator that holds, angle of attack, moment demand, fuel ratio for speed."""
    s_L = lift_scale(m, s, p)
    per_elevator = s.s_M * e * now.mu
    aerodynamic = s.s_M * now.mu * (now.c + v.CM_0)
    hold = (aerodynamic + s.n_bar) / per_elevator
    wanted, limit = altitude(m, s, now, p, s_L, hold), holdable_alpha(m, s, now, p, hold, p.alpha_margin)
    alpha = m.fmax(m.fmin(wanted, limit), LEAST_ALPHA)
    stop = holdable_alpha(m, s, now, p, hold, p.barrier_margin)
    Q_wanted = (gamma_rate(now, now.T, hold, s_L)
                + m.fmin(p.k_alpha * (alpha - now.alpha), p.k_barrier * (stop - now.alpha)))
    pitch = p.k_Q * (Q_wanted - m.where(p.measured_rates, u.Q, s.Q))
    V_error = m.where(p.measured_rates, u.V, s.V) - s.V_ref[0]
    V_wanted = s.V_ref[1] - m.clip(p.k_V * V_error, -p.V_recovery, p.V_recovery)
    fuel_ratio = ((V_wanted - s.d_V - V_rate(now, now.offset, hold)) * v.mass / (now.slope * now.cos_alpha))
    return SimpleNamespace(hold=hold, per_elevator=per_elevator, wanted=wanted, limit=limit,
                           demand=pitch - aerodynamic - s.d_M,
                           fuel_ratio=m.clip(fuel_ratio, p.fuel_ratio_min, p.fuel_ratio_max))


def shared(m, now, p, law, demand):
    """Fuel ratio and elevator that give the pitch acceleration `demand` beside the aerodynamic one: what the elevator
    does not give within its band about `hold` is left to the thrust."""
    def elevator(fuel_ratio):
        return (REST * (now.slope * fuel_ratio + now.offset) - demand) / law.per_elevator

    wanted = elevator(law.fuel_ratio)
    band = m.clip(wanted, m.fmax(law.hold - p.elevator_band, p.elevator_min),
                  m.fmin(law.hold + p.elevator_band, p.elevator_max))
    fuel_ratio = m.clip(law.fuel_ratio - (wanted - band) * law.per_elevator / (REST * now.slope),
                        p.fuel_ratio_min, p.fuel_ratio_max)
    return fuel_ratio, m.clip(elevator(fuel_ratio), p.elevator_min, p.elevator_max)


def predicted(m, s, now, p, h, k):
    """The next sample by one Euler step from this one's measurements, with what was just sent; then the references."""
    u, T = now.u, now.slope * s.fuel_ratio + now.offset
    gamma_change = h * gamma_rate(now, T, s.servo, s.s_L)
    Q_change = h * (REST * T + s.s_M * now.mu * (now.c + v.CM_0 - e * s.servo) + s.d_Q)
    return s._replace(
        V=s.V + h * (V_rate(now, T, s.servo) + s.d_V), gamma=s.gamma + gamma_change, Q=s.Q + Q_change,
        h=s.h + h * u.V * m.sin(s.gamma_slow), gamma_slow=s.gamma_slow + gamma_change,
        V_ref=filter_step(k.reference, s.V_ref, u.V_command, u.V_command, h, p.reference_omega, p.reference_zeta),
        h_ref=filter_step(k.reference, s.h_ref, u.h_command, u.h_command, h, p.reference_omega, p.reference_zeta))


# --- the component's functions --------------------------------------------------------------------------------------

def start(m, u, p):
    """At rest where the vehicle is, the nominal one in trim; every filter at its own input."""
    fuel_ratio, elevator = start_trim(m, u, p, ("fuel_ratio", "elevator"))
    s = State(
        V_ref=[u.V, 0.0], h_ref=[u.h, 0.0], filter=[0.0] * FILTER,
        V=u.V, d_V=0.0, gamma=u.gamma, s_L=1.0, Q=u.Q, d_Q=0.0, h=u.h, gamma_slow=u.gamma,
        m_first=0.0, m_bar=0.0, m_slow=0.0, d_slow=0.0, s_M=1.0, d_M=0.0,
        s_bar=1.0, s_slow=1.0, n_bar=0.0, T_bar=0.0,
        fuel_ratio=fuel_ratio, elevator=elevator, servo=elevator, hold=elevator, alpha_wanted=0.0, alpha_limit=0.0)
    now = measurements(m, s, u)
    s = s._replace(m_first=now.m0, m_bar=now.m0, m_slow=now.m0, n_bar=REST * now.T, T_bar=now.T)
    law = commanded(m, s, u, now, p)
    return pack(s._replace(filter=at_rest(law.demand, len(SECTIONS)),
                           hold=law.hold, alpha_wanted=law.wanted, alpha_limit=law.limit))


def advance(m, t, h, x, u, p, c):
    """One evaluation: the inputs to send for the next h seconds, and the state to begin the evaluation after it."""
    s, k = unpack(x), numbers_of(c)
    now = measurements(m, s, u)
    s = slow_filters(moment_scale(m, observers(m, s, now, k), now, p, h, k), now, k)
    law = commanded(m, s, u, now, p)
    demand, states = cascade(k.filter, s.filter, law.demand)
    fuel_ratio, elevator = shared(m, now, p, law, demand)
    servo = s.servo + m.clip(k.servo * (elevator - s.servo), -p.servo_speed * h, p.servo_speed * h)
    s = s._replace(filter=states, fuel_ratio=fuel_ratio, elevator=elevator, servo=servo,
                   hold=law.hold, alpha_wanted=law.wanted, alpha_limit=law.limit)
    return pack(predicted(m, s, now, p, h, k))


def outputs(m, t, x, u, p):
    """Every output of the table, in its units."""
    s = unpack(x)
    return {
        "fuel_ratio": s.fuel_ratio,
        "elevator": s.elevator,
        "V_reference": s.V_ref[0],
        "h_reference": s.h_ref[0],
        "V_error": u.V - s.V_ref[0],
        "h_error": u.h - s.h_ref[0],
        "gamma_command": gamma_command(m, u.h, u.V, s.h_ref, p),
        "fuel_ratio_saturated": m.either(s.fuel_ratio <= p.fuel_ratio_min, s.fuel_ratio >= p.fuel_ratio_max),
        "elevator_saturated": m.either(s.elevator <= p.elevator_min, s.elevator >= p.elevator_max),
        "scale_lift": lift_scale(m, s, p),
        "scale_moment": s.s_M,
        "elevator_hold": s.hold,
        "alpha_command": m.fmax(m.fmin(s.alpha_wanted, s.alpha_limit), LEAST_ALPHA),
        "alpha_limit": s.alpha_limit,
        "protecting": s.alpha_wanted > s.alpha_limit,
        "disturbance_V": s.d_V,
        "disturbance_Q": s.d_Q,
    }
