"""The plant with actuators and sensors as they are: lag, rate limits, delays, noise. All are off by default, and then
the vehicle moves exactly as `AhvPlant` does.

The ports are the plant's, so that one FMU replaces the other; V, h, gamma, theta, Q are what the sensors show, and
V_true ... Q_true what is. A command passes a delay, then a lag with a rate limit; a measurement passes a
delay, then noise is added.

A delay is a line of TAPS samples, one every TAP seconds, read in between by straight lines; for communication
steps that are no multiple of TAP it is right to within one step. A new noise sample comes every TAP seconds (see
`noise`).
"""
from math import pi
from types import SimpleNamespace

from . import model as plant
from .noise import LARGEST_SEED, samples

NAME = "AhvInstrumentedPlant"
AUTHOR = "the AHV FMU authors"
DESCRIPTION = "The vehicle with actuator lag, rate limits, delays and sensor noise, all off by default"

TAP, TAPS = 0.005, 50
EARLY = 1e-9  # s: a grid point is not missed by a rounding of the clock
ACTUATORS = (("fuel_ratio", "1", 1.0), ("elevator", "rad", 0.1))
SENSORS = (("V", "ft/s", 1000.0), ("h", "ft", 1000.0), ("gamma", "rad", 0.01), ("theta", "rad", 0.01),
           ("Q", "rad/s", 0.01))
CHANNELS = [name for name, *_ in (*ACTUATORS, *SENSORS)]

RATE = {"1": "1/s", "rad": "rad/s"}

# name, causality, unit, start, min, max, nominal, description.
VARIABLES = [
    *(("internal_step", "parameter", "s", TAP, 1e-6, TAP, None, "longest internal step") if row[0] == "internal_step"
      else row for row in plant.VARIABLES),
    *((f"{name}_true", "output", unit, None, None, None, nominal, f"{name} before the sensor")
      for name, unit, nominal in SENSORS),
    *((f"{name}_used", "output", unit, None, None, None, nominal, f"{name} after the actuator")
      for name, unit, nominal in ACTUATORS),
    *((f"{name}_delay", "parameter", "s", 0.0, 0.0, TAP * (TAPS - 2), None, f"delay of {name}") for name in CHANNELS),
    *((f"{name}_bandwidth", "parameter", "rad/s frequency", 0.0, 0.0, 1e4, None,
      f"bandwidth of {name}'s lag; 0 for none") for name, *_ in ACTUATORS),
    *((f"{name}_rate_limit", "parameter", RATE[unit], 0.0, 0.0, None, None, f"largest rate of {name}; 0 for none")
      for name, unit, _ in ACTUATORS),
    *((f"{name}_noise", "parameter", unit, 0.0, 0.0, None, None, f"root mean square of {name}'s noise")
      for name, unit, _ in SENSORS),
    ("noise_seed", "parameter", "1", 1.0, 1.0, LARGEST_SEED, None, "which noise, a whole number"),
]

TERMINALS = plant.TERMINALS

OFF = {name: start for name, causality, _, start, *_ in VARIABLES[len(plant.VARIABLES):] if causality == "parameter"}
AS_BUILT = {  # a plausible set, no datum: the literature's 20 rad/s, the rest assumed
    **OFF, "fuel_ratio_bandwidth": 20.0, "elevator_bandwidth": 20.0, "elevator_rate_limit": 100 * pi / 180,
    **{f"{name}_delay": TAP for name, *_ in SENSORS},
    "V_noise": 0.1, "h_noise": 0.3, "gamma_noise": 2e-5, "theta_noise": 2e-5, "Q_noise": 2e-4,
}
PRESETS = {name: {**structure, **instruments} for name, structure, instruments in (
    ("decoupled", plant.PRESETS["decoupled"], OFF), ("estimated-coupling", plant.PRESETS["estimated-coupling"], OFF),
    ("as-built", plant.PRESETS["decoupled"], AS_BUILT))}

VEHICLE = 9 + len(plant.MEMORY)


