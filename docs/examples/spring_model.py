"""A mass on a spring: the model gives its derivative, the builder integrates it."""
NAME = "Spring"
DESCRIPTION = "A mass on a spring with a damper"
VARIABLES = [  # name, causality, unit, start, min, max, nominal, description
    ("force", "input", "N", 0.0, None, None, 10.0, "force on the mass"),
    ("position", "output", "m", None, -0.5, 0.5, 0.1, "position, 0 where the spring is at rest"),
    ("speed", "output", "m/s", None, None, None, 0.1, "speed of the mass"),
    ("mass", "parameter", "kg", 2.0, 0.1, 100.0, None, "mass"),
    ("stiffness", "parameter", "N/m", 50.0, 0.0, None, None, "stiffness of the spring"),
    ("damping", "parameter", "N.s/m", 4.0, 0.0, None, None, "force of the damper at 1 m/s"),
    ("position_start", "parameter", "m", 0.0, -0.5, 0.5, None, "position at the start"),
    ("internal_step", "parameter", "s", 0.01, 1e-6, 0.1, None, "longest step of the integration"),
]
PRESETS = {"stiff": {"stiffness": 200.0}}
STATES = ["position", "speed"]


def start(m, u, p):
    return [p.position_start, 0.0]


def derivative(m, t, x, u, p):
    return [x[1], (u.force - p.stiffness * x[0] - p.damping * x[1]) / p.mass]


def outputs(m, t, x, u, p):
    return {"position": x[0], "speed": x[1]}
