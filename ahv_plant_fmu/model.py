"""The plant as a component: its table of variables, its start, its derivative, its outputs.

A model's functions are pure; `m` is the mathematics backend, `u` and `p` have the inputs and the
parameters of the table as attributes. See `fmus.interface` for the contract.
"""
from math import pi
from types import SimpleNamespace

from .equations import derivative as vehicle_rate
from .equations import forces
from .trim import level_trim
from .vehicle import COEFFICIENTS, STRUCTURES

NAME = "AhvPlant"
AUTHOR = "the AHV FMU authors"
DESCRIPTION = "Longitudinal dynamics of a flexible air-breathing hypersonic vehicle, equations (1)-(9)"

DEG = pi / 180

# name, causality, unit, start, min, max, nominal, description.
# The range of an output is where the model is valid: outside it the step is refused.
VARIABLES = [
    ("fuel_ratio", "input", "1", 0.26703, None, None, 1.0, "fuel equivalence ratio Phi"),
    ("elevator", "input", "rad", 12.511 * DEG, None, None, 0.1, "elevator deflection"),
    ("scale_thrust", "input", "1", 1.0, None, None, 1.0, "factor on the thrust coefficients"),
    ("scale_lift", "input", "1", 1.0, None, None, 1.0, "factor on the lift coefficients"),
    ("scale_drag", "input", "1", 1.0, None, None, 1.0, "factor on the drag coefficients"),
    ("scale_moment", "input", "1", 1.0, None, None, 1.0, "factor on the pitching moment coefficients"),
    ("scale_forces", "input", "1", 1.0, None, None, 1.0, "factor on the generalised forces"),

    ("V", "output", "ft/s", None, 3000.0, 20000.0, 1000.0, "velocity"),
    ("h", "output", "ft", None, 20000.0, 250000.0, 1000.0, "altitude"),
    ("gamma", "output", "rad", None, -pi / 2, pi / 2, 0.01, "flight-path angle"),
    ("theta", "output", "rad", None, -pi / 2, pi / 2, 0.01, "pitch angle"),
    ("Q", "output", "rad/s", None, None, None, 0.01, "pitch rate"),
    ("eta1", "output", "1", None, None, None, 1.0, "elastic coordinate, in sqrt(slug ft), of mode 1"),
    ("eta1_dot", "output", "1/s", None, None, None, 20.0, "rate of eta1, in sqrt(slug ft)/s"),
    ("eta2", "output", "1", None, None, None, 1.0, "elastic coordinate, in sqrt(slug ft), of mode 2"),
    ("eta2_dot", "output", "1/s", None, None, None, 20.0, "rate of eta2, in sqrt(slug ft)/s"),
    ("alpha", "output", "rad", None, None, None, 0.01, "angle of attack, theta - gamma"),
    ("dynamic_pressure", "output", "lbf/ft^2", None, None, None, 1000.0, "dynamic pressure"),
    ("thrust", "output", "lbf/ft", None, None, None, 1000.0, "thrust per foot of depth"),
    ("lift", "output", "lbf/ft", None, None, None, 10000.0, "lift per foot of depth"),
    ("drag", "output", "lbf/ft", None, None, None, 1000.0, "drag per foot of depth"),
    ("pitching_moment", "output", "lbf", None, None, None, 10000.0, "pitching moment per foot of depth"),
    ("load_factor", "output", "1", None, None, None, 1.0, "(L + T sin alpha) / (m g)"),
    ("fuel_ratio_trim", "calculatedParameter", "1", None, None, None, 1.0, "fuel ratio of trim at V_start, h_start"),
    ("elevator_trim", "calculatedParameter", "rad", None, None, None, 0.1, "elevator of that trim"),
    ("theta_trim", "calculatedParameter", "rad", None, None, None, 0.01, "pitch angle of that trim"),
    ("trim_residual", "calculatedParameter", "1", None, None, None, 1.0, "largest state derivative left at trim"),

    ("V_start", "parameter", "ft/s", 7700.0, 5000.0, 15000.0, None, "initial velocity"),
    ("h_start", "parameter", "ft", 85000.0, 50000.0, 150000.0, None, "initial altitude"),
    ("start_at_trim", "parameter", "", True, None, None, None, "start in level trim at V_start, h_start"),
    ("gamma_start", "parameter", "rad", 0.0, -80 * DEG, 80 * DEG, None, "initial flight-path angle, if not at trim"),
    ("theta_start", "parameter", "rad", 0.0, -80 * DEG, 80 * DEG, None, "initial pitch angle, if not at trim"),
    ("Q_start", "parameter", "rad/s", 0.0, -10.0, 10.0, None, "initial pitch rate, if not at trim"),
    ("eta1_start", "parameter", "1", 0.0, -100.0, 100.0, None, "initial eta1, if not at trim"),
    ("eta1_dot_start", "parameter", "1/s", 0.0, -1000.0, 1000.0, None, "initial eta1_dot, if not at trim"),
    ("eta2_start", "parameter", "1", 0.0, -100.0, 100.0, None, "initial eta2, if not at trim"),
    ("eta2_dot_start", "parameter", "1/s", 0.0, -1000.0, 1000.0, None, "initial eta2_dot, if not at trim"),
    ("internal_step", "parameter", "s", 0.004, 1e-6, 0.02, None, "longest internal Runge-Kutta step"),
    *((name, "parameter", unit, value, *((1e-3 * value, 1e3 * value) if name in
       ("mass", "pitch_inertia", "reference_area", "chord", "gravity", "air_density_0", "h_scale", "omega_1", "omega_2")
       else (None, None)), None, text) for name, unit, value, text in COEFFICIENTS),
]

