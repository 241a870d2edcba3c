"""Cost of every single 10 ms step of the native control laws, called from C as a real-time task would.

    .venv/bin/python benchmarks/worst_step.py [--steps 1000000] [--json]

Prints costs in microseconds, and how often the FMU asked for memory before and after its initialisation ended:
median, 99.99 % and largest of one pass, which has the operating system's interruptions in it; and, where each step
counts as the least of three passes with the same inputs, which has not, the first step (it also prepares numbers that
depend on the step's length) and the largest of all others.
"""
import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import fmpy
import numpy as np
from native_step import HERE, INCLUDE, STEP

from fmus.native_compiler import COMPILE, cc
from fmus.places import found

PASSES = 3
LAWS = ("AhvController", "AhvResilient", "AhvBackstepping")
OUTPUTS = ("fuel_ratio", "elevator")
# How far each input wanders around its start: ft/s, ft, rad, rad, rad/s; ft/s, ft.
SWING = {"V": 0.5, "h": 2.0, "gamma": 2e-4, "theta": 0.001, "Q": 0.001, "V_command": 0.5, "h_command": 2.0}


def array(items) -> str:
    return f"{{{', '.join(map(str, items))}}}"


def measure(name: str, steps: int) -> dict[str, float]:
    """Microseconds and allocations of `steps` communication steps of the native FMU called `name`."""
    with tempfile.TemporaryDirectory() as there:
        folder = Path(there)
        fmpy.extract(str(found("native", name)), there)
        description = fmpy.read_model_description(there)
        of = {v.name: v for v in description.modelVariables}
        (folder / "step.h").write_text("\n".join([
            f'#define GUID "{description.guid}"', f"#define STEP {STEP}",
            f"#define INPUTS {array(of[n].valueReference for n in SWING)}",
            f"#define OUTPUTS {array(of[n].valueReference for n in OUTPUTS)}",
            f"#define START {array(of[n].start for n in SWING)}", f"#define SWING {array(SWING.values())}", ""]))
        program = folder / "worst_step"
        cc(*COMPILE, f"-I{folder}", *(f"-I{path}" for path in INCLUDE), "-o", program,
           HERE / "worst_step.c", "-lm", "-ldl")
        passes = [subprocess.run([program, folder / "binaries" / "linux64" / f"{name}.so", str(steps)], check=True,
                                 capture_output=True) for _ in range(PASSES)]
    costs = np.array([np.frombuffer(done.stdout, np.int32) / 1000 for done in passes])
    least = costs.min(axis=0)
    before, after = map(int, passes[0].stderr.split())
    return {"median_us": float(np.median(costs[0])), "p99_99_us": float(np.quantile(costs[0], 0.9999)),
            "max_us": float(costs[0].max()), "first_us": float(least[0]), "worst_us": float(least[1:].max()),
            "allocations_before": before, "allocations_after": after}


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=1_000_000)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    figures = {name: measure(name, options.steps) for name in LAWS}
    if options.json:
        print(json.dumps(figures), file=sys.stdout)
    else:
        for law, row in figures.items():
            print(f"{law:16}", "  ".join(f"{key} {value:.3g}" for key, value in row.items()))
