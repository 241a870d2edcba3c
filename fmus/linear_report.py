"""What `ahv linearize` tells: the vehicle alone and under a controller, about a trim, as plain data."""
from collections.abc import Callable
from types import ModuleType
from typing import Any

import numpy as np

from .linearize import Array, Linear, damping, linear_loop, linear_vehicle

ZEROS = (("fuel_ratio", "V"), ("fuel_ratio", "gamma"), ("elevator", "V"), ("elevator", "gamma"), ("elevator", "theta"))


def roots(values: Array) -> list[dict[str, float | None]]:
    """Poles or zeros: real and imaginary part (1/s), natural frequency (rad/s), damping ratio."""
    return [{"real": float(v.real), "imag": float(v.imag), "omega": float(abs(v)), "damping": d}
            for v, d in zip(values, damping(values)) if abs(v) < 1e4]


def matrices(system: Linear) -> dict[str, Any]:
    """A, B, C, D as lists of rows, and what their rows and columns are."""
    return {"states": system.states, "inputs": system.inputs, "outputs": system.outputs, "step_s": system.step,
            **{name: getattr(system, name).tolist() for name in "ABCD"}}


def linear_report(plant: ModuleType, law: ModuleType, gains: dict[str, Any], V: float, h: float, step: float,
                  scale: dict[str, float], parameters: dict[str, Any], margins_at: Callable[[Linear], Any]
                  ) -> dict[str, Any]:
    """Open loop: continuous, with zeros. Closed loop: sampled every `step` seconds as it flies, poles as those of the
    continuous system with the same samples; margins at each actuator and sensor, which `margins_at` takes
    from the loop cut there. The other arguments are those of `linear_loop`, and so is what it raises."""
    alone = linear_vehicle(plant, V, h, scale, **parameters)
    loop = linear_loop(plant, law, gains, V, h, step, scale, parameters)
    closed = loop.cut()
    stable = bool(np.abs(np.linalg.eigvals(closed.A)).max() < 1)
    fuel_ratio, elevator = (float(v) for v in loop.y)
    return {
        "V_fps": V, "h_ft": h, "scale": scale, "fuel_ratio": fuel_ratio, "elevator_deg": float(np.degrees(elevator)),
        "theta_deg": float(np.degrees(loop.x[3])), "altitude_offset_ft": float(loop.x[1] - h),
        "open_loop": {**matrices(alone), "poles": roots(alone.poles),
                      "zeros": {f"{i} to {o}": roots(alone.zeros(i, o)) for i, o in ZEROS}},
        "closed_loop": {**matrices(closed), "stable": stable, "abscissa": float(closed.poles.real.max()),
                        "poles": roots(closed.poles)},
        "margins": {name: margins_at(cut).as_dict() for name, cut in loop.cuts().items()} if stable else None,
    }
