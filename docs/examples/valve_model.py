"""A pneumatic valve by a lookup table: little happens near the middle, and less and less towards the ends."""
NAME = "Valve"
DESCRIPTION = "Force of a pneumatic cylinder over the opening of its valve, measured at a supply of 6 bar"
VARIABLES = [
    ("opening", "input", "1", 0.0, None, None, 1.0, "opening of the valve, from -1 to 1"),
    ("force", "output", "N", None, None, None, 10.0, "force of the cylinder"),
    ("supply", "parameter", "bar", 6.0, 0.0, 10.0, None, "supply pressure"),
]
PRESETS = {"weak": {"supply": 4.0}}
OPENINGS = [-1.0, -0.6, -0.3, -0.05, 0.05, 0.3, 0.6, 1.0]
FORCES = [-25.0, -22.0, -14.0, 0.0, 0.0, 14.0, 22.0, 25.0]  # N, the last one also beyond the ends


def start(m, u, p):
    return []


def outputs(m, t, x, u, p):
    return {"force": p.supply / 6.0 * m.interpolate(u.opening, OPENINGS, FORCES)}
