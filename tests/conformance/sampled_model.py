"""A discrete law that tells when it ran: for the tests of `sample_time`, in both flavours."""
NAME = "Sampler"
DESCRIPTION = "Shows what it saw at its last instant"
VARIABLES = [
    ("signal", "input", "m", 2.0, None, None, 1.0, "what is sampled"),
    ("seen", "output", "m", None, None, None, 1.0, "the signal at the last instant"),
    ("runs", "output", "1", None, None, None, 1.0, "how often the law ran"),
    ("at", "output", "s", None, None, None, 1.0, "its last instant"),
    ("length", "output", "s", None, None, None, 1.0, "the step it was prepared for"),
    ("is_far", "output", "", None, None, None, None, "the signal was above 1 m"),
    ("sample_time", "parameter", "s", 0.1, 1e-6, None, None, "time between two instants"),
]
PRESETS = {}


def start(m, u, p):
    return [0.0, 0.0]


def prepare(m, p, h):
    return [h]


def advance(m, t, h, x, u, p, c):
    return [x[0] + 1.0, c[0]]


def outputs(m, t, x, u, p):
    return {"seen": u.signal, "runs": x[0], "at": t, "length": x[1], "is_far": u.signal > 1.0}
