"""Flights of the small oscillator with noise, as tables for fits."""
import numpy as np
import small

from cosim.master.fly import fly
from cosim.master.system import Component, System

TRUE = {"a21": -5.0, "a22": -0.4}
NOISE = {"y": 0.02, "y2": 0.05}


def one(fmu, **values):
    """A system of one oscillator, `a`."""
    return System([Component("a", fmu, small.oscillator(**values))], step=0.02)


def measured(path, fmu, seed=1, stop=4.0, noise=1.0, gaps=0.0, prefix="", inputs=None, **values):
    """Write what an oscillator with TRUE values shows, with noise, to a CSV file; its path. `gaps` is the share of
    cells that are empty."""
    rng = np.random.default_rng(seed)
    flight = fly(one(fmu, **TRUE, **values), 0.02, stop, inputs=inputs)
    time = flight.time[::5]
    columns = {f"{prefix}{name}": flight[f"a.{name}"][::5] + noise * size * rng.standard_normal(len(time))
               for name, size in NOISE.items()}
    if inputs:
        columns |= {f"{prefix}{name}": np.interp(time, inputs.times, x) for name, x in inputs.values.items()}
    lines = [",".join(["time", *columns])]
    for k, t in enumerate(time):
        cells = ["" if rng.random() < gaps else repr(float(x[k])) for x in columns.values()]
        lines.append(",".join([f"{t:.12g}", *cells]))
    path.write_text("\n".join(lines) + "\n")
    return path
