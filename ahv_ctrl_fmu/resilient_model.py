"""The law that keeps the vehicle as a component: its table of variables and its presets."""
from .ports import DEG, PORTS, SHARED, SMALL
from .ports import TERMINALS as TERMINALS
from .resilient import SECTIONS, advance, outputs, prepare, start  # noqa: F401  (the last four: the component)

NAME = "AhvResilient"
AUTHOR = "the AHV FMU authors"
DESCRIPTION = "Control law that keeps the vehicle while its coefficients err by 40 %, each group on its own"

NO_FILTER = {f"section_{k}_{name}": 0.0 for k in SECTIONS for name in ("zero", "zero_damping", "pole", "pole_damping")}

# The quiet form: deaf to noise, sturdy against slow actuators, and the most accurate over independent draws.
QUIET = {
    "k_gamma": 0.402, "k_path": 0.786, "k_alpha": 2.61, "k_Q": 7.93, "k_V": 5.13,
    "observer_V": 5.52, "observer_gamma": 23.0, "observer_Q": 40.9,
    "filter_h": 2.79, "filter_gamma": 3.13, "filter_lift": 10.0, "filter_moment": 11.3, "measured_rates": False,
    "lift_lead": 0.229, "moment_gain": 9.83, "moment_floor": 0.0422, "moment_washout": 3.1, "hold_rate": 1.43,
    "alpha_margin": 0.726 * DEG, "k_barrier": 1.3, "barrier_margin": 0.156 * DEG,
    "V_recovery": 1.4, "elevator_band": 1.74 * DEG, "servo_rate": 21.6, "servo_speed": 60 * DEG,
    **NO_FILTER,
}
# Without the quiet form's filters; twice the observer's rate makes the slow flight-path angle the observer's own.
LEAN = {
    "k_gamma": 0.6, "k_path": 0.87, "k_alpha": 1.9, "k_Q": 7.4, "k_V": 5.5,
    "observer_V": 7.2, "observer_gamma": 27.0, "observer_Q": 31.0,
    "filter_h": 0.0, "filter_gamma": 2 * 27.0, "filter_lift": 0.0, "filter_moment": 0.0, "measured_rates": True,
    "lift_lead": 0.16, "moment_gain": 17.0, "moment_floor": 0.05, "moment_washout": 3.7, "hold_rate": 0.92,
    "alpha_margin": 1.15 * DEG, "k_barrier": 1.5, "barrier_margin": 0.13 * DEG,
    "V_recovery": 2.7, "elevator_band": 5 * DEG, "servo_rate": 61.0, "servo_speed": 60 * DEG,
    **NO_FILTER,
}
# For a structure that pushes back, either way: three sections in the moment demand, slow observers. It states every
# number itself: margins and flights were found together, and a change of another preset must not move them.
COUPLED = {
    "k_gamma": 0.7872, "k_path": 0.8277, "k_alpha": 1.341, "k_Q": 18.45, "k_V": 5.5,
    "observer_V": 2.233, "observer_gamma": 6.582, "observer_Q": 3.47,
    "filter_h": 49.25, "filter_gamma": 44.82, "filter_lift": 35.84, "filter_moment": 188.4, "measured_rates": True,
    "lift_lead": 0.9079, "moment_gain": 4.936, "moment_floor": 0.08144, "moment_washout": 3.061, "hold_rate": 2.103,
    "alpha_margin": 0.674 * DEG, "k_barrier": 1.161, "barrier_margin": 0.13 * DEG,
    "V_recovery": 1.233, "elevator_band": 0.7145 * DEG, "servo_rate": 215.8, "servo_speed": 60 * DEG,
    **NO_FILTER,
    "section_a_zero": 24.73, "section_a_zero_damping": 0.4764, "section_a_pole": 16.89, "section_a_pole_damping": 2.0,
    "section_b_zero": 15.66, "section_b_zero_damping": 0.05257, "section_b_pole": 33.73,
    "section_b_pole_damping": 0.4948,
    "section_c_pole": 154.4, "section_c_pole_damping": 2.0,
}
PRESETS = {"quiet": QUIET, "lean": LEAN, "coupled": COUPLED}

