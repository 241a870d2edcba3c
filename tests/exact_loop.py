"""What the oracle `exact_linear` says of a loop of ours, in the words of `ahv linearize --json`."""
from functools import cache
from importlib import import_module

import numpy as np
from exact_linear import linear_loop, linear_vehicle

from ahv_plant_fmu import model as plant
from cosim.analysis.margins import margins_at
from cosim.vehicle.registry import LAWS

ZEROS = (("fuel_ratio", "V"), ("fuel_ratio", "gamma"), ("elevator", "V"), ("elevator", "gamma"), ("elevator", "theta"))


@cache
def exact(law: str, preset: str, V: float = 7700.0, h: float = 85000.0, scale: float = 1.0, step: float = 0.01) -> dict:
    """Poles and zeros as complex vectors, margins by place and name, and the flight about which they are."""
    module = import_module(LAWS[law].module)
    scales = dict.fromkeys(("thrust", "lift", "drag", "moment", "forces"), scale)
    alone = linear_vehicle(plant, V, h, scales)
    loop = linear_loop(plant, module, module.PRESETS[preset], V, h, step, scales)
    closed = loop.cut()
    stable = bool(np.abs(np.linalg.eigvals(closed.A)).max() < 1)
    return {"fuel_ratio": loop.y[0], "elevator_deg": np.degrees(loop.y[1]), "theta_deg": np.degrees(loop.x[3]),
            "A": alone.A, "B": alone.B, "open_loop": alone.poles,
            "zeros": {f"{i} to {o}": alone.zeros(i, o) for i, o in ZEROS}, "stable": stable,
            "closed_loop": closed.poles[np.abs(closed.poles) < 1e4],
            "margins": {name: margins_at(cut).as_dict() for name, cut in loop.cuts().items()} if stable else None}
