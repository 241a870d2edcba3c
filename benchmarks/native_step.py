"""Cost of one 10 ms step of plant and controller: native FMU from C, bare traced functions, Python FMU.

    .venv/bin/python benchmarks/native_step.py [--json]
"""
import json
import math
import subprocess
import sys
import tempfile
import time
from importlib import import_module
from pathlib import Path

import casadi
import fmpy
from fmpy.fmi2 import FMU2Slave

from cosim.vehicle.registry import MODELS
from fmus.interface import internal_steps, variables
from fmus.native_compiler import COMPILE, cc
from fmus.places import found
from fmus.trace import trace_model

HERE = Path(__file__).parent
STEP = 0.01
INCLUDE = [Path(fmpy.__file__).parent / "c-code", HERE.parent / "tests" / "conformance" / "native"]


def write_kernel(model, guid: str, folder: Path) -> None:
    """kernel.c and kernel.h of native_step.c."""
    traced, table = trace_model(model), variables(model.VARIABLES)
    generator = casadi.CodeGenerator("kernel", {"with_header": True})
    for function in (traced.prepare, traced.start, traced.advance, traced.outputs):
        generator.add(function)
    generator.generate(f"{folder}/")
    (folder / "kernel.h").rename(folder / "functions.h")
    starts = {v.name: float(v.start) for v in table if v.start is not None}
    groups = {key: ", ".join(repr(starts[v.name]) for v in table if v.causality == causality)
              for key, causality in (("U", "input"), ("P", "parameter"))}
    count = internal_steps(STEP, starts.get("internal_step", STEP))
    (folder / "kernel.h").write_text("\n".join([
        "#define casadi_int long long int", "#define casadi_real double", '#include "functions.h"',
        *(f"#define {key} {{{values}}}" for key, values in groups.items()),
        *(f"#define N{key.upper()} {size}" for key, size in traced.sizes.items()),
        f'#define COUNT {count}', f"#define STEP {STEP}", f'#define GUID "{guid}"', ""]))


def native(name: str, folder: Path) -> tuple[float, float]:
    """(FMU, bare functions), microseconds."""
    fmpy.extract(str(found("native", name)), str(folder))
    write_kernel(import_module(MODELS[name]), fmpy.read_model_description(str(folder)).guid, folder)
    program = folder / "native_step"
    cc(*COMPILE, f"-I{folder}", *(f"-I{path}" for path in INCLUDE), "-o", program,
       HERE / "native_step.c", folder / "kernel.c", "-lm", "-ldl")
    done = subprocess.run([program, folder / "binaries" / "linux64" / f"{name}.so"], check=True,
                          capture_output=True, text=True)
    fmu, bare = map(float, done.stdout.split())
    return fmu, bare


def python(name: str, folder: Path, steps: int = 100) -> float:
    """One step of the Python flavour called through fmpy, microseconds."""
    fmpy.extract(str(found("python", name)), str(folder))
    slave = FMU2Slave(guid=fmpy.read_model_description(str(folder)).guid, unzipDirectory=str(folder),
                      modelIdentifier=name, instanceName="timed")
    slave.instantiate()
    slave.setupExperiment()
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    state, best = slave.getFMUState(), math.inf
    for _ in range(5):
        slave.setFMUState(state)
        began = time.perf_counter()
        for k in range(steps):
            slave.doStep(k * STEP, STEP)
        best = min(best, 1e6 * (time.perf_counter() - began) / steps)
    return best


def measure() -> dict[str, dict[str, float]]:
    result = {}
    for name in ("AhvController", "AhvPlant"):
        with tempfile.TemporaryDirectory() as c, tempfile.TemporaryDirectory() as py:
            fmu, bare = native(name, Path(c))
            result[name] = {"native_us": fmu, "bare_us": bare, "ratio": fmu / bare, "python_us": python(name, Path(py))}
    result["together"] = {"native_us": sum(r["native_us"] for r in result.values())}
    return result


if __name__ == "__main__":
    figures = measure()
    if "--json" in sys.argv:
        print(json.dumps(figures))
    else:
        for name, row in figures.items():
            print(f"{name:14}", "  ".join(f"{key} {value:.3g}" for key, value in row.items()))
