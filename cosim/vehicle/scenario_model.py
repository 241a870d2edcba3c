"""Commands and coefficient scales over time, as a component without inputs or state.

Every signal is base + staircase + square + gated sinusoid; its numbers are parameters, and a case of
the paper is a set of them.
"""
from math import pi
from operator import attrgetter

NAME = "AhvScenario"
AUTHOR = "the AHV FMU authors"
DESCRIPTION = "Commands and coefficient scales of a flight: the paper's Case 1, Case 2, hold, or one's own"

EARLY = 1e-9  # s: an edge is not missed by a rounding of the clock

SIGNALS = [
    ("V_command", "ft/s", 7700.0, 1000.0, "commanded velocity"),
    ("h_command", "ft", 85000.0, 1000.0, "commanded altitude"),
    ("scale_thrust", "1", 1.0, 1.0, "factor on the thrust coefficients"),
    ("scale_lift", "1", 1.0, 1.0, "factor on the lift coefficients"),
    ("scale_drag", "1", 1.0, 1.0, "factor on the drag coefficients"),
    ("scale_moment", "1", 1.0, 1.0, "factor on the pitching moment coefficients"),
    ("scale_forces", "1", 1.0, 1.0, "factor on the generalised force coefficients"),
]
SCALES = [name for name, *_ in SIGNALS if name.startswith("scale")]
FOREVER = 1e6


def shape(base, unit):
    """Parameters of one signal: suffix, unit, start, min, max, description."""
    return [
        ("base", unit, base, None, None, "value before anything else"),
        ("step", unit, 0.0, None, None, "height of each stair"),
        ("step_time", "s", 0.0, 0.0, None, "time of the first stair"),
        ("step_period", "s", FOREVER, 1e-3, None, "time between stairs"),
        ("step_count", "1", 1.0, 0.0, 1000.0, "number of stairs"),
        ("square", unit, 0.0, None, None, "height of the square wave, high first"),
        ("square_period", "s", 200.0, 1e-3, None, "period of the square wave"),
        ("sine", unit, 0.0, None, None, "amplitude of the sinusoid"),
        ("sine_omega", "rad/s frequency", 1.0, 0.0, 1000.0, "angular frequency of the sinusoid"),
        ("sine_phase", "rad", 0.0, -2 * pi, 2 * pi, "phase of the sinusoid at t = 0"),
        ("sine_gate_start", "s", 0.0, 0.0, None, "the sinusoid acts from this time on"),
        ("sine_gate_period", "s", FOREVER, 1e-3, None, "and again after each such period"),
        ("sine_gate_length", "s", FOREVER, 0.0, None, "each time for so long"),
    ]


HOLD = {f"{name}_{key}": value for name, unit, base, *_ in SIGNALS for key, _, value, *_ in shape(base, unit)}
CASE_1 = {
    **HOLD,
    "V_command_step": 200.0, "h_command_step": 800.0,
    **{f"{scale}_{key}": value for scale in SCALES
       for key, value in (("sine", 0.4), ("sine_omega", 0.05 * pi))},                   # (68)
}
CASE_2 = {
    **HOLD,
    "V_command_step": 333.33, "V_command_step_period": 100.0, "V_command_step_count": 3.0,
    "h_command_square": 800.0, "h_command_square_period": 200.0,
    **{f"{scale}_{key}": value for scale in SCALES
       for key, value in (("sine", 0.4), ("sine_omega", 0.1 * pi), ("sine_gate_start", 50.0),
                          ("sine_gate_period", 100.0), ("sine_gate_length", 50.0))},    # (69)
}
PRESETS = {"case1": CASE_1, "case2": CASE_2, "hold": HOLD}

# name, causality, unit, start, min, max, nominal, description.
VARIABLES = [
    *((name, "output", unit, None, None, None, nominal, text) for name, unit, _, nominal, text in SIGNALS),
    *((f"{name}_{key}", "parameter", key_unit, CASE_1[f"{name}_{key}"], low, high, None, f"{name}: {text}")
      for name, unit, base, _, _ in SIGNALS for key, key_unit, _, low, high, text in shape(base, unit)),
]

# What belongs together on a connection: the terminals of FMI 3.0.
TERMINALS = {"commands": ("V_command", "h_command"), "coefficients": tuple(SCALES)}


def start(m, u, p):
    """There is no state."""
    return []


def advance(m, t, h, x, u, p, c):
    """Nothing changes but time."""
    return x


PARAMETERS_OF = {name: attrgetter(*(f"{name}_{key}" for key, *_ in shape(base, unit)))
                 for name, unit, base, *_ in SIGNALS}


def signal(m, t, parameters):
    """One signal at time t from its parameters in the order of `shape`."""
    (base, step, step_time, step_period, step_count, square, square_period,
     sine, omega, phase, gate_start, gate_period, gate_length) = parameters
    clock = t + EARLY
    stairs = m.clip(m.floor((clock - step_time) / step_period) + 1, 0.0, step_count)
    periods = clock / square_period
    high = periods - m.floor(periods) < 0.5
    since = clock - gate_start
    within = since - gate_period * m.floor(since / gate_period)
    open_gate = m.both(since >= 0.0, within < gate_length)
    return (base + step * stairs + m.where(high, square, 0.0)
            + m.where(open_gate, sine * m.sin(omega * t + phase), 0.0))


def outputs(m, t, x, u, p):
    """Every signal at time t (s), by name."""
    return {name: signal(m, t, parameters(p)) for name, parameters in PARAMETERS_OF.items()}