# name, causality, unit, start, min, max, nominal, description.
VARIABLES = [
    *PORTS,
    ("scale_lift", "output", "1", None, None, None, 1.0, "lift scale found, as used: filtered and a moment ahead"),
    ("scale_moment", "output", "1", None, None, None, 1.0, "moment scale found"),
    ("elevator_hold", "output", "rad", None, None, None, 0.1, "elevator that holds the present angle of attack"),
    ("alpha_command", "output", "rad", None, None, None, 0.01, "angle of attack commanded"),
    ("alpha_limit", "output", "rad", None, None, None, 0.01, "largest angle of attack that the elevator can hold"),
    ("protecting", "output", "1 discrete", None, 0.0, 1.0, 1.0,
     "1 while the limit binds: altitude asks for more than can be held; else 0"),
    ("disturbance_V", "output", "ft/s^2", None, None, None, 1.0, "estimated disturbance of the velocity"),
    ("disturbance_Q", "output", "rad/s^2", None, None, None, 0.01, "estimated disturbance of the pitch rate"),

    *((name, "parameter", unit, QUIET[name], low, high, None, text) for name, unit, low, high, text in (
        ("k_gamma", "1/s", 0.0, None, "altitude error gain (36)"),
        ("k_path", "1/s", 0.0, None, "climb rate error gain"),
        ("k_alpha", "1/s", 0.0, None, "angle of attack error gain"),
        ("k_Q", "1/s", 0.0, None, "pitch rate error gain"),
        ("k_V", "1/s", 0.0, None, "velocity error gain"),
        ("observer_V", "1/s", SMALL, 1000.0, "rate of the velocity's observer"),
        ("observer_gamma", "1/s", SMALL, 1000.0, "rate of the flight-path angle's observer, which finds the lift"),
        ("observer_Q", "1/s", SMALL, 1000.0, "rate of the pitch rate's observer"),
        ("filter_h", "1/s", 0.0, 1000.0, "rate at which the altitude used follows the measured one; 0 at once"),
        ("filter_gamma", "1/s", 0.0, 1000.0, "rate at which the path angle used follows the measured one; 0 at once"),
        ("filter_lift", "1/s", 0.0, 1000.0, "rate of the low-pass on the lift scale found; 0 for none"),
        ("filter_moment", "1/s", 0.0, 1000.0, "rate of the low-pass on the pitch rate's disturbance; 0 for none"),
        ("measured_rates", "", None, None, "use V and Q as measured, not as the observers have them"),
        ("lift_lead", "s", 0.0, 10.0, "how far ahead the lift scale is predicted"),
        ("moment_gain", "1/s", 0.0, 1000.0, "rate at which the moment scale is found; 0 keeps it 1"),
        ("moment_floor", "rad/s^2", SMALL, None, "change of the nominal moment that is needed to find its scale"),
        ("moment_washout", "1/s", SMALL, 1000.0, "changes slower than this do not count for the moment scale"),
        ("hold_rate", "1/s", SMALL, 1000.0, "rate at which the moment's bias enters the elevator that holds"),
        ("alpha_margin", "rad", 0.0, 90 * DEG, "elevator kept back at the largest angle of attack commanded"),
        ("k_barrier", "1/s", 0.0, None, "rate at which the angle of attack may approach the elevator's stop"),
        ("barrier_margin", "rad", 0.0, 90 * DEG, "elevator kept back from the stop by that limit"),
        ("V_recovery", "ft/s^2", 0.0, None, "largest acceleration asked for to mend a velocity error"),
        ("elevator_band", "rad", 0.0, 90 * DEG, "elevator used about the one that holds; thrust pitches with the rest"),
        ("servo_rate", "1/s", 0.0, 1000.0, "rate of the elevator servo's model; 0 for a servo without lag"),
        ("servo_speed", "rad/s", SMALL, None, "largest speed of the elevator servo's model"),
    )),
    *((f"section_{k}_{name}", "parameter", unit, 0.0, low, 1000.0, None, f"moment demand's filter, section {k}: {text}")
      for k in SECTIONS for name, unit, low, text in (
        ("zero", "rad/s frequency", 0.0, "frequency of its zeros; 0 for none"),
        ("zero_damping", "1", -10.0, "damping ratio of its zeros"),
        ("pole", "rad/s frequency", 0.0, "frequency of its poles; 0 for no section"),
        ("pole_damping", "1", 0.0, "damping ratio of its poles"))),
    *SHARED,
]
