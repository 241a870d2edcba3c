"""A model that tells when it was called: for the tests of what surrounds a model, in both flavours."""
NAME = "Clock"
DESCRIPTION = "Counts its internal steps and adds up their times"
VARIABLES = [
    ("growth", "input", "1", 1.0, None, None, 1.0, "factor on a hidden state in each internal step"),
    ("on", "input", "", False, None, None, None, "passed on"),
    ("now", "output", "s", None, -1e9, 1e9, 1.0, "time of the outputs"),
    ("steps", "output", "1", None, None, None, 1.0, "internal steps taken"),
    ("times", "output", "s", None, None, None, 1.0, "sum of the times at which they began"),
    ("length", "output", "s", None, None, None, 1.0, "length of the last one"),
    ("is_on", "output", "", None, None, None, None, "on, directly"),
    ("hidden_start", "parameter", "1", 1.0, None, None, None, "hidden state at the start"),
    ("internal_step", "parameter", "s", 0.1, 1e-6, 1.0, None, "longest internal step"),
]
PRESETS = {"plain": {"internal_step": 0.1}}


def start(m, u, p):
    return [0.0, 0.0, 0.0, p.hidden_start]


def prepare(m, p, h):
    return [h]


def advance(m, t, h, x, u, p, c):
    steps, times, _, hidden = x
    return [steps + 1.0, times + t, c[0], hidden * u.growth]


def outputs(m, t, x, u, p):
    return {"now": t, "steps": x[0], "times": x[1], "length": x[2], "is_on": u.on}
