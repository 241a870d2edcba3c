"""Cost of one 10 ms step: native FMU from C, the bare functions of its sources, Python FMU.

    .venv/bin/python benchmarks/native_step.py [--law NAME]... [--against FILE.fmu]... [--json]

Plant and neural controller, or the FMUs named. All are timed by turns in short rounds, in one process. `*_us` is the
quickest round, for what disturbs a machine only ever adds; a ratio is the median of the rounds' ratios, and its spread
from the first to the third quartile. --against FILE.fmu times an FMU of the same name of another edition beside ours.
"""
import argparse
import json
import math
import subprocess
import tempfile
import time
from pathlib import Path

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Slave

from fmus.native_compiler import COMPILE, cc
from fmus.places import found

HERE = Path(__file__).parent
STEP = 0.01
INCLUDE = [Path(fmpy.__file__).parent / "c-code", HERE.parent / "tests" / "conformance" / "native"]
NAMES = ("AhvController", "AhvPlant")


def unpacked(fmu: Path, folder: Path) -> tuple[Path, str]:
    """Library and GUID of a native FMU, unpacked into `folder`."""
    fmpy.extract(str(fmu), str(folder))
    description = fmpy.read_model_description(str(folder))
    name = description.coSimulation.modelIdentifier
    return folder / "binaries" / "linux64" / f"{name}.so", description.guid


def rounds(fmus: list[Path]) -> np.ndarray:
    """Microseconds: a row for each round, a column for each FMU and one for the bare functions of the first."""
    with tempfile.TemporaryDirectory() as temporary:
        folders = [Path(temporary, str(i)) for i in range(len(fmus))]
        libraries = [unpacked(fmu, folder) for fmu, folder in zip(fmus, folders)]
        program, sources = Path(temporary, "native_step"), f"-I{folders[0] / 'sources'}"
        cc(*COMPILE, sources, *(f"-I{path}" for path in INCLUDE), "-o", program,
           HERE / "native_step.c", HERE / "native_bare.c", "-lm", "-ldl")
        done = subprocess.run([program, *(word for pair in libraries for word in pair)], check=True,
                              capture_output=True, text=True)
    return np.array([line.split() for line in done.stdout.splitlines()], float)


def ratio(above: np.ndarray, below: np.ndarray) -> dict[str, float]:
    """Median and quartiles of the ratio of two columns, round by round."""
    low, median, high = np.quantile(above / below, [0.25, 0.5, 0.75])
    return {"ratio": float(median), "from": float(low), "to": float(high)}


def native(name: str) -> float:
    """One step of our native FMU, microseconds."""
    return float(rounds([found("native", name)])[:, 0].min())


def python(name: str, folder: Path, steps: int = 10) -> float:
    """One step of the Python flavour called through fmpy, microseconds."""
    fmpy.extract(str(found("python", name)), str(folder))
    slave = FMU2Slave(guid=fmpy.read_model_description(str(folder)).guid, unzipDirectory=str(folder),
                      modelIdentifier=name, instanceName="timed")
    slave.instantiate()
    slave.setupExperiment()
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    state, best = slave.getFMUState(), math.inf
    for _ in range(100):
        slave.setFMUState(state)
        began = time.perf_counter()
        for k in range(steps):
            slave.doStep(k * STEP, STEP)
        best = min(best, 1e6 * (time.perf_counter() - began) / steps)
    return best


def measure(names: tuple[str, ...] = NAMES, against: tuple[Path, ...] = ()) -> dict[str, dict]:
    """Name of an FMU -> its figures; `together` has their sum."""
    result: dict[str, dict] = {}
    for name in names:
        others = [path for path in against if path.stem == name]
        columns = rounds([found("native", name), *others]).T
        fmu, bare = columns[0], columns[-1]
        to_bare = ratio(fmu, bare)
        with tempfile.TemporaryDirectory() as folder:
            result[name] = {"native_us": float(fmu.min()), "bare_us": float(bare.min()), "ratio": to_bare["ratio"],
                            "ratio_spread": [to_bare["from"], to_bare["to"]], "python_us": python(name, Path(folder))}
        for path, column in zip(others, columns[1:-1]):
            result[name].setdefault("against", {})[str(path)] = {"native_us": float(column.min()),
                                                                 **ratio(fmu, column)}
    result["together"] = {"native_us": sum(row["native_us"] for row in result.values())}
    return result


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--law", action="append", metavar="NAME", help="an FMU to time, such as AhvBackstepping")
    parser.add_argument("--against", action="append", type=Path, default=[], metavar="FILE.fmu")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    figures = measure(tuple(options.law or NAMES), tuple(options.against))
    if options.json:
        print(json.dumps(figures))
        return
    for name, row in figures.items():
        spread, against = row.pop("ratio_spread", None), row.pop("against", {})
        print(f"{name:16}", "  ".join(f"{key} {value:.3g}" for key, value in row.items()),
              f"({spread[0]:.3g} to {spread[1]:.3g})" if spread else "")
        for path, other in against.items():
            print(f"{'':16} {other['ratio']:.3g} ({other['from']:.3g} to {other['to']:.3g}) of the "
                  f"{other['native_us']:.3g} us of {path}")


if __name__ == "__main__":
    main()