def unpack(x):
    """The plant's states; position of both actuators; one delay line per channel."""
    lines = x[VEHICLE + 2:]
    return SimpleNamespace(vehicle=x[:VEHICLE], actuators=x[VEHICLE:VEHICLE + 2],
                           lines=[lines[i * TAPS:(i + 1) * TAPS] for i in range(len(CHANNELS))])


def start(m, u, p):
    """The plant's initial state, actuators and delay lines at rest where it is: see `unpack`."""
    vehicle = plant.start(m, u, p)
    commands = [u.fuel_ratio, u.elevator]
    return [*vehicle, *commands, *(value for now in (*commands, *vehicle[:5]) for value in [now] * TAPS)]


def ticks(m, t):
    """Grid points passed until t (s)."""
    return m.floor((t + EARLY) / TAP)


def delayed(m, now, line, delay, since):
    """The signal `delay` seconds ago: `line` has its values `since`, `since` + TAP, ... seconds ago."""
    position = (delay - since) / TAP
    past = sum(m.fmax(0.0, 1.0 - m.fabs(position - i)) * value for i, value in enumerate(line))
    return m.where(m.either(delay <= 0.0, position < 0.0), now, past)


def actuator_step(m, position, command, bandwidth, rate, h):
    """An actuator's position h seconds later, and what acts in between.

    bandwidth in rad/s, rate per second; 0 for none.
    """
    change = (command - position) * m.where(bandwidth > 0.0, 1.0 - m.exp(-bandwidth * h), 1.0)
    later = position + m.where(rate > 0.0, m.clip(change, -rate * h, rate * h), change)
    return later, m.where(m.either(bandwidth > 0.0, rate > 0.0), 0.5 * (position + later), command)


def advance(m, t, h, x, u, p, c):
    """The state h seconds later: commands through the actuators, the plant's own step, then the sensors' lines."""
    s = unpack(x)
    passes = ticks(m, t + h) > ticks(m, t)

    def shifted(line, now):
        return [m.where(passes, new, old) for new, old in zip([now, *line], line)]

    used, actuators, lines = [], [], []
    for (name, *_), position, line in zip(ACTUATORS, s.actuators, s.lines):
        command = getattr(u, name)
        # A command is held: a line has it as of the interval before the last grid point.
        late = delayed(m, command, [command, *line], getattr(p, f"{name}_delay"), 0.0)
        bandwidth, rate = getattr(p, f"{name}_bandwidth"), getattr(p, f"{name}_rate_limit")
        later, acts = actuator_step(m, position, late, bandwidth, rate, h)
        used.append(acts)
        actuators.append(later)
        lines.append(shifted(line, command))
    held = SimpleNamespace(**{**vars(u), "fuel_ratio": used[0], "elevator": used[1]})
    states = m.integrate(lambda t, x: plant.derivative(m, t, x, held, p), t, s.vehicle[:9], h, plant.ORDER)
    vehicle = [*states, *s.vehicle[9:]]
    lines += [shifted(line, now) for line, now in zip(s.lines[2:], vehicle[:5])]
    return [*vehicle, *actuators, *(value for line in lines for value in line)]


def outputs(m, t, x, u, p):
    """The plant's outputs with the actuators where they are, and the measurements in the states' place."""
    s = unpack(x)
    acts = []
    for (name, *_), position in zip(ACTUATORS, s.actuators):
        ideal = m.both(getattr(p, f"{name}_bandwidth") <= 0.0, getattr(p, f"{name}_rate_limit") <= 0.0)
        ideal = m.both(ideal, getattr(p, f"{name}_delay") <= 0.0)
        acts.append(m.where(ideal, getattr(u, name), position))
    y = plant.outputs(m, t, s.vehicle, SimpleNamespace(**{**vars(u), "fuel_ratio": acts[0], "elevator": acts[1]}), p)
    tick = ticks(m, t)
    noise = samples(m, p.noise_seed, tick, len(SENSORS))
    for (name, *_), line, sample in zip(SENSORS, s.lines[2:], noise):
        y[f"{name}_true"] = y[name]
        shown = delayed(m, y[name], line, getattr(p, f"{name}_delay"), t - TAP * tick)
        y[name] = shown + getattr(p, f"{name}_noise") * sample
    return {**y, "fuel_ratio_used": acts[0], "elevator_used": acts[1]}