PRESETS = STRUCTURES

# What belongs together on a connection: the terminals of FMI 3.0.
TERMINALS = {
    "actuators": ("fuel_ratio", "elevator"),
    "measurements": ("V", "h", "gamma", "theta", "Q"),
    "coefficients": ("scale_thrust", "scale_lift", "scale_drag", "scale_moment", "scale_forces"),
}

STATES = ["V", "h", "gamma", "theta", "Q", "eta1", "eta1_dot", "eta2", "eta2_dot"]
ORDER = 6
MEMORY = ("fuel_ratio_trim", "elevator_trim", "theta_trim", "trim_residual")


def scales(u):
    """The factors on the coefficient groups, from the inputs."""
    return SimpleNamespace(thrust=u.scale_thrust, lift=u.scale_lift, drag=u.scale_drag,
                           moment=u.scale_moment, forces=u.scale_forces)


def start(m, u, p):
    """Initial state: nine states of (1)-(7), then the trim that was solved."""
    trim = level_trim(m, p.V_start, p.h_start, p)

    def chosen(at_trim, otherwise):
        return m.where(p.start_at_trim, at_trim, otherwise)

    return [p.V_start, p.h_start, chosen(0.0, p.gamma_start), chosen(trim.theta, p.theta_start),
            chosen(0.0, p.Q_start), chosen(trim.eta1, p.eta1_start), chosen(0.0, p.eta1_dot_start),
            chosen(trim.eta2, p.eta2_start), chosen(0.0, p.eta2_dot_start),
            trim.fuel_ratio, trim.elevator, trim.theta, trim.residual]


def derivative(m, t, x, u, p):
    """dx/dt of the nine states, per second."""
    return vehicle_rate(m, x[:9], u.fuel_ratio, u.elevator, scales(u), p)


def outputs(m, t, x, u, p):
    """Every output and calculated parameter of the table, in its units."""
    states, memory = x[:9], x[9:]
    alpha = x[3] - x[2]
    q, T, L, D, M, _, _ = forces(m, states, u.fuel_ratio, u.elevator, scales(u), p)
    return {
        **dict(zip(STATES, states)),
        "alpha": alpha,
        "dynamic_pressure": q,
        "thrust": T,
        "lift": L,
        "drag": D,
        "pitching_moment": M,
        "load_factor": (L + T * m.sin(alpha)) / (p.mass * p.gravity),
        **dict(zip(MEMORY, memory)),
    }
