"""Every function of the mathematics, each an output: for the test that both flavours have them."""
NAME = "Mathematics"
DESCRIPTION = "What a model may call, of two numbers"
ONE = ("acos", "asin", "atan", "ceil", "cos", "cosh", "exp", "fabs", "floor", "log", "sin", "sinh", "sqrt", "tan",
       "tanh")
TWO = ("atan2", "fmax", "fmin")
OTHERS = ("clip", "where", "both", "either", "interpolate", "integrate", "power")
VARIABLES = [
    ("a", "input", "1", 0.3, None, None, 1.0, "first"),
    ("b", "input", "1", -1.7, None, None, 1.0, "second"),
    *((f"y_{name}", "output", "1", None, None, None, 1.0, name) for name in (*ONE, *TWO, *OTHERS)),
]
PRESETS = {}


def start(m, u, p):
    return []


def outputs(m, t, x, u, p):
    a, b = u.a, u.b
    values = {
        **{name: getattr(m, name)(a) for name in ONE}, **{name: getattr(m, name)(a, b) for name in TWO},
        "clip": m.clip(a, -0.1, 0.2), "where": m.where(a > b, a, b), "power": a**3 * (a + 1.0)**0.7,
        "both": m.where(m.both(a > 0.0, b > 0.0), 1.0, 0.0), "either": m.where(m.either(a > 0.0, b > 0.0), 1.0, 0.0),
        "interpolate": m.interpolate(b, [-2.0, -1.0, 0.5], [a, 2.0, b]),
        "integrate": m.integrate(lambda t, x: [b * x[0] + t], 0.5, [a], 0.1, 6)[0]}
    return {f"y_{name}": value for name, value in values.items()}
