"""Draws docs/pictures/fit.png: five noisy flights of a vehicle heavier than the FMU says, and what `ahv fit` finds.

    .venv/bin/python docs/draw_fit.py [FOLDER]
"""
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from cosim.master.fly import fly
from cosim.vehicle import scenarios
from cosim.vehicle.closed_loop import closed_loop

PICTURES = Path(__file__).parent / "pictures"
MASS = 330.0  # slug/ft; the FMU says 300
STARTS = ((7700, 85000), (8200, 88000), (7900, 83000), (8600, 92000), (9000, 95000))  # ft/s, ft
NOISE = {"plant.theta": 0.003, "plant.load_factor": 0.02, "controller.fuel_ratio": 0.02}  # rad, 1, 1
STEP, STOP, EVERY, SEED = 0.02, 8.0, 10, 3
AHV = Path(sys.executable).with_name("ahv")


def measure(folder: Path) -> list[str]:
    """Write a table for each flight into `folder`; the words of `ahv fit` that name them and their starts."""
    rng, plan, words = np.random.default_rng(SEED), scenarios.load("case1"), []
    for number, (V, h) in enumerate(STARTS, 1):
        loop = closed_loop(plan, "resilient", values={"plant": {"mass": MASS, "V_start": V, "h_start": h}})
        flight = fly(loop.system, STEP, STOP, record=list(NOISE))
        time = flight.time[::EVERY]
        seen = [flight[name][::EVERY] + size * rng.standard_normal(len(time)) for name, size in NOISE.items()]
        name = f"flight{number}.csv"
        np.savetxt(folder / name, np.column_stack([time, *seen]), delimiter=",", comments="",
                   header=",".join(["time", *NOISE]))
        words += [name, "--set", f"{name}:plant.V_start={V}", "--set", f"{name}:plant.h_start={h}"]
    return words


def main(folder: Path) -> None:
    """Draw it into `folder`."""
    with tempfile.TemporaryDirectory() as made:
        words = measure(Path(made))
        subprocess.run([AHV, "fit", "case1", *words, "--controller", "resilient", "--parameter", "plant.mass", "--out",
                        "found"], cwd=made, check=True)
        (folder / "fit.png").write_bytes(Path(made, "found", "fit.png").read_bytes())


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else PICTURES)
