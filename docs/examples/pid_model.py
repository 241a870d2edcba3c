"""A PID controller with anti-windup: a discrete law, which runs every `sample_time`."""
NAME = "Pid"
DESCRIPTION = "PID controller, sampled, whose integral gives way while its output is at the limit"
VARIABLES = [
    ("wanted", "input", "m", 0.3, None, None, 0.1, "wanted position"),
    ("position", "input", "m", 0.0, None, None, 0.1, "measured position"),
    ("opening", "output", "1", None, -1.0, 1.0, 1.0, "opening of the valve"),
    ("limited", "output", "1 discrete", None, 0.0, 1.0, 1.0, "1 while the limit acts, else 0"),
    ("kp", "parameter", "1/m", 6.0, 0.0, None, None, "proportional gain"),
    ("ki", "parameter", "1/m/s", 12.0, 0.0, None, None, "integral gain"),
    ("kd", "parameter", "s/m", 0.8, 0.0, None, None, "derivative gain"),
    ("give_way", "parameter", "1/s", 10.0, 0.0, None, None, "rate at which the integral gives way at the limit"),
    ("sample_time", "parameter", "s", 0.02, 1e-4, 1.0, None, "time between two samples"),
]
PRESETS = {"gentle": {"kp": 3.0, "ki": 6.0}}


def start(m, u, p):
    return [0.0, u.wanted - u.position, 0.0]  # the integral, the last error, the opening before its limit


def advance(m, t, h, x, u, p, c):
    integral, error = x[0], u.wanted - u.position
    asked = p.kp * error + integral + p.kd * (error - x[1]) / h
    return [integral + h * (p.ki * error - p.give_way * (asked - m.clip(asked, -1.0, 1.0))), error, asked]


def outputs(m, t, x, u, p):
    return {"opening": m.clip(x[2], -1.0, 1.0), "limited": m.where(m.fabs(x[2]) > 1.0, 1.0, 0.0)}
