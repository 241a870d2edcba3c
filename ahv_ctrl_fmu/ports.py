"""What every control law of the vehicle shares: inputs, outputs, limits, reference filters, start."""
from math import pi
from types import SimpleNamespace

from ahv_plant_fmu.trim import level_trim
from ahv_plant_fmu.vehicle import COEFFICIENTS

DEG = pi / 180
SMALL = 1e-6  # a gain that is divided by is at least this

NOMINAL_VEHICLE = SimpleNamespace(**{name: value for name, _, value, _ in COEFFICIENTS})

# name, causality, unit, start, min, max, nominal, description.
PORTS = [
    ("V", "input", "ft/s", 7700.0, 4000.0, 16000.0, 1000.0, "measured velocity"),
    ("h", "input", "ft", 85000.0, 40000.0, 160000.0, 1000.0, "measured altitude"),
    ("gamma", "input", "rad", 0.0, None, None, 0.01, "measured flight-path angle"),
    ("theta", "input", "rad", 1.6325 * DEG, None, None, 0.01, "measured pitch angle"),
    ("Q", "input", "rad/s", 0.0, None, None, 0.01, "measured pitch rate"),
    ("V_command", "input", "ft/s", 7700.0, None, None, 1000.0, "commanded velocity"),
    ("h_command", "input", "ft", 85000.0, None, None, 1000.0, "commanded altitude"),

    ("fuel_ratio", "output", "1", None, None, None, 1.0, "fuel equivalence ratio Phi, limited"),
    ("elevator", "output", "rad", None, None, None, 0.1, "elevator deflection, limited"),
    ("V_reference", "output", "ft/s", None, None, None, 1000.0, "filtered velocity command (67)"),
    ("h_reference", "output", "ft", None, None, None, 1000.0, "filtered altitude command (67)"),
    ("V_error", "output", "ft/s", None, None, None, 1.0, "velocity tracking error, measured minus reference"),
    ("h_error", "output", "ft", None, None, None, 1.0, "altitude tracking error, measured minus reference"),
    ("gamma_command", "output", "rad", None, None, None, 0.01, "flight-path angle command gamma_d (36)"),
    ("fuel_ratio_saturated", "output", "1 discrete", None, 0.0, 1.0, 1.0, "1 with the fuel ratio at a limit, else 0"),
    ("elevator_saturated", "output", "1 discrete", None, 0.0, 1.0, 1.0, "1 with the elevator at a limit, else 0"),
]

# What belongs together on a connection: the terminals of FMI 3.0.
TERMINALS = {
    "measurements": ("V", "h", "gamma", "theta", "Q"),
    "commands": ("V_command", "h_command"),
    "actuators": ("fuel_ratio", "elevator"),
}

# Parameters of every law; `theta_trim` and `internal_step` are for those that need them.
SHARED = [
    ("fuel_ratio_min", "parameter", "1", 0.05, None, None, None, "lower limit of the fuel ratio"),
    ("fuel_ratio_max", "parameter", "1", 1.5, None, None, None, "upper limit of the fuel ratio"),
    ("elevator_min", "parameter", "rad", -20 * DEG, -90 * DEG, 90 * DEG, None, "lower limit of the elevator"),
    ("elevator_max", "parameter", "rad", 20 * DEG, -90 * DEG, 90 * DEG, None, "upper limit of the elevator"),
    ("reference_omega", "parameter", "rad/s frequency", 0.1, SMALL, 100.0, None,
     "natural frequency of the reference filters (67)"),
    ("reference_zeta", "parameter", "1", 0.9, 0.0, 10.0, None, "damping ratio of the reference filters (67)"),
    ("solve_trim", "parameter", "", True, None, None, None, "start at the nominal trim for the measured V, h"),
    ("fuel_ratio_trim", "parameter", "1", 0.26703, 0.0, 2.0, None, "fuel ratio at the start, if not solved"),
    ("elevator_trim", "parameter", "rad", 12.511 * DEG, -90 * DEG, 90 * DEG, None, "elevator at start, if not solved"),
]
PARAMETERS = [
    *SHARED,
    ("theta_trim", "parameter", "rad", 1.6325 * DEG, -90 * DEG, 90 * DEG, None, "pitch angle of trim, if not solved"),
    ("internal_step", "parameter", "s", 0.005, 1e-5, 0.1, None, "longest internal step"),
]


def start_trim(m, u, p, names=("fuel_ratio", "elevator", "theta")):
    """Trim values to start from, in the order of `names`: the nominal vehicle's trim at the measured V and h, or
    the given one (parameters NAME_trim)."""
    trim = level_trim(m, u.V, u.h, NOMINAL_VEHICLE)
    return tuple(m.where(p.solve_trim, getattr(trim, name), getattr(p, f"{name}_trim")) for name in names)


def limited(m, wanted, low, high):
    """`wanted` within its limits, and whether that changed it."""
    return m.clip(wanted, low, high), m.either(wanted < low, wanted > high)


def gamma_command(m, h, V, h_ref, p):
    """gamma_d of (36), rad; the arcsine's argument is kept within +-0.5 (30 degrees)."""
    return m.asin(m.clip((-p.k_gamma * (h - h_ref[0]) + h_ref[1]) / V, -0.5, 0.5))
