"""The backstepping rival as a component: its table of variables and its presets."""
from .backstepping import advance, derivative, outputs, prepare, start  # noqa: F401  (the component's functions)
from .ports import PARAMETERS, PORTS, SMALL
from .ports import TERMINALS as TERMINALS

NAME = "AhvBackstepping"
AUTHOR = "the AHV FMU authors"
DESCRIPTION = "Backstepping controller with tracking differentiators and disturbance observers, a reconstruction"

# Tuned for both cases, four flights with groups that scale against each other, and two with constant scales
# (docs/evidence.md, "How they were tuned").
CALIBRATED = {
    "kV1": 0.6587, "kV2": 6.269, "observer_V": 0.4977, "k_gamma": 2.986, "k_path": 0.5023,
    "k_theta": 0.4727, "k_Q": 7.226, "observer_gamma": 0.7533, "observer_Q": 0.689,
    "R_gamma": 0.2878, "R_theta": 8.657, "R_Q": 97.96,
}
# For groups that err each on its own, by up to 40 %: `ahv tune backstepping --evaluations 220`.
INDEPENDENT = {
    "kV1": 1.154, "kV2": 5.246, "observer_V": 0.6194, "k_gamma": 1.227, "k_path": 0.5957, "k_theta": 0.2014,
    "k_Q": 8.173, "observer_gamma": 0.3848, "observer_Q": 0.5384, "R_gamma": 0.2913, "R_theta": 10.91,
    "R_Q": 153.6,
}
PRESETS = {"calibrated": CALIBRATED, "independent": INDEPENDENT}

# name, causality, unit, start, min, max, nominal, description.
VARIABLES = [
    *PORTS,
    ("theta_command", "output", "rad", None, None, None, 0.01, "virtual control theta_d"),
    ("Q_command", "output", "rad/s", None, None, None, 0.01, "virtual control Q_d"),
    ("disturbance_V", "output", "ft/s^2", None, None, None, 1.0, "estimated disturbance of the velocity"),
    ("disturbance_gamma", "output", "rad/s", None, None, None, 0.01, "estimated disturbance of the flight-path angle"),
    ("disturbance_Q", "output", "rad/s^2", None, None, None, 0.01, "estimated disturbance of the pitch rate"),

    *((name, "parameter", unit, CALIBRATED[name], low, high, None, text) for name, unit, low, high, text in (
        ("kV1", "1/s", 0.0, None, "velocity error gain"),
        ("kV2", "1/s^2", 0.0, None, "velocity integral gain"),
        ("observer_V", "1/s", 0.0, 1000.0, "bandwidth of the velocity's disturbance observer"),
        ("k_gamma", "1/s", 0.0, None, "altitude error gain (36)"),
        ("k_path", "1/s", 0.0, None, "flight-path angle error gain"),
        ("k_theta", "1/s", 0.0, None, "pitch angle error gain"),
        ("k_Q", "1/s", 0.0, None, "pitch rate error gain"),
        ("observer_gamma", "1/s", 0.0, 1000.0, "bandwidth of the flight-path angle's disturbance observer"),
        ("observer_Q", "1/s", 0.0, 1000.0, "bandwidth of the pitch rate's disturbance observer"),
        ("R_gamma", "1/s", SMALL, 1000.0, "bandwidth of the tracking differentiator on gamma_d"),
        ("R_theta", "1/s", SMALL, 1000.0, "bandwidth of the tracking differentiator on theta_d"),
        ("R_Q", "1/s", SMALL, 1000.0, "bandwidth of the tracking differentiator on Q_d"),
    )),
    *PARAMETERS,
]

STATES = [
    "V_reference",
    ("V_reference_rate", "local", "ft/s^2", None, None, None, 1.0, "rate of the filtered velocity command"),
    "h_reference",
    ("h_reference_rate", "local", "ft/s", None, None, None, 10.0, "rate of the filtered altitude command"),
    ("V_integral", "local", "ft", None, None, None, 1.0, "integral of the velocity error"),
    ("V_observer", "local", "ft/s^2", None, None, None, 1000.0, "state of the velocity's disturbance observer"),
    ("gamma_observer", "local", "rad/s", None, None, None, 0.01, "state of the path angle's disturbance observer"),
    ("Q_observer", "local", "rad/s^2", None, None, None, 0.01, "state of the pitch rate's disturbance observer"),
    *((f"{name}_followed{suffix}", "local", unit, None, None, None, 0.01, f"{what} the differentiator on {name}_d")
      for name, units in (("gamma", ("rad", "rad/s")), ("theta", ("rad", "rad/s")), ("Q", ("rad/s", "rad/s^2")))
      for suffix, what, unit in zip(("", "_rate"), ("output of", "rate of"), units)),
]
